// No residual model: kinematics alone.
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

TrainedResidual load(const SavedResidual&) {
  TrainedResidual result;
  result.correction = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  return result;
}

TrainedResidual train(
    const Eigen::MatrixX2d&, const Eigen::MatrixX2d&, const ResidualSettings&,
    const std::stop_token&) {
  TrainedResidual result = load({});
  result.note = "kinematics alone";
  return result;
}

}  // namespace

extern constinit const ResidualModel no_residual_model{
    .name = "none", .title = "none", .description = "no residual model", .train = train, .load = load};

}  // namespace sixdial::calibration
