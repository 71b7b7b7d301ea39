// Readings that stand out from everything else a session says: a dial bumped, a misread digit,
// a chip under a tip. Found in the raw readings, where the dial can be named, by a robust fit
// (in positions where an instrument gives nothing else). What neighbouring poses share is no
// accident but something the model misses, and is left to the diagnosis.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibration/identifier.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

class PositionJudge;
class ReadingJudge;

struct GrossError {
  int sample = 0;            // row of the session
  int dial = -1;             // index in the rig; -1: the position as a whole
  double size_mm = 0.0;      // measured - expected from everything else; a distance if dial < 0
  double times_sigma = 0.0;  // size over its robust standard deviation
};

struct GrossErrorCheck {
  std::vector<GrossError> found;         // by sample, then dial
  double sigma_mm = 0.0;                 // robust standard deviation of one good reading
  std::vector<double> sigma_by_dial_mm;  // the same, dial by dial
  double limit_times_sigma = 0.0;
  int readings = 0;  // that were judged
  /// So many readings stand out that they cannot be accidents: a dial, the rig file or the
  /// model is wrong. `found` is left empty then.
  int systematic = 0;
  /// Empty, or why the check could not judge: "6 readings for 10 parameters ...".
  std::string not_possible;
  Eigen::VectorXd x;  // of the last fit, parameters of the space; empty if not possible
  std::shared_ptr<const PositionJudge> positions;  // null: dial readings were judged
  /// What the good readings say, made when it is asked for. Empty where x is.
  std::function<std::shared_ptr<const ReadingJudge>()> judge_of_dials;
};

/// Looks in the dial readings where there are any, else in the positions (PositionJudge). Each
/// round takes the worst reading of each sample, or the worst position, out and fits again, so
/// that one bad reading does not accuse its neighbours. `settings`: fixed parameters and noise;
/// its loss is ignored.
[[nodiscard]] GrossErrorCheck find_gross_errors(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    const IdentifySettings& settings = {});

/// Which of `trials`' readings stand out from what x (of an earlier check) expects; for sets
/// that must not be fitted.
[[nodiscard]] GrossErrorCheck judge_readings(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    const GrossErrorCheck& fitted);

}  // namespace sixdial::calibration
