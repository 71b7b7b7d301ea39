#include "studies/assessment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calibration/predicted_position.h"
#include "calibration/reading_space.h"
#include "geometry/tool.h"
#include "session/measured_turn.h"
#include "session/nearest.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/changed_midway.h"
#include "studies/slipped_turns.h"

namespace sixdial::studies {
namespace {

using calibration::GrossError;
using calibration::ObservationSpace;

constexpr std::array kTreatments{
    std::pair{Treatment::kSetAside, std::string_view("set aside")},
    std::pair{Treatment::kKept, std::string_view("kept")},
    std::pair{Treatment::kKeptValidates, std::string_view("kept, validates")}};

GrossErrors::Found found_row(
    const GrossError& error, const session::Session& session, Treatment treatment) {
  const session::Sample& sample = session.samples[static_cast<std::size_t>(error.sample)];
  GrossErrors::Found row{
      .sample = error.sample,
      .set = sample.set,
      .point = sample.point,
      .repeat = sample.repeat,
      .line = sample.line,
      .size_mm = error.size_mm,
      .times_sigma = error.times_sigma,
      .treatment = treatment};
  if (error.dial >= 0) {
    const auto k = static_cast<std::size_t>(error.dial);
    row.dial = session.rig.dials[k].id;
    row.reading_mm = sample.channels[k].value;
  }
  return row;
}

void mark_bad(session::Session& session, const GrossError& error) {
  session::Sample& sample = session.samples[static_cast<std::size_t>(error.sample)];
  if (error.dial < 0) {
    session::set_position(sample, session.rig.dials.size(), std::nullopt);
    if (!calibration::gives_positions(session.rig)) {
      sample.others.assign(sample.others.size(), std::nullopt);
    }
    session::set_turn(sample, session::layout_of(session.rig), std::nullopt);
    return;
  }
  session::ChannelValue& value = sample.channels[static_cast<std::size_t>(error.dial)];
  value.quality = session::Quality::kBad;
  value.reason = "gross error";
}

PositionMap map_of(const calibration::PositionUncertainty& from) {
  PositionMap map{
      .x_mm = from.x_mm,
      .y_mm = from.y_mm,
      .radius_95_mm = from.radius_95_mm,
      .mean_sd_mm = from.mean_sd_mm,
      .max_sd_mm = from.max_sd_mm,
      .max_radius_95_mm = from.max_radius_95_mm,
      .worst_mm = from.worst_mm};
  for (const Eigen::VectorXd& sd : from.sd_mm) {
    map.sd_x_mm.push_back(sd.x());
    map.sd_y_mm.push_back(sd.y());
  }
  return map;
}

/// Intervals hold what the poses leave open too: there a parameter is as well known as before.
void add_what_is_held(
    Assessment& result, Eigen::MatrixXd& covariance, const Eigen::MatrixXd& held) {
  covariance += held;
  const double quantile = calibration::quantile_95(result.noise);
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    ParameterRow& row = result.parameters[i];
    if (row.fixed || !(held(k, k) > 0.0)) continue;
    row.sd = std::hypot(row.sd, std::sqrt(held(k, k)));
    row.low_95 = row.identified - quantile * row.sd;
    row.high_95 = row.identified + quantile * row.sd;
  }
}

IdentifiabilityRow identifiability_of(
    const ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    const calibration::PositionUncertainty* map) {
  const std::vector<std::string_view> names = space.parameter_names();
  const auto known =
      calibration::identifiability(fit, names, space.samples(), space.named_directions);
  const auto determined = static_cast<int>(known.singular_values.size()) - fit.held;
  IdentifiabilityRow row{
      .singular_values = known.singular_values,
      .condition = known.condition,
      .observability = known.observability,
      .free = fit.free,
      .determined = determined,
      .correlations = correlation_rows(known, names)};
  if (determined > 0) {
    row.condition_determined = known.singular_values[0] / known.singular_values[determined - 1];
  }
  for (std::size_t i = 0; i < known.held.size(); ++i) {
    const auto& each = known.held[i];
    HeldRow held{
        .words = each.words,
        .direction = each.direction,
        .singular_value = each.singular_value};
    if (map != nullptr) held.effect_mm = map->held_effect_mm[i];
    row.held.push_back(std::move(held));
  }
  return row;
}

}  // namespace

std::string_view to_string(Treatment treatment) {
  for (const auto& [value, name] : kTreatments) {
    if (value == treatment) return name;
  }
  return "";
}

std::optional<Treatment> treatment_from(std::string_view text) {
  for (const auto& [value, name] : kTreatments) {
    if (name == text) return value;
  }
  return std::nullopt;
}

std::vector<ParameterRow> parameter_rows(
    const std::vector<calibration::ParameterEstimate>& estimates,
    const ObservationSpace& space) {
  std::vector<ParameterRow> rows;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const auto& each = estimates[i];
    rows.push_back(
        {.name = each.name,
         .unit = space.parameter_info.at(i).unit,
         .nominal = each.nominal,
         .identified = each.value,
         .sd = each.sd,
         .low_95 = each.low_95,
         .high_95 = each.high_95,
         .fixed = each.fixed,
         .partly_held = each.partly_held});
  }
  return rows;
}

std::vector<CorrelationRow> correlation_rows(
    const calibration::Identifiability& known, std::span<const std::string_view> names) {
  std::vector<CorrelationRow> rows;
  for (const auto& each : known.correlations) {
    rows.push_back(
        {.first = std::string(names[static_cast<std::size_t>(each.first)]),
         .second = std::string(names[static_cast<std::size_t>(each.second)]),
         .coefficient = each.coefficient});
  }
  return rows;
}

std::optional<Precision> precision_of(
    const ObservationSpace& space, const calibration::Identified& fit,
    std::span<const simulation::Trial> g1, const session::Session& session,
    const calibration::IdentifySettings& settings) {
  const auto estimated = [&](const ObservationSpace& in, const calibration::Identified* known) {
    std::vector<calibration::ParameterEstimate> none;
    if (2 * in.samples() <= in.parameters()) return none;
    calibration::IdentifySettings here = settings;
    if (!here.fixed.empty()) here.fixed.resize(static_cast<std::size_t>(in.parameters()), 0);
    const auto found =
        known != nullptr ? *known
                         : calibration::identify(*calibration::find_identifier("lm"), in, here);
    if (found.status == calibration::FitStatus::kBadStart || found.fit.held > 0) return none;
    Eigen::MatrixXd covariance;
    ObservationSpace noise_alone = in;
    noise_alone.rig_mm.resize(0, 0);
    return calibration::estimates_with_noise(
        noise_alone, found.fit, calibration::weighting_of(in, here),
        calibration::noise_estimate(in, found.fit), {}, covariance);
  };
  const bool of_positions = space.name == "positions";
  if (!of_positions && space.name != "dials") return std::nullopt;
  const auto here = estimated(space, &fit);
  if (here.empty()) return std::nullopt;
  const auto other = estimated(
      of_positions ? calibration::dial_space(g1, session.rig)
                   : calibration::position_space(g1, session.rig, settings.noise_mm),
      nullptr);
  if (other.empty()) return std::nullopt;
  const std::array estimates{of_positions ? here : other, of_positions ? other : here};
  Precision precision;
  double log_ratio = 0.0;
  for (std::size_t i = 0; i < estimates[0].size() && i < estimates[1].size(); ++i) {
    const auto& by_positions = estimates[0][i];
    const auto& by_dials = estimates[1][i];
    if (by_positions.fixed || !(by_dials.sd > 0.0)) continue;
    const double ratio = by_positions.sd / by_dials.sd;
    precision.parameters.push_back(
        {.name = by_positions.name,
         .unit = space.parameter_info.at(i).unit,
         .positions_sd = by_positions.sd,
         .dials_sd = by_dials.sd,
         .ratio = ratio});
    log_ratio += std::log(ratio);
  }
  if (precision.parameters.empty()) return std::nullopt;
  precision.geometric_mean_ratio =
      std::exp(log_ratio / static_cast<double>(precision.parameters.size()));
  return precision;
}

std::optional<double> rig_noise_mm(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  if (!calibration::gives_positions(rig)) {
    return rig.instrument.sd_mm > 0.0 ? std::optional(rig.instrument.sd_mm) : std::nullopt;
  }
  double sum_mm2 = 0.0;
  int positions = 0;
  for (const simulation::Trial& trial : trials) {
    if (!trial.position_mm || !trial.position_mm->allFinite() || !trial.q.allFinite()) continue;
    ++positions;
    sum_mm2 +=
        trial.covariance_or_zero().trace() / static_cast<double>(trial.position_mm->size());
  }
  if (positions == 0 || !(sum_mm2 > 0.0)) return std::nullopt;
  return std::sqrt(sum_mm2 / positions);
}

CheckedSession check_gross_errors(
    const session::Session& session, const calibration::IdentifySettings& settings,
    bool set_aside, const std::optional<std::string>& not_possible) {
  CheckedSession checked{session, {}};
  const auto split = [&] {
    checked.all = session::trials_of(checked.session, "");
    checked.g1.clear();
    checked.g2.clear();
    for (const simulation::Trial& trial : checked.all) {
      const std::string& set = session.samples[static_cast<std::size_t>(trial.sample)].set;
      if (set == "G1") checked.g1.push_back(trial);
      if (set == "G2") checked.g2.push_back(trial);
    }
  };
  split();
  checked.found.set_aside = set_aside;
  if (not_possible) {
    checked.found.not_possible = not_possible;
    return checked;
  }
  checked.rig = diagnosis::fit_rig(checked.g1, session.rig);
  if (checked.rig) {
    checked.session.rig = checked.rig->rig;
    split();
  }
  calibration::IdentifySettings wide = settings;
  wide.fixed.clear();  // a robot that is told less about itself accuses nobody wrongly
  const auto in_g1 = calibration::find_gross_errors(checked.g1, checked.session.rig, wide);
  checked.warnings = changed_midway(checked.all, checked.session, in_g1);
  GrossErrors& found = checked.found;
  found.readings = in_g1.readings;
  found.sigma_mm = in_g1.sigma_mm;
  found.limit_times_sigma = in_g1.limit_times_sigma;
  found.systematic_g1 = in_g1.systematic;
  if (!in_g1.not_possible.empty()) found.not_possible = in_g1.not_possible;
  for (const GrossError& each : in_g1.found) {
    found.found.push_back(
        found_row(each, session, set_aside ? Treatment::kSetAside : Treatment::kKept));
    if (set_aside) mark_bad(checked.session, each);
  }
  if (!checked.g2.empty()) {
    const auto in_g2 = calibration::judge_readings(checked.g2, checked.session.rig, in_g1);
    found.systematic_g2 = in_g2.systematic;
    for (const GrossError& each : in_g2.found) {
      found.found.push_back(found_row(each, session, Treatment::kKeptValidates));
    }
  }
  if (set_aside && !in_g1.found.empty()) split();
  if (!set_aside || !in_g1.not_possible.empty()) return checked;
  if (auto slipped = leave_out_slipped_turns(checked.session, checked.g1, wide)) {
    checked.warnings.push_back(std::move(*slipped));
    split();
  }
  return checked;
}

Assessment assess(
    const ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    calibration::Weighting weighting, std::span<const simulation::Trial> g1,
    std::span<const simulation::Trial> all, const geometry::Rig& rig) {
  Assessment result{
      .space = space.name,
      .samples = calibration::measured_samples(space),
      .readings =
          space.first_row[static_cast<std::size_t>(calibration::measured_samples(space))],
      .noise = calibration::noise_estimate(space, fit),
      .structure = calibration::smooth_structure(space, fit, weighting),
      .working_modes = working_modes_of(space, fit, g1, rig)};
  Eigen::MatrixXd covariance;
  result.parameters = parameter_rows(
      calibration::estimates_with_noise(
          space, fit, weighting, result.noise, result.structure, covariance),
      space);
  add_what_is_held(result, covariance, calibration::held_covariance(fit, space.parameter_info));
  result.covariance = covariance;
  std::optional<calibration::PositionUncertainty> map;
  const geometry::Tool tool(rig);
  const auto workspace = calibration::workspace_of(all);
  if (workspace && tool.has_inverse()) {
    const calibration::PredictedPosition predicted(
        space, fit, weighting, result.noise.spread_mm, result.structure);
    map = calibration::position_uncertainty(
        tool, fit.x.head(rig.robot.nominal.size()), predicted, fit, rig.robot.working_mode,
        *workspace, calibration::quantile_95(result.noise));
    result.position_uncertainty = map_of(*map);
  }
  result.identifiability = identifiability_of(space, fit, map ? &*map : nullptr);
  return result;
}

ObservationSpace space_of(
    const std::string& name, std::span<const simulation::Trial> trials,
    const session::Session& session, double noise_mm) {
  if (name == "positions") {
    return calibration::fitted_space(trials, session.rig, noise_mm);
  }
  ObservationSpace space = calibration::dial_space(trials, session.rig);
  if (space.samples() == 0) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format("G1 of {} has no dial readings that can be fitted", session.name),
        {{"session", session.name}},
        "The session gives positions (x_mm, y_mm): sixdial compare SESSION --space positions.");
  }
  return space;
}

std::vector<char> fixed_parameters(
    const ObservationSpace& space, int robot_parameters, const std::vector<std::string>& fix,
    const std::vector<std::string>& free) {
  const auto index_of = [&](const std::string& name) {
    const auto index = space.find(name);
    if (index) return static_cast<std::size_t>(*index);
    const auto nearest = session::nearest_name(name, space.parameter_names());
    throw StudyError(
        StudyErrorCode::kInvalidParams,
        fmt::format("there is no parameter '{}'", name.substr(0, 64)), {{"param", "fix"}},
        nearest ? fmt::format("The nearest known one is '{}'.", *nearest)
                : fmt::format("One of: {}.", fmt::join(space.parameter_names(), ", ")));
  };
  std::vector<char> fixed(static_cast<std::size_t>(space.parameters()), free.empty() ? 0 : 1);
  for (const std::string& name : free) fixed[index_of(name)] = 0;
  for (const std::string& name : fix) {
    if (std::ranges::find(free, name) != free.end()) {
      throw StudyError(
          StudyErrorCode::kInvalidParams,
          fmt::format("parameter '{}' is asked to be fixed and free", name), {{"param", "fix"}},
          "Name it once.");
    }
    fixed[index_of(name)] = 1;
  }
  // An instrument's own parameters stand behind the robot's.
  if (std::count(fixed.begin(), fixed.begin() + robot_parameters, 1) == robot_parameters) {
    throw StudyError(
        StudyErrorCode::kInvalidParams,
        "every parameter of the robot is fixed: there is nothing to identify",
        {{"param", "fix"}}, "Leave at least one parameter free.");
  }
  return fixed;
}

}  // namespace sixdial::studies
