#include "studies/turns_left.h"

#include "geometry/rotation.h"
#include "geometry/tool_turn.h"
#include "session/measured_turn.h"

namespace sixdial::studies {

std::vector<TurnLeft> turns_left(
    const session::Session& session, std::span<const simulation::Trial> trials,
    const Eigen::VectorXd& v) {
  const session::SampleLayout layout = session::layout_of(session.rig);
  std::vector<TurnLeft> turns;
  for (const simulation::Trial& trial : trials) {
    const auto turn =
        session::turn_of(session.samples[static_cast<std::size_t>(trial.sample)], layout);
    if (!turn) continue;
    const auto R = geometry::turn_of_tool(*session.rig.robot.model, v, trial.q, trial.assembly);
    if (!R) continue;
    const Eigen::Matrix3d measured = geometry::turned_by<double>(*turn);
    turns.push_back({trial.sample, geometry::turn_between(*R, measured)});
  }
  return turns;
}

}  // namespace sixdial::studies
