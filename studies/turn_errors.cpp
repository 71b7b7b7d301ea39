#include "studies/turn_errors.h"

#include <algorithm>
#include <map>
#include <string>

#include "calibration/reading_space.h"
#include "session/trials.h"
#include "studies/turns_left.h"

namespace sixdial::studies {

bool turns_were_fitted(const std::vector<TurnErrors>& errors) {
  return std::ranges::find(errors, "G1", &TurnErrors::set) != errors.end();
}

std::vector<TurnErrors> turn_errors(
    const session::Session& session, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified) {
  std::vector<TurnErrors> result;
  if (!calibration::fits_turns(session.rig)) return result;
  for (const std::string set : {"G1", "G2"}) {
    const std::vector<simulation::Trial> trials = session::trials_of(session, set);
    std::map<int, double> before_rad;
    for (const TurnLeft& each : turns_left(session, trials, nominal)) {
      before_rad[each.sample] = each.rad;
    }
    TurnErrors errors{.set = set};
    for (const TurnLeft& each : turns_left(session, trials, identified)) {
      const auto before = before_rad.find(each.sample);
      if (before == before_rad.end()) continue;
      ++errors.poses;
      errors.before_mean_rad += (before->second - errors.before_mean_rad) / errors.poses;
      errors.mean_rad += (each.rad - errors.mean_rad) / errors.poses;
      errors.before_max_rad = std::max(errors.before_max_rad, before->second);
      errors.max_rad = std::max(errors.max_rad, each.rad);
    }
    if (errors.poses > 0) result.push_back(errors);
  }
  return result;
}

}  // namespace sixdial::studies
