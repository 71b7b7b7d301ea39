// A stored calibration result and its session in, report files out: the same code for the
// service and for `sixdial report BUNDLE`.
//
// Example:
//   const auto result = studies::calibrate(session, {.method = "lm"});
//   const auto files = write_report(result, session, "A. Person", folder);
//   files.front();  // -> "report.html"
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/report_data.h"
#include "session/session.h"
#include "studies/calibration_result.h"
#include "studies/compare.h"
#include "studies/diagnosis_result.h"
#include "studies/validate.h"

namespace sixdial::report {

/// The head of a result's report: session, instruments, conditions, provenance, and the
/// settings by name.
[[nodiscard]] report::Head report_head(
    const studies::Inputs& inputs, std::vector<std::pair<std::string, std::string>> settings,
    const session::Session& session, const std::string& operator_name,
    std::optional<session::TimePoint> made = std::nullopt);

/// What a report tells of besides its result, and under which tolerance and time; null: none.
struct Companions {
  const studies::ComparisonResult* comparison = nullptr;
  const studies::DiagnosisResult* diagnosis = nullptr;
  const studies::ValidationResult* validation = nullptr;
  std::optional<double> tolerance_mm{};      // instead of the result's or the rig file's
  std::optional<session::TimePoint> made{};  // by the clock of the samples; else this machine's
};

/// Throws StudyError bad_data where the result was made from other data than the session holds.
[[nodiscard]] report::ReportData report_data(
    const studies::CalibrationResult& result, const session::Session& session,
    const std::string& operator_name, const Companions& companions = {});

/// report.html, report.json, the CSV tables, calibration.json (the result), recommendation.json
/// (which model to command by, and its parameters), comparison.json, diagnosis.json and
/// validation.json (where there are such) and, in bundle/, session.csv and rig.toml. The
/// folder is made if absent; files of these names are replaced. `more`: sections that come
/// before all others. Returns the files, relative to the folder. Throws StudyError file.
[[nodiscard]] std::vector<std::string> write_report(
    const studies::CalibrationResult& result, const session::Session& session,
    const std::string& operator_name, const std::filesystem::path& folder,
    const Companions& companions = {}, std::vector<report::Section> more = {});

}  // namespace sixdial::report
