#include "studies/stored_warnings.h"

#include <string>
#include <utility>
#include <vector>

#include "session/bundle.h"
#include "session/trials.h"
#include "studies/inputs.h"
#include "studies/plausibility.h"
#include "studies/plausibility_of_fit.h"

namespace sixdial::studies {
namespace {

bool is_of(const Inputs& inputs, const session::Session& session) {
  return inputs.data_hash == std::string(kHashPrefix) + session::data_sha256(session);
}

void say_in_doubt(std::vector<Warning>& found, const char* what) {
  if (found.empty()) return;
  found.push_back(
      {std::string(kMadeUnjudged), Severity::kDoubt, {}, {{"what", std::string(what)}}});
}

}  // namespace

void judge_stored(CalibrationResult& stored, const session::Session& session) {
  if (stored.warnings || !is_of(stored.inputs, session)) return;
  PlausibleSession judged = plausible(session);
  std::vector<std::string> fixed;
  for (const ParameterRow& row : stored.parameters) {
    if (row.fixed) fixed.push_back(row.name);
  }
  const geometry::Rig& rig = judged.session.rig;
  add_too_few_poses(judged.warnings, session::trials_of(judged.session, "G1"), rig, fixed, {});
  add(implausible_lengths(stored.parameters, *rig.robot.model), judged.warnings);
  add(far_angles(stored.parameters, *rig.robot.model), judged.warnings);
  say_in_doubt(judged.warnings, "calibration");
  stored.warnings = std::move(judged.warnings);
}

void judge_stored(DiagnosisResult& stored, const session::Session& session) {
  if (stored.warnings || !is_of(stored.inputs, session)) return;
  PlausibleSession judged = plausible(session);
  say_in_doubt(judged.warnings, "diagnosis");
  stored.warnings = std::move(judged.warnings);
}

}  // namespace sixdial::studies
