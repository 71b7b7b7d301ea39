// A stored calibration result and its session in, report files out: the same code for the
// service and for `sixdial report BUNDLE`.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "report/documents/json.h"
#include "report/report_data.h"
#include "session/session.h"
#include "studies/calibration_result.h"

namespace sixdial::report {

/// The head of any document's report: session, instruments, conditions, provenance.
[[nodiscard]] report::Head report_head(
    const Json& document, const session::Session& session, const std::string& operator_name);

/// The same from what a result was made from and its settings by name.
[[nodiscard]] report::Head report_head(
    const studies::Inputs& inputs, std::vector<std::pair<std::string, std::string>> settings,
    const session::Session& session, const std::string& operator_name);

/// `comparison`: "sixdial.comparison" or null; `diagnosis`: "sixdial.diagnosis" or null. Throws
/// Error bad_data where the result was made from other data than the session holds.
[[nodiscard]] report::ReportData report_data(
    const studies::CalibrationResult& result, const session::Session& session,
    const std::string& operator_name, const Json& comparison = nullptr,
    const Json& diagnosis = nullptr);

/// report.html, report.json, the CSV tables, calibration.json (the result), comparison.json
/// and diagnosis.json (where there are such) and, in bundle/, session.csv and rig.toml. The
/// folder is made if absent; files of these names are replaced. `more`: sections after the own
/// ones. Returns the files, relative to the folder. Throws Error file.
[[nodiscard]] std::vector<std::string> write_report(
    const studies::CalibrationResult& result, const session::Session& session,
    const std::string& operator_name, const std::filesystem::path& folder,
    const Json& comparison = nullptr, const Json& diagnosis = nullptr,
    std::vector<report::Section> more = {});

}  // namespace sixdial::report
