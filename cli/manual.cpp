#include "cli/manual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace sixdial::cli {
namespace {

std::string roff(const std::string& text) {
  std::string out;
  bool line_start = true;
  for (const char c : text) {
    if (line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
    line_start = c == '\n';
  }
  return out;
}

std::string upper(std::string text) {
  std::ranges::transform(
      text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string options_of(const CLI::App& app) {
  std::string out;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    std::string name = option->get_name(true, true);
    std::ranges::replace(name, ',', ' ');
    const bool takes_value = option->get_items_expected_max() > 0 && !option->get_positional();
    out += fmt::format(
        ".TP\n\\fB{}\\fR{}\n{}\n", roff(name),
        takes_value ? " \\fI" + roff(option->get_type_name()) + "\\fR" : "",
        roff(option->get_description()));
  }
  return out;
}

void commands_of(const CLI::App& app, const std::string& path, std::string& out) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;
    const std::string name = path + " " + command->get_name();
    const bool has_own = command->get_subcommands([](const CLI::App*) { return true; }).empty();
    if (has_own) {
      out += fmt::format(
          ".SS {}\n{}\n{}", roff(name), roff(command->get_description()), options_of(*command));
    }
    commands_of(*command, name, out);
  }
}

std::string words_of(const CLI::App& app) {
  std::string words;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!command->get_group().empty()) words += command->get_name() + " ";
  }
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : option->get_lnames()) words += "--" + name + " ";
  }
  if (!words.empty()) words.pop_back();
  return words;
}

/// Takes the name of a session that there is.
bool takes_session(const CLI::App& app) {
  return std::ranges::any_of(app.get_options(), [&](const CLI::Option* option) {
    const std::string name = option->get_name(true, true);
    const bool existing = app.get_name() != "create";
    return option->get_positional() && existing &&
           (name.find("SESSION") != std::string::npos || name == "NAME");
  });
}

void cases_of(
    const CLI::App& app, const std::string& path, std::string& known, std::string& cases) {
  cases += fmt::format(
      "    \"{}\") words=\"{}\"{} ;;\n", path, words_of(app),
      takes_session(app) ? " sessions=1" : "");
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;
    const std::string name =
        path.empty() ? command->get_name() : path + " " + command->get_name();
    known += fmt::format("{}\"{}\"", known.empty() ? "" : " | ", name);
    cases_of(*command, name, known, cases);
  }
}

}  // namespace

std::string manual_page(const CLI::App& app, int section, bool talks_to_service) {
  std::string about = app.get_description();
  const std::string first = about.substr(0, about.find('\n'));
  std::string commands;
  commands_of(app, app.get_name(), commands);
  std::string page = fmt::format(
      ".\\\" Made by {0} from the table of its commands.\n.TH {1} {2} \"\" \"Sixdial {3}\" "
      "\"Sixdial\"\n.SH NAME\n{0} \\- {4}\n.SH SYNOPSIS\n.B {0}\n[options]{5}\n.SH "
      "DESCRIPTION\n{6}\n.SH OPTIONS\n{7}",
      roff(app.get_name()), upper(app.get_name()), section, SIXDIAL_VERSION, roff(first),
      commands.empty() ? "" : " \\fIcommand\\fR ...", roff(about), options_of(app));
  if (!commands.empty()) page += ".SH COMMANDS\n" + commands;
  if (!talks_to_service) return page + ".SH SEE ALSO\n.BR sixdial (1),\n.BR sixdiald (8)\n";
  page +=
      ".SH FILES\n.TP\n.I $XDG_RUNTIME_DIR/sixdial/sixdiald.sock, else "
      "/run/sixdial/sixdiald.sock\nThe socket of the service.\n.TP\n.I "
      "$STATE_DIRECTORY/sixdial.db, else ~/.local/share/sixdial/sixdial.db\nThe "
      "database.\n.SH SEE ALSO\n.BR sixdial (1),\n.BR sixdiald (8)\n";
  return page;
}

std::string bash_completion(const CLI::App& app) {
  std::string known;
  std::string cases;
  cases_of(app, "", known, cases);
  return fmt::format(
      R"bash(# bash completion of {0}; made by `{0} completion` from the table of its commands.
_{0}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before= path= words= sessions= longer i asked=()
  ((COMP_CWORD > 0)) && before=${{COMP_WORDS[COMP_CWORD-1]}}
  for ((i = 1; i < COMP_CWORD; i++)); do
    [[ ${{COMP_WORDS[i]}} == --socket ]] && asked=(--socket "${{COMP_WORDS[i+1]}}")
    longer=${{path:+$path }}${{COMP_WORDS[i]}}
    case $longer in
      {1}) path=$longer ;;
    esac
  done
  case $path in
{2}  esac
  case $before in
    --session | --against) words= sessions=1 ;;
    --plan | --rig | --calibration | --diagnosis-file | --report | --pdf | --output | -o | --db | --socket)
      COMPREPLY=($(compgen -f -- "$current"))
      return ;;
  esac
  if [[ $sessions && $current != -* ]]; then
    # Asks the service, if one runs; without one no names.
    words="$words $(command {0} "${{asked[@]}}" session list 2>/dev/null | awk 'NR > 1 {{print $1}}')"
  fi
  COMPREPLY=($(compgen -W "$words" -- "$current"))
}}
complete -o default -F _{0} {0}
)bash",
      app.get_name(), known, cases);
}

}  // namespace sixdial::cli
