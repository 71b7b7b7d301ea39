#include "studies/network_json.h"

#include <fmt/format.h>

#include <cmath>

namespace sixdial::studies {
namespace {

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return std::vector<double>(values.begin(), values.end());
}

Json matrix(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    rows.push_back(numbers(values.row(i).transpose()));
  }
  return rows;
}

Json candidate_json(const calibration::AnfisCandidate& candidate) {
  return {
      {"functions", candidate.functions},
      {"ridge", candidate.ridge},
      {"loo_rmse_mm", candidate.loo_rmse},
      {"effective_parameters", candidate.effective_parameters}};
}

[[noreturn]] void refuse(const std::string& what) {
  throw Error(
      ErrorCode::kBadData, "a saved network cannot be used: " + what, {},
      "Calibrate the session again.");
}

const Json& entry(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) refuse(fmt::format("it has no \"{}\"", key));
  return *found;
}

double number_of(const Json& json, const char* key) {
  const Json& value = entry(json, key);
  if (!value.is_number()) refuse(fmt::format("\"{}\" is not a number", key));
  return value.get<double>();
}

Eigen::VectorXd vector_from(const Json& json, const char* key, Eigen::Index size) {
  const Json& values = entry(json, key);
  if (!values.is_array() || std::ssize(values) != size) {
    refuse(fmt::format("\"{}\" should hold {} numbers", key, size));
  }
  Eigen::VectorXd result(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Json& value = values[static_cast<std::size_t>(i)];
    if (!value.is_number()) refuse(fmt::format("\"{}\" should hold {} numbers", key, size));
    result[i] = value.get<double>();
  }
  return result;
}

Eigen::MatrixXd matrix_from(
    const Json& json, const char* key, Eigen::Index rows, Eigen::Index columns) {
  const Json& values = entry(json, key);
  if (!values.is_array() || std::ssize(values) != rows) {
    refuse(fmt::format("\"{}\" should have {} rows", key, rows));
  }
  Eigen::MatrixXd result(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i) {
    result.row(i) =
        vector_from(Json{{key, values[static_cast<std::size_t>(i)]}}, key, columns).transpose();
  }
  return result;
}

}  // namespace

Json network_json(const calibration::AnfisReport& report) {
  const calibration::AnfisModel& model = report.model;
  Json json{
      {"kind", model.kind == calibration::MembershipKind::kGaussian ? "gaussian" : "bell"},
      {"inputs", model.inputs},
      {"functions", model.functions},
      {"rules", model.rules()},
      {"consequents_count", model.consequents.size()},
      {"samples", report.samples},
      {"input_mean", numbers(model.input_mean)},
      {"input_scale", numbers(model.input_scale)},
      {"centre", matrix(model.centre)},
      {"width", matrix(model.width)},
      {"slope", matrix(model.slope)},
      {"consequents", matrix(model.consequents)},
      {"box_low", numbers(model.box_low)},
      {"box_high", numbers(model.box_high)},
      {"output_low_mm", model.output_low},
      {"output_high_mm", model.output_high},
      {"effective_parameters", model.effective_parameters},
      {"ridge", model.ridge},
      {"best_epoch", report.best_epoch},
      {"target_reached", report.target_reached},
      {"train_rmse_mm", report.train_rmse_mm},
      {"check_rmse_mm", report.check_rmse_mm},
      {"selection", nullptr}};
  if (report.selection) {
    Json candidates = Json::array();
    for (const auto& each : report.selection->candidates) {
      candidates.push_back(candidate_json(each));
    }
    json["selection"] = {
        {"functions", report.selection->chosen.functions},
        {"ridge", report.selection->chosen.ridge},
        {"loo_rmse_mm", report.selection->chosen.loo_rmse},
        {"gain", report.selection->gain},
        {"standard_errors", report.selection->standard_errors},
        {"rmse_without_mm", report.selection->rmse_without},
        {"as_printed", candidate_json(report.selection->as_printed)},
        {"candidates", std::move(candidates)}};
  }
  return json;
}

calibration::AnfisModel network_from(const Json& json) {
  calibration::AnfisModel model;
  const Json& kind = entry(json, "kind");
  if (kind != "gaussian" && kind != "bell") refuse("\"kind\" is neither gaussian nor bell");
  const bool bell = kind == "bell";
  model.kind =
      bell ? calibration::MembershipKind::kBell : calibration::MembershipKind::kGaussian;
  model.inputs = static_cast<int>(entry(json, "input_mean").size());
  model.functions = static_cast<int>(number_of(json, "functions"));
  if (model.inputs < 1 || model.functions < 0 ||
      std::pow(model.functions, model.inputs) > calibration::kMostRules) {
    refuse("\"input_mean\" and \"functions\" make no network");
  }
  const int inputs = model.inputs;
  const int functions = model.functions;
  model.input_mean = vector_from(json, "input_mean", inputs);
  model.input_scale = vector_from(json, "input_scale", inputs);
  model.box_low = vector_from(json, "box_low", inputs);
  model.box_high = vector_from(json, "box_high", inputs);
  model.output_low = number_of(json, "output_low_mm");
  model.output_high = number_of(json, "output_high_mm");
  model.effective_parameters = number_of(json, "effective_parameters");
  model.ridge = number_of(json, "ridge");
  if (functions == 0) return model;
  model.centre = matrix_from(json, "centre", functions, inputs);
  model.width = matrix_from(json, "width", functions, inputs);
  if (bell) model.slope = matrix_from(json, "slope", functions, inputs);
  model.consequents = matrix_from(json, "consequents", model.rules(), inputs + 1);
  return model;
}

}  // namespace sixdial::studies
