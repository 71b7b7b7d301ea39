// The uncertainty budget of the tool's position, as the GUM (JCGM 100:2008, 8) asks for it:
// each source with its standard uncertainty, its sensitivity, what it contributes, its share.
//
// Two positions have one each: a position that three dials measured once, and the place where
// the tool stands when it is commanded by the identified parameters, to which every reading of
// the session contributes through the fit. All lengths are distances of the tool, its
// coordinates together (root of the sum of their variances), as root mean square over the
// poses of G1.
//
//   for (const BudgetRow& row : budgets.front().rows) show(row.contribution_mm);
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/fit_covariance.h"
#include "calibration/noise.h"
#include "diagnosis/rig_fit.h"
#include "session/session.h"
#include "simulation/trial.h"

namespace sixdial::studies {

enum class Measurand {
  kMeasured,   // a position that dials (or another instrument) measured once
  kCommanded,  // where the tool stands, commanded by the identified parameters
};

enum class BudgetSource {
  kRepeatability,  // of the dials' readings
  kResolution,     // of the dials
  kInstrument,     // of one that gives positions: its standard deviation
  kDialCurve,      // a dial's own error curve, within its maker's limit
  kRig,            // the rig's geometry, kind by kind
  kFittedAlong,    // rig and curves where they were fitted along with the robot: as one, since
                   // what the readings say of one depends on the others
  kOpen,           // what the poses leave open, held at nominal
  kFit,            // what the fit leaves beyond the dials' own
  kArrival,        // the tool comes back to another place each time
  kTemperature,
};

enum class BudgetState {
  kCounted,
  kExact,      // stated as 0
  kNotStated,  // nobody says: not in the combined figure, and not zero
  kContained,  // for information: counted within the row of the fit
  kPart,       // of kFittedAlong: what would go if this alone were known exactly (more than its
               // part where others are known only with it)
};

struct BudgetRow {
  BudgetSource source = BudgetSource::kRepeatability;
  std::string of{};          // "A" of a dial; "side of the cuboid" of the rig
  std::string not_stated{};  // of which dials, where only some are not stated
  BudgetState state = BudgetState::kCounted;
  bool by_statistics = false;  // evaluated as the GUM's type A, else type B
  std::string unit{"mm"};      // of `standard`: mm, rad, degC
  // NaN: not known.
  double standard = 0.0;         // standard uncertainty of the source, k = 1
  double sensitivity = 0.0;      // mm per unit
  double contribution_mm = 0.0;  // sensitivity x standard
  double share = 0.0;            // of the combined variance; those that are counted add up to 1
};

struct UncertaintyBudget {
  Measurand measurand = Measurand::kMeasured;
  std::vector<BudgetRow> rows{};
  int places = 0;            // poses over which the figures are means
  double combined_mm = 0.0;  // k = 1
  double expanded_mm = 0.0;  // k = geometry::kCoverage
  bool complete = true;      // false: something is not stated, and U is too small
};

/// What the budgets are made of: the least-squares fit of the positions of G1.
struct BudgetInput {
  const calibration::ObservationSpace& space;  // of positions
  const calibration::LeastSquaresFit& fit;
  calibration::Weighting weighting;
  const calibration::NoiseEstimate& noise;
  const calibration::Structure& structure;
  std::span<const simulation::Trial> g1;
  const session::Session& session;
  const diagnosis::RigFit* rig = nullptr;  // null: nothing is stated, or it was not fitted
};

/// kMeasured and kCommanded, in this order. A robot's kind and the instrument's do not matter.
[[nodiscard]] std::vector<UncertaintyBudget> uncertainty_budgets(const BudgetInput& input);

}  // namespace sixdial::studies
