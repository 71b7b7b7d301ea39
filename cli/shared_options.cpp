#include "cli/shared_options.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <limits>

#include "studies/compensate.h"

namespace sixdial::cli {

void add_subject(CLI::App& command, std::string& subject) {
  command.add_option("SESSION|BUNDLE", subject, "name, or folder with session.csv")->required();
}

CLI::Validator seed_number() {
  return {
      [](const std::string& text) {
        std::int64_t value = -1;
        const auto [end, trouble] =
            std::from_chars(text.data(), text.data() + text.size(), value);
        const bool whole = trouble == std::errc() && end == text.data() + text.size();
        return whole && value >= 0 ? std::string()
                                   : fmt::format(
                                         "{} is no seed: give a whole number from 0 to {}",
                                         text, std::numeric_limits<std::int64_t>::max());
      },
      "SEED"};
}

CLI::Option* add_seed(CLI::App& command, std::uint64_t& seed, const std::string& words) {
  return command.add_option("--seed", seed, words)->check(seed_number())->capture_default_str();
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
  command.add_flag(
      "--skip-bad-rows", skip_bad_rows,
      "of a bundle: leave out rows that cannot be read, and list them");
}

void add_tolerance(CLI::App& command, std::optional<double>& tolerance_mm) {
  command
      .add_option(
          "--tolerance", tolerance_mm,
          "mm: largest position error that is accepted, with the expanded uncertainty as guard "
          "band; default: tolerance_mm of the rig file, if it states one")
      ->check(CLI::Range(1e-6, 1e6));
}

void add_stored_result(CLI::App& command, std::int64_t& result) {
  command.add_option("--result", result, "number of a stored result; default: the newest")
      ->check(CLI::PositiveNumber);
}

void add_from_other_session(CLI::App& command, bool& allowed) {
  command.add_flag(
      "--from-other-session", allowed,
      "take a calibration or diagnosis that was made from other data than this session's");
}

void add_point_count(CLI::App& command, int& points) {
  command.add_option("--points", points, "how many points")
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
          "paper: filter, search and network exactly as printed; default: without known faults")
      ->check(CLI::IsMember({"default", "paper"}))
      ->default_str(std::string(calibration::to_string(profile)));
}

void add_fixed_parameters(
    CLI::App& command, std::vector<std::string>& fix, std::vector<std::string>& free) {
  command.add_option("--fix", fix, "parameters that keep their nominal value, such as d,alpha")
      ->delimiter(',');
  command.add_option("--free", free, "only these parameters are fitted")->delimiter(',');
}

void add_keep_gross_errors(CLI::App& command, bool& keep) {
  command.add_flag(
      "--keep-gross-errors", keep,
      "fit readings that do not agree with the rest too; they are listed in any case");
}

void add_threads(CLI::App& command, int& threads) {
  command
      .add_option(
          "--threads", threads,
          "threads to use, 0: as many as the machine has; the result is the same")
      ->check(CLI::Range(0, 256));
}

void add_count(
    CLI::App& command, const char* name, std::optional<int>& value, const char* words) {
  command.add_option(name, value, words)->check(CLI::Range(1, 1000000));
}

}  // namespace sixdial::cli
