// ANFIS for x and for y: size and ridge by cross-validation (`anfis`), or as the paper has it
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
    const Eigen::MatrixX2d& q_rad, const Eigen::MatrixX2d& residual_mm,
    const ResidualSettings& settings, bool cross_validate, const std::stop_token& stop) {
  AnfisLearning learning{
      settings.anfis, cross_validate, settings.holdout_fraction, settings.seed};
  const AnfisReport x = learn_anfis(q_rad, residual_mm.col(0), learning, stop);
  const AnfisReport y = learn_anfis(q_rad, residual_mm.col(1), learning, stop);
  TrainedResidual result;
  result.correction = [x = x.model, y = y.model](const Eigen::Vector2d& q) {
    return Eigen::Vector2d(x.predict(q), y.predict(q));
  };
  result.effective_parameters = {x.model.effective_parameters, y.model.effective_parameters};
  result.note = "x: " + words(x) + "; y: " + words(y);
  return result;
}

TrainedResidual chosen(
    const Eigen::MatrixX2d& q_rad, const Eigen::MatrixX2d& residual_mm,
    const ResidualSettings& settings, const std::stop_token& stop) {
  return train(q_rad, residual_mm, settings, true, stop);
}

TrainedResidual as_printed(
    const Eigen::MatrixX2d& q_rad, const Eigen::MatrixX2d& residual_mm,
    const ResidualSettings& settings, const std::stop_token& stop) {
  return train(q_rad, residual_mm, settings, false, stop);
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
