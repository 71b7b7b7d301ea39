// Validation, Fig. 7: targets that were never fitted are commanded on the real robot with
// nominal, identified and fully compensated angles, measured again, and the error really
// reached is told, equation (41). A session of its own holds the samples, raw as any other.
#pragma once

#include <string>
#include <vector>

#include "session/session.h"
#include "studies/compensate.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

inline constexpr int kValidationSchemaVersion = 1;

struct ValidationRequest {
  std::string set = "G2";  // of the calibrated session: its targets
  std::vector<CompensateBy> by{
      CompensateBy::kBefore, CompensateBy::kKinematics, CompensateBy::kFull};
};

/// "G2.full": the set that one way's samples are stored under.
[[nodiscard]] std::string validation_set(const std::string& set, CompensateBy by);

/// A target after the other, each commanded in all the ways asked for in turn, so that drift
/// does not favour one. `diagnosis`: needed where the request has kExtended. Throws Error
/// bad_data: no targets in that set, no solution.
[[nodiscard]] session::Plan validation_plan(
    const session::Session& calibrated, const Json& calibration,
    const ValidationRequest& request, const DiagnosisResult* diagnosis = nullptr);

/// "sixdial.validation": inputs, methods [{id, name, set, errors {mean_mm, std_mm, max_mm,
/// rmse_mm, points}, predicted, without_position}], points. `validation`: what was measured;
/// `diagnosed_gain`: what the diagnosis predicts of the extended model, as a row of its "gain".
[[nodiscard]] Json validation_document(
    const session::Session& calibrated, const Json& calibration,
    const session::Session& validation, const ValidationRequest& request,
    const Json& diagnosed_gain = nullptr);

/// The table for people: mean, std, max before, after kinematics, after ANFIS.
[[nodiscard]] std::string validation_text(const Json& document);

}  // namespace sixdial::studies
