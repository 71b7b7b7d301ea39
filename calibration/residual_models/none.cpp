// No residual model: kinematics alone.
#include <utility>

#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

TrainedResidual load(const SavedResidual& saved) {
  const Eigen::Index outputs = saved_outputs(saved);
  TrainedResidual result;
  result.effective_parameters = Eigen::VectorXd::Zero(outputs);
  result.correction = [outputs](const Eigen::VectorXd&) -> Eigen::VectorXd {
    return Eigen::VectorXd::Zero(outputs);
  };
  return result;
}

TrainedResidual train(
    const Eigen::MatrixXd&, const Eigen::MatrixXd& residual_mm, const ResidualSettings&,
    const std::stop_token&) {
  SavedResidual saved;
  save_outputs(residual_mm.cols(), saved);
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note = "kinematics alone";
  return result;
}

}  // namespace

extern constinit const ResidualModel no_residual_model{
    .name = "none",
    .title = "none",
    .description = "no residual model",
    .train = train,
    .load = load};

}  // namespace sixdial::calibration
