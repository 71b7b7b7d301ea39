// ANFIS, a network for each channel: size and ridge by cross-validation (`anfis`), or as the
// paper has it
// (`anfis_paper`: six functions, 36 rules, ridge 1e-6, at most 500 epochs, no further than to a
// mean squared error of 1e-5).
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "calibration/anfis_learning.h"
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

std::string words(const AnfisReport& report) {
  if (report.model.functions == 0) return "no network";
  std::string text = fmt::format(
      "{} functions, {} rules, ridge {:g}, best epoch {}, {:.1f} effective parameters",
      report.model.functions, report.model.rules(), report.model.ridge, report.best_epoch,
      report.model.effective_parameters);
  if (report.stopped_at_target()) {
    text += fmt::format(", stopped at its target in epoch {}", report.target_reached);
  }
  return text;
}

/// All numbers of a network, each under `prefix` and its name: "output1.centre".
void save(const AnfisModel& model, const std::string& prefix, SavedResidual& saved) {
  saved[prefix + "bell"] = number_to_save(model.kind == MembershipKind::kBell ? 1.0 : 0.0);
  saved[prefix + "functions"] = number_to_save(model.functions);
  saved[prefix + "input_mean"] = model.input_mean;
  saved[prefix + "input_scale"] = model.input_scale;
  saved[prefix + "centre"] = model.centre;
  saved[prefix + "width"] = model.width;
  saved[prefix + "slope"] = model.slope;
  saved[prefix + "consequents"] = model.consequents;
  saved[prefix + "box_low"] = model.box_low;
  saved[prefix + "box_high"] = model.box_high;
  saved[prefix + "output_low"] = number_to_save(model.output_low);
  saved[prefix + "output_high"] = number_to_save(model.output_high);
  saved[prefix + "effective_parameters"] = number_to_save(model.effective_parameters);
  saved[prefix + "ridge"] = number_to_save(model.ridge);
}

AnfisModel network(const std::string& prefix, const SavedResidual& saved) {
  const auto matrix = [&](const char* name, Eigen::Index rows, Eigen::Index columns) {
    return saved_matrix(saved, prefix + name, rows, columns);
  };
  AnfisModel model;
  const bool bell = saved_number(saved, prefix + "bell") != 0.0;
  model.kind = bell ? MembershipKind::kBell : MembershipKind::kGaussian;
  model.input_mean = matrix("input_mean", -1, 1);
  const Eigen::Index inputs = model.input_mean.size();
  model.inputs = static_cast<int>(inputs);
  const double functions = saved_number(saved, prefix + "functions");
  if (!(functions >= 0.0) || std::pow(functions, model.inputs) > kMostRules) {
    throw std::invalid_argument("\"" + prefix + "functions\" makes no network");
  }
  model.functions = static_cast<int>(functions);
  model.input_scale = matrix("input_scale", inputs, 1);
  model.box_low = matrix("box_low", inputs, 1);
  model.box_high = matrix("box_high", inputs, 1);
  model.output_low = saved_number(saved, prefix + "output_low");
  model.output_high = saved_number(saved, prefix + "output_high");
  model.effective_parameters = saved_number(saved, prefix + "effective_parameters");
  model.ridge = saved_number(saved, prefix + "ridge");
  if (model.functions == 0) return model;
  model.centre = matrix("centre", model.functions, inputs);
  model.width = matrix("width", model.functions, inputs);
  if (bell) model.slope = matrix("slope", model.functions, inputs);
  model.consequents = matrix("consequents", model.rules(), inputs + 1);
  return model;
}

TrainedResidual load(const SavedResidual& saved) {
  const Eigen::Index outputs = saved_outputs(saved);
  std::vector<AnfisModel> networks;
  TrainedResidual result;
  result.effective_parameters.resize(outputs);
  for (Eigen::Index k = 0; k < outputs; ++k) {
    networks.push_back(network(output_prefix(k), saved));
    result.effective_parameters[k] = networks.back().effective_parameters;
  }
  result.correction = [networks = std::move(networks)](const Eigen::VectorXd& q) {
    return anfis_correction(networks, q);
  };
  return result;
}

TrainedResidual train(
    const Eigen::MatrixXd& joints, const Eigen::MatrixXd& residual_mm,
    const ResidualSettings& settings, bool cross_validate, const std::stop_token& stop) {
  AnfisLearning learning{
      settings.anfis, cross_validate, settings.holdout_fraction, settings.seed};
  learning.anfis.stop_at_target = !cross_validate;
  std::optional<AnfisSelector> selector;
  if (cross_validate) selector.emplace(joints, learning.anfis.kind);
  std::vector<AnfisReport> reports;
  SavedResidual saved;
  save_outputs(residual_mm.cols(), saved);
  for (Eigen::Index k = 0; k < residual_mm.cols(); ++k) {
    reports.push_back(learn_anfis(
        joints, residual_mm.col(k), learning, stop, selector ? &*selector : nullptr));
    save(reports.back().model, output_prefix(k), saved);
  }
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
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
