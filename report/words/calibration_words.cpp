#include "report/words/calibration_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/identifiability.h"
#include "geometry/coverage.h"
#include "geometry/units.h"
#include "report/expanded.h"
#include "simulation/effect_words.h"
#include "studies/method_name.h"

namespace sixdial::report {
namespace {

using studies::GrossErrors;

std::string mode_condition_words(std::optional<double> condition) {
  return condition && *condition < calibration::kOpenCondition
             ? fmt::format("{:.0f}", *condition)
             : std::string("infinite");
}

/// "166"; "3.1e+16 (64 without what is held)".
std::string condition_words(const studies::IdentifiabilityRow& known) {
  const auto words = [](std::optional<double> value) {
    if (!value || !std::isfinite(*value)) return std::string("infinite");
    return *value < 1e5 ? fmt::format("{:.0f}", *value) : fmt::format("{:.1e}", *value);
  };
  std::string text = words(known.condition);
  if (!known.held.empty()) {
    text += fmt::format(" ({} without what is held)", words(known.condition_determined));
  }
  return text;
}

/// "0.4", "0.0031": two digits.
std::string length_words(double mm) { return simulation::in_digits(mm, 2); }

std::string parameter_line(const studies::ParameterRow& row) {
  const auto unit = geometry::shown_unit(row.unit);
  const double shown = unit.per_unit;
  std::string line =
      fmt::format("{:<8} {:>10.4f} {}", row.name, shown * row.identified, unit.name);
  if (row.fixed) return line + "  fixed at nominal";
  const double coverage = coverage_of(row.sd, row.low_95, row.high_95);
  return line + fmt::format(
                    "  {} {:.4f}{}", expanded_title(coverage), coverage * shown * row.sd,
                    row.partly_held ? ", partly held at nominal" : "");
}

}  // namespace

std::string table_6_text(const studies::CalibrationResult& result) {
  std::vector<std::string> shown{
      "before", studies::without_residual_model(result.result_method)};
  if (shown.back() != result.result_method) shown.push_back(result.result_method);
  std::size_t width = 20;
  for (const std::string& id : shown) {
    width = std::max(width, studies::method_name(id).size());
  }
  const auto line = [&](const std::string& name, const std::array<std::string, 6>& cells) {
    return fmt::format(
        "{:<{}} {:>8} {:>8} {:>8}   {:>8} {:>8} {:>8}\n", name, width, cells[0], cells[1],
        cells[2], cells[3], cells[4], cells[5]);
  };
  const auto cell = [](const std::optional<studies::SetErrors>& set,
                       double studies::SetErrors::*figure) {
    return set && std::isfinite((*set).*figure) ? fmt::format("{:8.4f}", (*set).*figure)
                                                : std::string("-");
  };
  std::string text = line("position error, mm", {"G1", "", "", "G2", "", ""}) +
                     line("", {"mean", "std", "max", "mean", "std", "max"});
  for (const std::string& id : shown) {
    const studies::MethodRow* row = result.method(id);
    if (row == nullptr) continue;
    std::array<std::string, 6> cells;
    std::size_t k = 0;
    for (const auto* set : {&row->g1, &row->g2}) {
      for (const auto figure :
           {&studies::SetErrors::mean_mm, &studies::SetErrors::std_mm,
            &studies::SetErrors::max_mm}) {
        cells.at(k++) = cell(*set, figure);
      }
    }
    text += line(studies::method_name(id), cells);
  }
  return text;
}

std::vector<std::string> turn_lines(const studies::CalibrationResult& result) {
  std::vector<std::string> lines;
  if (!result.turn_errors) return lines;
  const bool found_first =
      result.warnings &&
      std::ranges::find(*result.warnings, "tool_turn_registered", &studies::Warning::code) !=
          result.warnings->end();
  for (const studies::TurnErrors& each : *result.turn_errors) {
    lines.push_back(fmt::format(
        "turn of the tool, {} poses of {}{}: off by {:.4f} deg before{}, {:.4f} deg after in "
        "the mean ({:.4f} and {:.4f} deg at most)",
        each.poses, each.set,
        studies::turns_were_fitted(*result.turn_errors) ? "" : ", not fitted (G1 has none)",
        geometry::kDegPerRad * each.before_mean_rad,
        found_first ? " (the frame of the tool was found first)" : "",
        geometry::kDegPerRad * each.mean_rad, geometry::kDegPerRad * each.before_max_rad,
        geometry::kDegPerRad * each.max_rad));
  }
  return lines;
}

std::string effort_line(const studies::CalibrationResult& result) {
  const std::string name =
      result.result_method == studies::kPaperMethod
          ? "DQPSO"
          : studies::method_name(studies::without_residual_model(result.result_method));
  constexpr double kRounding_mm = 1e-7;
  if (result.above_minimum_mm < -kRounding_mm) {
    // The least-squares fit holds what no pose determines; a search moves there as well.
    std::vector<std::string> held;
    for (const studies::HeldRow& each : result.identification.held) held.push_back(each.words);
    return fmt::format(
        "{} leaves {:.2e} mm less on G1 than the least-squares fit, as it also moves what "
        "these "
        "poses do not determine{}{}: rely on neither there; seed {}, {:.1f} s",
        name, -result.above_minimum_mm,
        held.empty() ? "" : " and least squares held: ", fmt::join(held, "; "),
        result.inputs.seed, result.seconds);
  }
  const std::string where =
      result.above_minimum_mm > 0.0
          ? fmt::format("{:.2e} mm above the least-squares minimum", result.above_minimum_mm)
          : std::string("at the least-squares minimum");
  return fmt::format(
      "{} is {}; seed {}, {:.1f} s", name, where, result.inputs.seed, result.seconds);
}

std::optional<std::string> far_from_noise_line(const calibration::NoiseEstimate& noise) {
  if (!noise.over_rig_file || !noise.residual) return std::nullopt;
  return fmt::format(
      "the robot's parameters leave {} mm where the rig file says that {} mm is the noise "
      "({:.1f} times as "
      "much): something is not in the model or wrong in the rig file; all uncertainties are "
      "made "
      "of what is left (sixdial diagnose looks for the cause)",
      length_words(noise.residual->sigma_mm), length_words(noise.rig_file_mm),
      *noise.over_rig_file);
}

std::optional<std::string> training_line(const studies::CalibrationResult& result) {
  if (!result.networks) return std::nullopt;
  const auto epoch = [](const calibration::AnfisReport& network) {
    if (network.target_reached == 0) return std::string("not");
    return fmt::format(
        "in epoch {}{}", network.target_reached,
        network.stopped_at_target() ? ", where training stops" : "");
  };
  if (result.networks->x.train_rmse_mm.empty() && result.networks->y.train_rmse_mm.empty()) {
    return std::nullopt;
  }
  return fmt::format(
      "ANFIS: target error {:g} mm\u00B2 (mean square of the training points) reached {} (x), "
      "{} "
      "(y); at most {} epochs",
      result.settings.anfis.target_mse, epoch(result.networks->x), epoch(result.networks->y),
      result.settings.anfis.epochs);
}

std::vector<std::string> assessment_lines(const studies::Assessment& assessment) {
  std::vector<std::string> lines;
  const studies::IdentifiabilityRow& known = assessment.identifiability;
  lines.push_back(fmt::format(
      "{} samples determine {} of {} free parameters; condition number {}, observability index "
      "{:.4f}",
      assessment.samples, known.determined, known.free, condition_words(known),
      known.observability));
  if (std::string line = working_modes_line(assessment.working_modes, known.condition);
      !line.empty()) {
    lines.push_back(std::move(line));
  }
  for (const studies::HeldRow& held : known.held) {
    const std::string effect =
        held.effect_mm
            ? fmt::format(" (1 mm of it moves the tool {:.3f} mm at most)", *held.effect_mm)
            : std::string();
    lines.push_back(
        "held at nominal, because these poses do not show it: " + held.words + effect);
  }
  // Strongest first. Places of one plate are all correlated with each other.
  constexpr std::size_t kMostPairs = 20;
  for (std::size_t i = 0; i < std::min(kMostPairs, known.correlations.size()); ++i) {
    const studies::CorrelationRow& each = known.correlations[i];
    lines.push_back(fmt::format(
        "{} and {} are correlated by {:.3f}", each.first, each.second, each.coefficient));
  }
  if (known.correlations.size() > kMostPairs) {
    lines.push_back(fmt::format(
        "and {} more pairs by more than {}", known.correlations.size() - kMostPairs,
        calibration::kHighCorrelation));
  }
  lines.push_back(assessment.noise.words);
  for (const studies::ParameterRow& row : assessment.parameters) {
    lines.push_back(parameter_line(row));
  }
  if (const auto& map = assessment.position_uncertainty) {
    lines.push_back(fmt::format(
        "positions over the workspace are known to {:.4f} mm on average and {:.4f} mm at worst "
        "(expanded uncertainty of one coordinate, k = {:.0f})",
        geometry::kCoverage * map->mean_sd_mm, geometry::kCoverage * map->max_sd_mm,
        geometry::kCoverage));
  }
  return lines;
}

std::vector<std::string> gross_error_lines(const GrossErrors& errors) {
  std::vector<std::string> lines;
  if (errors.not_possible) {
    lines.push_back("readings were not checked for gross errors: " + *errors.not_possible);
  }
  for (const auto& [set, systematic] :
       {std::pair{"G1", errors.systematic_g1}, std::pair{"G2", errors.systematic_g2}}) {
    if (systematic == 0) continue;
    lines.push_back(fmt::format(
        "{} readings of {} do not agree with the rest, too many for accidents: a dial, the rig "
        "file or the model is wrong; none was left out (sixdial diagnose looks for the cause)",
        systematic, set));
  }
  for (const GrossErrors::Found& each : errors.found) {
    const std::string where =
        each.dial ? fmt::format(
                        "dial {} reads {:.3f} mm too {}", *each.dial, std::abs(each.size_mm),
                        each.size_mm < 0.0 ? "little" : "much")
                  : fmt::format("the position is {:.3f} mm off", each.size_mm);
    lines.push_back(fmt::format(
        "gross error: {} point {} repeat {}: {} ({:.0f} times the noise), {}", each.set,
        each.point, each.repeat, where, each.times_sigma, studies::to_string(each.treatment)));
  }
  return lines;
}

std::string precision_line(const studies::Precision& precision, std::string_view space) {
  if (space == "dials") {
    return fmt::format(
        "this fit of the raw readings of all dials is {:.1f} times as precise as one of "
        "positions (geometric mean)",
        precision.geometric_mean_ratio);
  }
  return fmt::format(
      "a fit of the raw readings of all dials would be {:.1f} times as precise as this one of "
      "positions (geometric mean){}",
      precision.geometric_mean_ratio,
      precision.geometric_mean_ratio > 1.5
          ? ": \"sixdial compare SESSION --space dials\" fits them"
          : "");
}

std::string working_modes_line(
    const std::vector<studies::WorkingModeRow>& modes, double pooled_condition) {
  if (modes.size() < 2) return "";
  std::string text = "condition number by working mode: ";
  for (const studies::WorkingModeRow& each : modes) {
    text += fmt::format(
        "{} {} ({} samples), ", geometry::to_string(each.mode),
        mode_condition_words(each.condition), each.samples);
  }
  text.replace(text.size() - 2, 2, "; ");
  return text + "pooled " +
         mode_condition_words(
             std::isfinite(pooled_condition) ? std::optional(pooled_condition) : std::nullopt);
}

}  // namespace sixdial::report
