#include "report/words/validation_words.h"

#include <fmt/format.h>

#include <cmath>

#include "studies/method_name.h"

namespace sixdial::report {
namespace {

std::string cell(const std::optional<double>& value_mm) {
  return value_mm && std::isfinite(*value_mm) ? fmt::format("{:8.4f}", *value_mm)
                                              : fmt::format("{:>8}", "-");
}

}  // namespace

std::string compensation_name(
    studies::CompensateBy by, const std::optional<std::string>& calibration_method) {
  switch (by) {
    case studies::CompensateBy::kBefore:
      return "before calibration";
    case studies::CompensateBy::kKinematics:
      return "after kinematics";
    case studies::CompensateBy::kFull:
      return calibration_method ? "after " + studies::method_name(*calibration_method)
                                : std::string("after kinematics + ANFIS");
    case studies::CompensateBy::kExtended:
      return "after diagnosis (extended)";
    case studies::CompensateBy::kExtendedFull:
      return "extended + residual model";
  }
  return "";
}

std::string validation_text(const studies::ValidationResult& result) {
  std::string text = fmt::format(
      "{:<26} {:>8} {:>8} {:>8} {:>7} {:>10}\n", "error reached, mm", "mean", "std", "max",
      "points", "predicted");
  for (const studies::ValidatedWay& way : result.methods) {
    const auto figure = [&](double studies::ReachedErrors::*which) {
      return cell(way.errors ? std::optional((*way.errors).*which) : std::nullopt);
    };
    text += fmt::format(
        "{:<26} {} {} {} {:>7} {:>10}\n",
        compensation_name(way.by, result.inputs.calibration_method),
        figure(&studies::ReachedErrors::mean_mm), figure(&studies::ReachedErrors::std_mm),
        figure(&studies::ReachedErrors::max_mm), way.errors ? way.errors->points : 0,
        cell(way.predicted_mean_mm()));
  }
  if (result.inputs.positions_by) {
    text +=
        "measured positions: by all dials, with what the diagnosis says of the instrument\n";
  }
  return text;
}

}  // namespace sixdial::report
