#include "diagnosis/plausible_robot.h"

#include <cstddef>

#include "calibration/identifier.h"
#include "calibration/rig_spaces.h"

namespace sixdial::diagnosis {

double PlausibleRobot::squares(const simulation::ModelVector& x) const {
  double sum = per_sd.size() > 0 ? (x - at).cwiseProduct(per_sd).squaredNorm() : 0.0;
  if (held.size() > 0) sum += (held * (x - at)).squaredNorm();
  return sum;
}

PlausibleRobot plausible_robot(const Readings& readings, Eigen::Index numbers) {
  constexpr double kTimesChange = 10.0;  // of ParameterInfo::change: a loose word
  if (readings.axes() < 3) {
    if (readings.held().cols() != numbers) return {};
    return {readings.nominal(), {}, readings.held()};
  }
  const auto& robot = readings.model().rig().robot;
  PlausibleRobot result{Eigen::VectorXd::Zero(numbers), Eigen::VectorXd::Zero(numbers), {}};
  for (Eigen::Index i = 0; i < robot.nominal.size() && i < numbers; ++i) {
    const auto& info = robot.model->parameters[static_cast<std::size_t>(i)];
    result.at[i] = robot.nominal[i];
    if (!info.stands) result.per_sd[i] = 1.0 / (kTimesChange * info.change);
  }
  return result;
}

Eigen::MatrixXd open_directions(
    std::span<const simulation::Trial> trials, const simulation::ForwardModel& model) {
  const calibration::ObservationSpace space = calibration::dial_space(trials, model.rig());
  if (space.samples() == 0 || space.parameters() > model.parameter_count()) return {};
  calibration::IdentifySettings settings;
  settings.noise_mm = space.sigma_mm.mean();
  const calibration::LeastSquaresFit fit =
      calibration::identify(*calibration::find_identifier("lm"), space, settings).fit;
  if (fit.status == calibration::FitStatus::kBadStart || fit.held == 0) return {};
  // A thousandth of the change that is plausible: what it is held to is not noticed.
  constexpr double kHeldTo = 1e-3;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(fit.held, model.parameter_count());
  rows.leftCols(fit.x.size()) = fit.directions.rightCols(fit.held).transpose() *
                                fit.scale.cwiseInverse().asDiagonal() / kHeldTo;
  return rows;
}

}  // namespace sixdial::diagnosis
