// The report's sections on what the studies found, one source file each.
#pragma once

#include <string>
#include <vector>

#include "report/document.h"
#include "report/documents/json.h"
#include "session/session.h"
#include "studies/calibration_result.h"
#include "studies/compare.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// The report's sections: uncertainty with its map and both spaces side by side (`precision`
/// may be empty), what the data cannot tell.
[[nodiscard]] std::vector<Section> assessment_sections(
    const studies::Assessment& assessment, const std::optional<studies::Precision>& precision,
    bool has_dials = true);

/// The report's section with the uncertainty budget of the tool's position; none where there
/// is none.
[[nodiscard]] std::vector<Section> budget_sections(
    const std::vector<studies::UncertaintyBudget>& budgets);

/// The report's section with Table 6 of all methods and what each identified.
[[nodiscard]] std::vector<Section> comparison_sections(const studies::ComparisonResult& result);

/// The report's section: size, effective parameters, sizes that were offered, membership
/// functions.
[[nodiscard]] std::vector<Section> anfis_sections(const studies::Networks& networks);
/// The same of whichever residual model a calibration has; none where it has none.
[[nodiscard]] std::vector<Section> residual_model_sections(
    const studies::CalibrationResult& result);

/// What else the page is about.
enum class Beside {
  kNothing,
  kCalibration,  // whose sections list the readings that stand out and the parameters
};
/// The report's sections: causes with their signatures, what is left, gain, parameters, what
/// could not be tested, limits.
[[nodiscard]] std::vector<Section> diagnosis_sections(
    const studies::DiagnosisResult& result, Beside beside = Beside::kNothing);

/// A page of the diagnosis alone, as HTML.
[[nodiscard]] std::string diagnosis_page(
    const studies::DiagnosisResult& result, const session::Session& session,
    const std::string& operator_name);

}  // namespace sixdial::report
