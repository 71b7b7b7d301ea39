// What naming a cause gains on points that were not fitted: position error and residual by dial
// on G2, for the nominal, the calibrated and the extended model, the last two also with a
// network on top, and for the extended model less each cause in turn. All models are fitted on
// G1; which readings of G2 are gross, and so judged by none of them, says the fit to the whole
// session.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "diagnosis/naming.h"
#include "diagnosis/tool_shift.h"

namespace sixdial::diagnosis {

/// What answers for a sample that was not fitted.
enum class GainModel {
  kNominal,     // the robot as drawn
  kCalibrated,  // the fitted robot
  kExtended,    // robot and all named causes
  kWithout,     // the same less one cause
};

struct GainRow {
  GainModel model = GainModel::kNominal;
  bool network = false;               // with a network on joint angles on top
  std::optional<Hypothesis> without;  // of kWithout: the cause left out
  /// Position error [mm] of a sample: the shift of the tool that explains its residuals best.
  double mean_mm = 0.0, std_mm = 0.0, max_mm = 0.0;
  double rms_mm = 0.0;                 // of the readings
  std::vector<double> rms_by_dial_mm;  // in the order of rig.dials (or x, y); NaN: none
  /// Mean position error less that of "calibrated", with a 95 % interval over the poses.
  double difference_mm = 0.0, low_mm = 0.0, high_mm = 0.0;
  /// Share of the mean square of the calibrated model's residuals (readings), less the noise,
  /// that this model removes; NaN where there is hardly anything to remove.
  double removed_share = 0.0;
};

struct GainStudy {
  std::vector<GainRow> rows;
  JointFit calibrated, extended;    // on G1
  std::vector<JointFit> without;    // on G1, less each cause
  std::vector<double> g2_log_odds;  // of each cause: G2's readings with it, less without
  int excluded = 0;                 // samples of G2 with a gross reading
};

struct GainSettings {
  int draws = 2000;
  std::uint64_t seed = 1;
  double noise_mm = 0.002;
  bool networks = true;
  bool table = true;  // false: the odds of the causes alone, no rows
};

/// The same readings twice: once G1 is fitted, once G2 is judged.
struct FittedAndJudged {
  Readings fitted;  // G1
  Readings judged;  // G2
};

/// What is judged, and on what.
struct GainQuestion {
  const Readings& all;        // as they were explained: exchanged dials set right
  FittedAndJudged explained;  // the same, by side
  /// Where dials were exchanged: the readings as they were measured, by which the models
  /// without causes are judged.
  std::optional<FittedAndJudged> as_measured;
  const JointFit& baseline;
  const JointFit& extended;        // names the causes, and says where to start
  std::vector<OwnCurve> curves{};  // that go with it
};
[[nodiscard]] GainStudy study_gain(
    const GainQuestion& question, const GainSettings& settings,
    const std::stop_token& stop = {});

}  // namespace sixdial::diagnosis
