#include "cli/usage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "service/methods/method.h"
#include "session/nearest.h"

namespace sixdial::cli {
namespace {

struct Example {
  std::string_view command, words;
};
constexpr std::array kExamples{
    Example{"import", "sixdial import measured.csv --map map.toml -o FOLDER"},
    Example{"collect", "sixdial collect plan.csv --session monday --rig rig.toml"},
    Example{"dials", "sixdial dials --rig rig.toml --check"},
    Example{"calibrate", "sixdial calibrate monday"},
    Example{"compare", "sixdial compare monday"},
    Example{"diagnose", "sixdial diagnose monday"},
    Example{"report", "sixdial report monday -o monday-report"},
    Example{"recommend", "sixdial recommend monday"},
    Example{"compensate", "sixdial compensate monday --target 28,48"},
    Example{"validate", "sixdial validate monday"},
    Example{"export-model", "sixdial export-model monday --as python -o robot.py"},
    Example{"plan random", "sixdial plan random --rig rig.toml --count 100 -o plan.csv"},
    Example{"plan grid", "sixdial plan grid --rig rig.toml --nx 10 --ny 10 -o plan.csv"},
    Example{"plan next", "sixdial plan next monday -o next.csv"},
    Example{"plan rig-check", "sixdial plan rig-check --rig rig.toml -o check.csv"},
    Example{
        "plan sockets",
        "sixdial plan sockets --rig arm.toml --at 260 -90 40 --at 260 90 140 --distance 206 "
        "--bundle FOLDER"},
    Example{"plan separate", "sixdial plan separate monday -o apart.csv"},
    Example{"session create", "sixdial session create monday --rig rig.toml"},
    Example{"session show", "sixdial session show monday"},
    Example{"session import", "sixdial session import FOLDER --name monday"},
    Example{"session export", "sixdial session export monday FOLDER"},
    Example{"session undo", "sixdial session undo monday"},
    Example{"job status", "sixdial job status 1"},
    Example{"job wait", "sixdial job wait 1"},
    Example{"job cancel", "sixdial job cancel 1"}};

/// What a newcomer may type for a command of another name.
const std::map<std::string, std::string, std::less<>>& synonyms() {
  static const std::map<std::string, std::string, std::less<>> kSynonyms{
      {"measure", "collect"},   {"start", "collect"},       {"run", "collect"},
      {"resume", "collection"}, {"pause", "collection"},    {"stop", "collection"},
      {"status", "collection"}, {"watch", "collection"},    {"sessions", "session"},
      {"jobs", "job"},          {"check", "doctor"},        {"analyse", "diagnose"},
      {"analyze", "diagnose"},  {"causes", "diagnose"},     {"correct", "compensate"},
      {"convert", "import"},    {"export", "export-model"}, {"urdf", "export-model"},
      {"undo", "session"},      {"live", "dials"},          {"dial", "dials"},
      {"push", "dials"},        {"verify", "validate"},     {"calibration", "calibrate"},
      {"diagnosis", "diagnose"}};
  return kSynonyms;
}

const CLI::App* deepest(const CLI::App* app, std::string& path) {
  for (;;) {
    const auto parsed = app->get_subcommands();
    if (parsed.empty()) return app;
    app = parsed.back();
    path += (path.empty() ? "" : " ") + app->get_name();
  }
}

std::vector<std::string> verbs_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* each : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!each->get_group().empty()) names.push_back(each->get_name());
  }
  return names;
}

std::vector<std::string> options_of(const CLI::App& root, const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* app : {&command, &root}) {
    for (const CLI::Option* option : app->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

std::string meant(const std::string& word, const std::vector<std::string>& known) {
  const std::vector<std::string_view> names(known.begin(), known.end());
  const auto nearest = session::nearest_name(word, names);
  return nearest ? fmt::format("; did you mean '{}'?", *nearest) : std::string();
}

/// A word that no command took, and what it may have meant.
std::string about_word(
    const CLI::App& root, const CLI::App& command, const std::string& name,
    const std::string& word) {
  if (word.starts_with('-')) {
    const std::string option = word.substr(0, word.find('='));
    return fmt::format(
        "'{}' has no option {}{}", name, option, meant(option, options_of(root, command)));
  }
  const std::vector<std::string> verbs = verbs_of(command);
  if (verbs.empty()) {
    return fmt::format("'{}' is one word too many for '{}'", word, name);
  }
  const auto other = synonyms().find(word);
  const bool known_otherwise = &root == &command && other != synonyms().end() &&
                               std::ranges::find(verbs, other->second) != verbs.end();
  return fmt::format(
      "'{}' has no command '{}'{}", name, word,
      known_otherwise ? fmt::format("; did you mean '{}'?", other->second)
                      : meant(word, verbs));
}

std::string with(std::string text, std::string_view what, const std::string& instead) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + instead.size())) {
    text.replace(at, what.size(), instead);
  }
  return text;
}

/// Whether the plan that `collect` was given is no file.
bool lacks_its_plan(const CLI::App& command) {
  const CLI::Option* plan = command.get_option_no_throw("PLAN");
  return plan != nullptr && !plan->results().empty() &&
         !std::filesystem::exists(plan->results().front());
}

std::string advice_to_plan(const std::string& then) {
  return "sixdial plan random --rig rig.toml --count 100 -o plan.csv" + then;
}

}  // namespace

Json usage_error(const CLI::App& app, const CLI::ParseError& error) {
  std::string path;
  const CLI::App* command = deepest(&app, path);
  const std::string name = path.empty() ? "sixdial" : "sixdial " + path;
  const std::vector<std::string> verbs = verbs_of(*command);
  std::vector<std::string> extra;
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr || !verbs.empty()) {
    extra = app.remaining(true);
  }
  std::string what = error.what();
  if (!extra.empty()) {
    // An option of a command that was not understood is not the first fault.
    std::string word = extra.front();
    if (!verbs.empty()) {
      for (const std::string& each : extra) {
        if (each.starts_with('-')) continue;
        word = each;
        break;
      }
    }
    what = about_word(app, *command, name, word);
  } else if (!verbs.empty()) {
    what = fmt::format("'{}' needs a command", name);
  }
  std::string hint;
  for (const Example& example : kExamples) {
    if (example.command == path) hint = fmt::format("For example: {}\n  ", example.words);
  }
  if (path == "collect" && lacks_its_plan(*command)) {
    hint = fmt::format("Make a plan first: {}\n  ", advice_to_plan(""));
  }
  if (!verbs.empty()) hint += fmt::format("Commands: {}\n  ", fmt::join(verbs, ", "));
  hint += fmt::format("{} --help tells more", name);
  return {
      {"code", service::error_kind(service::ErrorCode::kInvalidParams).number},
      {"message", what},
      {"data",
       {{"code", service::error_kind(service::ErrorCode::kInvalidParams).code},
        {"retry", false},
        {"at", Json::object()},
        {"hint", hint}}}};
}

Json in_commands(Json error_object) {
  if (!error_object.contains("data") || !error_object["data"].contains("hint")) {
    return error_object;
  }
  Json& data = error_object["data"];
  std::string session = "SESSION";
  if (data.contains("at") && data["at"].contains("session") &&
      data["at"]["session"].is_string()) {
    session = data["at"]["session"].get<std::string>();
  }
  auto hint = data["hint"].get<std::string>();
  const service::ErrorKind* kind = service::find_error_kind(error_object.value("code", 0));
  if (kind != nullptr && hint == kind->hint && !kind->command_hint.empty()) {
    hint = kind->command_hint;
  }
  for (const service::RpcMethod* method : service::all_methods()) {
    if (method->command.empty()) continue;
    hint = with(
        std::move(hint), method->name,
        with(std::string(method->command), "{session}", session));
  }
  const std::string missing = data.contains("at") && data["at"].is_object()
                                  ? data["at"].value("missing", std::string())
                                  : std::string();
  if (missing == "plan") {
    hint =
        "Give one: " + advice_to_plan("; then: sixdial collect plan.csv --session " + session);
  } else if (missing == "session") {
    hint += "; sixdial session list shows them all, sixdial session create makes one";
  }
  data["hint"] = hint;
  return error_object;
}

}  // namespace sixdial::cli
