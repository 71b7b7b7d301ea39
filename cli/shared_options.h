// Options that several commands have: one spelling, one range and one help text for each.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calibration/pipeline.h"
#include "geometry/robots/five_bar.h"

namespace sixdial::cli {

void add_subject(CLI::App& command, std::string& subject);   // SESSION|BUNDLE
void add_result_file(CLI::App& command, std::string& file);  // -o: the result as JSON
void add_skip_bad_rows(CLI::App& command, bool& skip_bad_rows);
void add_stored_result(CLI::App& command, std::int64_t& result);  // --result
void add_from_other_session(CLI::App& command, bool& allowed);    // --from-other-session
void add_point_count(CLI::App& command, int& points);             // --points of a plan

/// --seed: a whole number from 0 on. CLI11 would make 18446744073709551615 of -1.
CLI::Option* add_seed(CLI::App& command, std::uint64_t& seed, const std::string& words);
/// The same for another option of this kind.
[[nodiscard]] CLI::Validator seed_number();

/// A file that is there.
[[nodiscard]] CLI::Validator existing_file();

/// "++", "+-", "-+" or "--".
[[nodiscard]] CLI::IsMember working_mode_words();
/// "before", "kinematics", "full", "extended" or "extended_full"; "recommended" too where a
/// choice may be left to the program.
[[nodiscard]] CLI::IsMember compensation_words(bool with_recommended = false);

void add_profile(CLI::App& command, calibration::Profile& profile);
void add_fixed_parameters(
    CLI::App& command, std::vector<std::string>& fix, std::vector<std::string>& free);
/// --tolerance: of a calibration or a report.
void add_tolerance(CLI::App& command, std::optional<double>& tolerance_mm);
void add_keep_gross_errors(CLI::App& command, bool& keep);
void add_threads(CLI::App& command, int& threads);
/// How often something is repeated: "instead of 100".
void add_count(
    CLI::App& command, const char* name, std::optional<int>& value, const char* words);

/// Sizes of the searches and of the network. `Request`: of a calibration or a comparison.
template <class Request>
void add_search_sizes(CLI::App& command, Request& request) {
  command.add_option("--particles", request.particles, "instead of 50")
      ->check(CLI::Range(4, 10000));
  add_count(command, "--qpso1-iterations", request.qpso1_iterations, "instead of 100");
  add_count(command, "--qpso2-iterations", request.qpso2_iterations, "instead of 400");
  add_count(command, "--anfis-epochs", request.anfis_epochs, "instead of 500");
}

}  // namespace sixdial::cli
