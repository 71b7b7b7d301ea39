// ANFIS for x and for y: size and ridge by cross-validation (`anfis`), or as the paper has it
// (`anfis_paper`: six functions, 36 rules, ridge 1e-6, 500 epochs).
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

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

/// All numbers of a network, each under `axis` and its name: "x.centre".
void save(const AnfisModel& model, const std::string& axis, SavedResidual& saved) {
  const auto number = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
  saved[axis + ".bell"] = number(model.kind == MembershipKind::kBell ? 1.0 : 0.0);
  saved[axis + ".functions"] = number(model.functions);
  saved[axis + ".input_mean"] = model.input_mean;
  saved[axis + ".input_scale"] = model.input_scale;
  saved[axis + ".centre"] = model.centre;
  saved[axis + ".width"] = model.width;
  saved[axis + ".slope"] = model.slope;
  saved[axis + ".consequents"] = model.consequents;
  saved[axis + ".box_low"] = model.box_low;
  saved[axis + ".box_high"] = model.box_high;
  saved[axis + ".output_low"] = number(model.output_low);
  saved[axis + ".output_high"] = number(model.output_high);
  saved[axis + ".effective_parameters"] = number(model.effective_parameters);
  saved[axis + ".ridge"] = number(model.ridge);
}

AnfisModel network(const std::string& axis, const SavedResidual& saved) {
  const auto matrix = [&](const char* name, Eigen::Index rows, Eigen::Index columns) {
    return saved_matrix(saved, axis + name, rows, columns);
  };
  AnfisModel model;
  const bool bell = saved_number(saved, axis + ".bell") != 0.0;
  model.kind = bell ? MembershipKind::kBell : MembershipKind::kGaussian;
  model.input_mean = matrix(".input_mean", -1, 1);
  const Eigen::Index inputs = model.input_mean.size();
  model.inputs = static_cast<int>(inputs);
  const double functions = saved_number(saved, axis + ".functions");
  if (!(functions >= 0.0) || std::pow(functions, model.inputs) > kMostRules) {
    throw std::invalid_argument("\"" + axis + ".functions\" makes no network");
  }
  model.functions = static_cast<int>(functions);
  model.input_scale = matrix(".input_scale", inputs, 1);
  model.box_low = matrix(".box_low", inputs, 1);
  model.box_high = matrix(".box_high", inputs, 1);
  model.output_low = saved_number(saved, axis + ".output_low");
  model.output_high = saved_number(saved, axis + ".output_high");
  model.effective_parameters = saved_number(saved, axis + ".effective_parameters");
  model.ridge = saved_number(saved, axis + ".ridge");
  if (model.functions == 0) return model;
  model.centre = matrix(".centre", model.functions, inputs);
  model.width = matrix(".width", model.functions, inputs);
  if (bell) model.slope = matrix(".slope", model.functions, inputs);
  model.consequents = matrix(".consequents", model.rules(), inputs + 1);
  return model;
}

TrainedResidual load(const SavedResidual& saved) {
  const AnfisModel x = network("x", saved);
  const AnfisModel y = network("y", saved);
  TrainedResidual result;
  result.effective_parameters = {x.effective_parameters, y.effective_parameters};
  result.correction = [x, y](const Eigen::Vector2d& q) {
    return Eigen::Vector2d(x.predict(q), y.predict(q));
  };
  return result;
}

TrainedResidual train(
    const Eigen::MatrixX2d& q_rad, const Eigen::MatrixX2d& residual_mm,
    const ResidualSettings& settings, bool cross_validate, const std::stop_token& stop) {
  AnfisLearning learning{
      settings.anfis, cross_validate, settings.holdout_fraction, settings.seed};
  const AnfisReport x = learn_anfis(q_rad, residual_mm.col(0), learning, stop);
  const AnfisReport y = learn_anfis(q_rad, residual_mm.col(1), learning, stop);
  SavedResidual saved;
  save(x.model, "x", saved);
  save(y.model, "y", saved);
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
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
    .title = "ANFIS",
    .description = "ANFIS, size and ridge by cross-validation, no network if none helps",
    .train = chosen,
    .load = load};
extern constinit const ResidualModel anfis_paper{
    .name = "anfis_paper",
    .title = "ANFIS as printed",
    .description = "ANFIS as printed: 6 functions, 36 rules, ridge 1e-6",
    .train = as_printed,
    .load = load};

}  // namespace sixdial::calibration
