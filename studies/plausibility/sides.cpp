// Columns that say from which side each joint came, with the other sign: what went up, they say
// came from above. The moves from row to row tell.
#include "session/sample_layout.h"
#include "simulation/circumstances.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {

void look_at_sides(Look& look) {
  std::vector<simulation::Trial> trials;
  std::vector<std::size_t> rows;
  const geometry::RobotModel& robot = *look.used.rig.robot.model;
  for (std::size_t row = 0; row < look.used.samples.size(); ++row) {
    const session::Sample& sample = look.used.samples[row];
    if (sample.left_out || !sample.q.allFinite()) continue;
    simulation::Trial trial;
    trial.q = sample.q;
    for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
      trial.approach.push_back(session::approach_of(sample, joint).value_or(0));
    }
    trials.push_back(std::move(trial));
    rows.push_back(row);
  }
  const auto from = simulation::sides_from(robot, trials);
  for (std::size_t joint = 0; joint < from.size(); ++joint) {
    if (from[joint] != simulation::SidesFrom::kReversed) continue;
    std::vector<std::size_t> told;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (trials[i].approach_of(joint) == 0) continue;
      told.push_back(rows[i]);
      auto& approach = look.used.samples[rows[i]].approach;
      if (joint < approach.size() && approach[joint]) approach[joint] = -*approach[joint];
    }
    look.tell(
        "sides_reversed", Severity::kNote,
        look.rows(told, "approach" + std::to_string(joint + 1)),
        {{"joint", static_cast<double>(joint + 1)}});
  }
}

}  // namespace sixdial::studies::plausibility
