#include "diagnosis/plausible_robot.h"

#include <cstddef>

namespace sixdial::diagnosis {

double PlausibleRobot::squares(const simulation::ModelVector& x) const {
  return per_sd.size() > 0 ? (x - at).cwiseProduct(per_sd).squaredNorm() : 0.0;
}

PlausibleRobot plausible_robot(const Readings& readings, Eigen::Index numbers) {
  constexpr double kTimesChange = 10.0;  // of ParameterInfo::change: a loose word
  if (readings.axes() < 3) return {};
  const auto& robot = readings.model().rig().robot;
  PlausibleRobot result{Eigen::VectorXd::Zero(numbers), Eigen::VectorXd::Zero(numbers)};
  for (Eigen::Index i = 0; i < robot.nominal.size() && i < numbers; ++i) {
    const auto& info = robot.model->parameters[static_cast<std::size_t>(i)];
    result.at[i] = robot.nominal[i];
    if (!info.stands) result.per_sd[i] = 1.0 / (kTimesChange * info.change);
  }
  return result;
}

}  // namespace sixdial::diagnosis
