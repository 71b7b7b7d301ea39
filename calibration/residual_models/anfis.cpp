// ANFIS, a network for each channel: size and ridge by cross-validation (`anfis`), or as the
// paper has it
// (`anfis_paper`: six functions, 36 rules, ridge 1e-6, 500 epochs).
#include <fmt/format.h>

#include "calibration/anfis_learning.h"
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

std::string words(const AnfisReport& report) {
  if (report.model.functions == 0) return "no network";
  return fmt::format(
      "{} functions, {} rules, ridge {:g}, best epoch {}, {:.1f} effective parameters",
      report.model.functions, report.model.rules(), report.model.ridge, report.best_epoch,
      report.model.effective_parameters);
}

TrainedResidual train(
    const Eigen::MatrixXd& joints, const Eigen::MatrixXd& residual_mm,
    const ResidualSettings& settings, bool cross_validate, const std::stop_token& stop) {
  const AnfisLearning learning{
      settings.anfis, cross_validate, settings.holdout_fraction, settings.seed};
  std::vector<AnfisReport> reports;
  std::vector<AnfisModel> networks;
  TrainedResidual result;
  result.effective_parameters.resize(residual_mm.cols());
  for (Eigen::Index k = 0; k < residual_mm.cols(); ++k) {
    reports.push_back(learn_anfis(joints, residual_mm.col(k), learning, stop));
    networks.push_back(reports.back().model);
    result.effective_parameters[k] = networks.back().effective_parameters;
  }
  result.correction = [networks](const Eigen::VectorXd& q) {
    return anfis_correction(networks, q);
  };
  result.note = by_output(settings, residual_mm.cols(), [&](Eigen::Index k) {
    return words(reports[static_cast<std::size_t>(k)]);
  });
  return result;
}

TrainedResidual chosen(
    const Eigen::MatrixXd& joints, const Eigen::MatrixXd& residual_mm,
    const ResidualSettings& settings, const std::stop_token& stop) {
  return train(joints, residual_mm, settings, true, stop);
}

TrainedResidual as_printed(
    const Eigen::MatrixXd& joints, const Eigen::MatrixXd& residual_mm,
    const ResidualSettings& settings, const std::stop_token& stop) {
  return train(joints, residual_mm, settings, false, stop);
}

}  // namespace

extern constinit const ResidualModel anfis_chosen{
    .name = "anfis",
    .description = "ANFIS, size and ridge by cross-validation, no network if none helps",
    .train = chosen};
extern constinit const ResidualModel anfis_paper{
    .name = "anfis_paper",
    .description = "ANFIS as printed: 6 functions, 36 rules, ridge 1e-6",
    .train = as_printed};

}  // namespace sixdial::calibration
