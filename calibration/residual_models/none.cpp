// No residual model: kinematics alone.
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

TrainedResidual train(
    const Eigen::MatrixXd&, const Eigen::MatrixXd& residual_mm, const ResidualSettings&,
    const std::stop_token&) {
  const Eigen::Index outputs = residual_mm.cols();
  TrainedResidual result;
  result.correction = [outputs](const Eigen::VectorXd&) -> Eigen::VectorXd {
    return Eigen::VectorXd::Zero(outputs);
  };
  result.effective_parameters = Eigen::VectorXd::Zero(outputs);
  result.note = "kinematics alone";
  return result;
}

}  // namespace

extern constinit const ResidualModel no_residual_model{
    .name = "none", .description = "no residual model", .train = train};

}  // namespace sixdial::calibration
