#include "cli/shared_options.h"

#include <filesystem>

#include "studies/compensate.h"

namespace sixdial::cli {

void add_subject(CLI::App& command, std::string& subject) {
  command.add_option("SESSION|BUNDLE", subject, "name, or folder with session.csv")->required();
}

CLI::Validator existing_file() {
  return {
      [](const std::string& name) {
        return std::filesystem::exists(name) && !std::filesystem::is_directory(name)
                   ? std::string()
                   : "there is no such file: " + name;
      },
      "FILE"};
}

void add_result_file(CLI::App& command, std::string& file) {
  command.add_option("-o,--output", file, "the whole result as a JSON file");
}

void add_skip_bad_rows(CLI::App& command, bool& skip_bad_rows) {
  command.add_flag("--skip-bad-rows", skip_bad_rows, "of a bundle");
}

void add_stored_result(CLI::App& command, std::int64_t& result) {
  command.add_option("--result", result, "a stored result; default: the newest");
}

void add_point_count(CLI::App& command, int& points) {
  command.add_option("--points", points, "so many")
      ->check(CLI::Range(1, 400))
      ->capture_default_str();
}

CLI::IsMember working_mode_words() {
  std::vector<std::string> words;
  for (const geometry::WorkingMode mode : geometry::kWorkingModes) {
    words.push_back(geometry::to_string(mode));
  }
  return CLI::IsMember(words);
}

CLI::IsMember compensation_words(bool with_recommended) {
  std::vector<std::string> words{"before", "kinematics", "full", "extended", "extended_full"};
  if (with_recommended) words.insert(words.begin(), "recommended");
  return CLI::IsMember(words);
}

void add_profile(CLI::App& command, calibration::Profile& profile) {
  command
      .add_option_function<std::string>(
          "--profile",
          [&profile](const std::string& word) {
            profile = calibration::profile_from(word).value_or(profile);
          },
          "paper: its literal choices of filter, search and network")
      ->check(CLI::IsMember({"default", "paper"}))
      ->default_str(std::string(calibration::to_string(profile)));
}

void add_fixed_parameters(
    CLI::App& command, std::vector<std::string>& fix, std::vector<std::string>& free) {
  command.add_option("--fix", fix, "parameters that stay nominal, such as d,alpha")
      ->delimiter(',');
  command.add_option("--free", free, "only these are fitted")->delimiter(',');
}

void add_keep_gross_errors(CLI::App& command, bool& keep) {
  command.add_flag(
      "--keep-gross-errors", keep, "list readings that stand out, but fit them too");
}

void add_threads(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "0: as many as there are; same result")
      ->check(CLI::Range(0, 256));
}

void add_count(
    CLI::App& command, const char* name, std::optional<int>& value, const char* words) {
  command.add_option(name, value, words)->check(CLI::Range(1, 1000000));
}

}  // namespace sixdial::cli
