#include "studies/turn_errors.h"

#include <algorithm>

#include "calibration/reading_space.h"
#include "geometry/rotation.h"
#include "geometry/tool_turn.h"
#include "session/measured_turn.h"
#include "session/trials.h"

namespace sixdial::studies {

bool turns_were_fitted(const std::vector<TurnErrors>& errors) {
  return std::ranges::find(errors, "G1", &TurnErrors::set) != errors.end();
}

std::vector<TurnErrors> turn_errors(
    const session::Session& session, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified) {
  std::vector<TurnErrors> result;
  if (!calibration::fits_turns(session.rig)) return result;
  const session::SampleLayout layout = session::layout_of(session.rig);
  const geometry::RobotModel& robot = *session.rig.robot.model;
  std::vector<geometry::Pose<double>> X(robot.frames.size());
  for (const std::string set : {"G1", "G2"}) {
    TurnErrors errors{.set = set};
    for (const simulation::Trial& trial : session::trials_of(session, set)) {
      const auto turn =
          session::turn_of(session.samples[static_cast<std::size_t>(trial.sample)], layout);
      if (!turn) continue;
      const Eigen::Matrix3d measured = geometry::turned_by<double>(*turn);
      if (!robot.forward(nominal, trial.q, trial.assembly, X)) continue;
      const double before_rad = geometry::turn_between(X[0].R, measured);
      if (!robot.forward(identified, trial.q, trial.assembly, X)) continue;
      const double rad = geometry::turn_between(X[0].R, measured);
      ++errors.poses;
      errors.before_mean_rad += (before_rad - errors.before_mean_rad) / errors.poses;
      errors.mean_rad += (rad - errors.mean_rad) / errors.poses;
      errors.before_max_rad = std::max(errors.before_max_rad, before_rad);
      errors.max_rad = std::max(errors.max_rad, rad);
    }
    if (errors.poses > 0) result.push_back(errors);
  }
  return result;
}

}  // namespace sixdial::studies
