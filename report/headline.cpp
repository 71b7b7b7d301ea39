#include "report/headline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/words/calibration_words.h"
#include "report/words/diagnosis_words.h"
#include "report/words/warning_words.h"
#include "report/words/wrapped.h"
#include "studies/method_name.h"

namespace sixdial::report {
namespace {

std::optional<double> if_finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<ErrorStatistics> statistics_of(const std::optional<studies::SetErrors>& errors) {
  if (!errors) return std::nullopt;
  ErrorStatistics statistics;
  statistics.mean_mm = errors->mean_mm;
  statistics.std_mm = errors->std_mm;
  statistics.max_mm = errors->max_mm;
  statistics.mean_low_mm = if_finite(errors->mean_low_mm);
  statistics.mean_high_mm = if_finite(errors->mean_high_mm);
  statistics.points = errors->points;
  return statistics;
}

/// A panel of the residual map each: the robot before, its parameters alone, the result.
std::vector<std::string> methods_on_map(const studies::CalibrationResult& result) {
  return {
      "before", studies::without_residual_model(result.result_method), result.result_method};
}

std::vector<ShownMethod> methods_of(const studies::CalibrationResult& result) {
  const std::vector<std::string> on_map = methods_on_map(result);
  std::vector<ShownMethod> methods;
  for (const studies::MethodRow& each : result.methods) {
    ShownMethod method;
    method.id = each.id;
    method.name = studies::method_name(each.id);
    method.g1 = statistics_of(each.g1);
    method.g2 = statistics_of(each.g2);
    method.seconds = each.seconds;
    method.has_residual_model = method.id.find('+') != std::string::npos;
    method.on_map = std::ranges::find(on_map, method.id) != on_map.end();
    methods.push_back(std::move(method));
  }
  return methods;
}

}  // namespace

ReportData headline_data(const studies::CalibrationResult& result) {
  ReportData data;
  data.warnings = result.warnings.value_or(std::vector<studies::Warning>());
  data.plausibility_judged = result.warnings.has_value();
  for (const studies::CorrelationRow& each : result.identification.correlations) {
    data.correlations.push_back({each.first, each.second, each.coefficient});
  }
  const Eigen::VectorXd& values = result.identification.singular_values;
  data.singular_values.assign(values.begin(), values.end());
  for (const std::string& line : turn_lines(result)) data.turns.push_back(capital(line) + ".");
  data.condition_number = if_finite(result.identification.condition);
  for (const studies::HeldRow& each : result.identification.held) {
    data.unidentifiable.push_back(each.words);
  }
  data.methods = methods_of(result);
  data.result_method = result.result_method;
  data.conformity = result.conformity;
  data.position_noise_mm = result.position_noise_mm;
  data.rmse_mm = if_finite(result.rmse_mm);
  data.least_squares_rmse_mm = if_finite(result.least_squares_rmse_mm);
  if (result.assessment) {
    if (const auto line = far_from_noise_line(result.assessment->noise)) {
      data.headline_more.push_back("Careful: " + *line + ".");
    }
  }
  return data;
}

Verdict verdict_of(const studies::CalibrationResult& result) {
  return verdict(headline_data(result));
}

std::string headline_text(const studies::CalibrationResult& result) {
  const Verdict said = verdict_of(result);
  // What forbids a verdict stands in the list below.
  const bool listed = said.state == CalibrationState::kNotCalibrated;
  std::string text =
      wrapped(listed ? said.title + "." : fmt::format("{}. {}", said.title, said.headline));
  if (result.warnings) text += warnings_text(*result.warnings);
  if (!said.decision.empty()) text += wrapped(said.decision);
  return text + "\n";
}

bool may_be_used(CalibrationState state) {
  return state == CalibrationState::kCalibrated || state == CalibrationState::kImproved ||
         state == CalibrationState::kNotValidated;
}

}  // namespace sixdial::report
