#include "studies/assessment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "session/nearest.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/mode_assessment.h"

namespace sixdial::studies {
namespace {

using calibration::GrossError;
using calibration::ObservationSpace;

constexpr double kDeg = 180.0 / std::numbers::pi;

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return std::vector<double>(values.begin(), values.end());
}

bool is_angle(std::string_view parameter) {
  return parameter == "alpha" || parameter == "clamp" || parameter.starts_with("dtheta");
}

Json gross_error_json(
    const GrossError& error, const session::Session& session, const char* treatment) {
  const session::Sample& sample = session.samples[static_cast<std::size_t>(error.sample)];
  Json dial = nullptr;
  Json reading = nullptr;
  if (error.dial >= 0) {
    const auto k = static_cast<std::size_t>(error.dial);
    dial = session.rig.dials[k].id;
    if (sample.channels[k].value) reading = *sample.channels[k].value;
  }
  return {
      {"sample", error.sample},
      {"set", sample.set},
      {"point", sample.point},
      {"repeat", sample.repeat},
      {"line", sample.line},
      {"dial", std::move(dial)},
      {"reading_mm", std::move(reading)},
      {"size_mm", error.size_mm},
      {"times_sigma", error.times_sigma},
      {"treatment", treatment}};
}

void mark_bad(session::Session& session, const GrossError& error) {
  session::Sample& sample = session.samples[static_cast<std::size_t>(error.sample)];
  if (error.dial < 0) {
    session::set_position(sample, session.rig.dials.size(), std::nullopt);
    return;
  }
  session::ChannelValue& value = sample.channels[static_cast<std::size_t>(error.dial)];
  value.quality = session::Quality::kBad;
  value.reason = "gross error";
}

Json held_json(
    const calibration::Identifiability& known, const calibration::PositionUncertainty* map) {
  Json held = Json::array();
  for (std::size_t i = 0; i < known.held.size(); ++i) {
    const auto& each = known.held[i];
    held.push_back(
        {{"words", each.words},
         {"direction", numbers(each.direction)},
         {"singular_value", each.singular_value},
         {"effect_mm", map != nullptr ? Json(map->held_effect_mm[i]) : Json(nullptr)}});
  }
  return held;
}

Json map_json(const calibration::PositionUncertainty& map) {
  Json sd_x = Json::array();
  Json sd_y = Json::array();
  for (const Eigen::Vector2d& sd : map.sd_mm) {
    sd_x.push_back(sd.x());
    sd_y.push_back(sd.y());
  }
  return {
      {"x_mm", map.x_mm},
      {"y_mm", map.y_mm},
      {"sd_x_mm", std::move(sd_x)},
      {"sd_y_mm", std::move(sd_y)},
      {"radius_95_mm", map.radius_95_mm},
      {"mean_sd_mm", map.mean_sd_mm},
      {"max_sd_mm", map.max_sd_mm},
      {"max_radius_95_mm", map.max_radius_95_mm},
      {"worst_mm", numbers(map.worst_mm)}};
}

/// "166"; "3.1e+16 (64 without what is held)".
std::string condition_words(const Json& known) {
  const auto words = [](const Json& value) {
    if (!value.is_number()) return std::string("infinite");
    const auto number = value.get<double>();
    return number < 1e5 ? fmt::format("{:.0f}", number) : fmt::format("{:.1e}", number);
  };
  std::string text = words(known["condition"]);
  if (!known["held"].empty()) {
    text += fmt::format(" ({} without what is held)", words(known["condition_determined"]));
  }
  return text;
}

Json parameters_json(const std::vector<calibration::ParameterEstimate>& estimates) {
  Json parameters = Json::array();
  for (const auto& each : estimates) {
    parameters.push_back(
        {{"name", each.name},
         {"unit", is_angle(each.name) ? "rad" : "mm"},
         {"nominal", each.nominal},
         {"identified", each.value},
         {"sd", each.sd},
         {"low_95", each.low_95},
         {"high_95", each.high_95},
         {"fixed", each.fixed},
         {"partly_held", each.partly_held}});
  }
  return parameters;
}

}  // namespace

Json precision_json(
    std::span<const simulation::Trial> g1, const session::Session& session,
    const calibration::IdentifySettings& settings) {
  constexpr std::array<const char*, 2> kSpaces{"positions", "dials"};
  std::array<std::vector<calibration::ParameterEstimate>, 2> estimates;
  for (std::size_t k = 0; k < kSpaces.size(); ++k) {
    const ObservationSpace space = k == 0 ? calibration::position_space(
                                                calibration::position_observations(g1),
                                                session.rig.robot.nominal, settings.noise_mm)
                                          : calibration::dial_space(g1, session.rig);
    if (2 * space.samples() <= space.parameters()) return nullptr;
    calibration::IdentifySettings here = settings;
    if (!here.fixed.empty()) here.fixed.resize(static_cast<std::size_t>(space.parameters()), 0);
    const auto found = calibration::identify(*calibration::find_identifier("lm"), space, here);
    if (found.status == calibration::FitStatus::kBadStart || found.fit.held > 0) return nullptr;
    Eigen::MatrixXd covariance;
    estimates[k] = calibration::estimates_with_noise(
        space, found.fit, calibration::noise_estimate(space, found.fit), covariance);
  }
  Json rows = Json::array();
  double log_ratio = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < geometry::kParameterCount; ++i) {
    const auto& by_positions = estimates[0][i];
    const auto& by_dials = estimates[1][i];
    if (by_positions.fixed || !(by_dials.sd > 0.0)) continue;
    const double ratio = by_positions.sd / by_dials.sd;
    rows.push_back(
        {{"name", by_positions.name},
         {"unit", is_angle(by_positions.name) ? "rad" : "mm"},
         {"positions_sd", by_positions.sd},
         {"dials_sd", by_dials.sd},
         {"ratio", ratio}});
    log_ratio += std::log(ratio);
    ++count;
  }
  if (count == 0) return nullptr;
  return {
      {"parameters", std::move(rows)}, {"geometric_mean_ratio", std::exp(log_ratio / count)}};
}

std::string precision_line(const Json& precision) {
  return fmt::format(
      "raw readings of all dials determine the parameters {:.1f} times as precisely as "
      "positions of the active three do (geometric mean){}",
      precision["geometric_mean_ratio"].get<double>(),
      precision["geometric_mean_ratio"].get<double>() > 1.5 ? ": fit with --space dials" : "");
}

std::optional<double> rig_noise_mm(const calibration::PositionObservations& set) {
  double sum_mm2 = 0.0;
  for (const Eigen::Matrix2d& covariance : set.covariance_mm2) {
    sum_mm2 += covariance.trace() / 2.0;
  }
  if (set.empty() || !(sum_mm2 > 0.0)) return std::nullopt;
  return std::sqrt(sum_mm2 / set.size());
}

CheckedSession check_gross_errors(
    const session::Session& session, const calibration::IdentifySettings& settings,
    bool set_aside) {
  CheckedSession checked{session, {}, {}};
  const auto g1 = session::trials_of(session, "G1");
  calibration::IdentifySettings wide = settings;
  wide.fixed.clear();  // a robot that is told less about itself accuses nobody wrongly
  checked.g1 = calibration::find_gross_errors(g1, session.rig, wide);
  const auto g2 = session::trials_of(session, "G2");
  if (!g2.empty()) checked.g2 = calibration::judge_readings(g2, session.rig, checked.g1);
  if (set_aside) {
    for (const GrossError& each : checked.g1.found) mark_bad(checked.session, each);
  }
  return checked;
}

Json gross_errors_json(
    const CheckedSession& checked, const session::Session& session, bool set_aside) {
  Json found = Json::array();
  for (const GrossError& each : checked.g1.found) {
    found.push_back(gross_error_json(each, session, set_aside ? "set aside" : "kept"));
  }
  for (const GrossError& each : checked.g2.found) {
    found.push_back(gross_error_json(each, session, "kept, validates"));
  }
  return {
      {"found", std::move(found)},
      {"readings", checked.g1.readings},
      {"sigma_mm", checked.g1.sigma_mm},
      {"limit_times_sigma", checked.g1.limit_times_sigma},
      {"set_aside", set_aside},
      {"systematic", {{"g1", checked.g1.systematic}, {"g2", checked.g2.systematic}}},
      {"not_possible",
       checked.g1.not_possible.empty() ? Json(nullptr) : Json(checked.g1.not_possible)}};
}

Json assessment_json(
    const ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    std::span<const simulation::Trial> g1, std::span<const simulation::Trial> all,
    const geometry::Rig& rig) {
  const auto noise = calibration::noise_estimate(space, fit);
  Eigen::MatrixXd covariance;
  const auto estimates = calibration::estimates_with_noise(space, fit, noise, covariance);
  const auto known =
      calibration::identifiability(fit, space.parameter_names(), space.samples());
  std::optional<calibration::PositionUncertainty> map;
  if (const auto workspace = calibration::workspace_of(all)) {
    map = calibration::position_uncertainty(
        fit.x.head<geometry::kParameterCount>(), covariance, fit, rig.robot.working_mode,
        *workspace, calibration::quantile_95(noise));
  }
  Json correlations = Json::array();
  for (const auto& each : known.correlations) {
    correlations.push_back(
        {{"first", space.parameter_info[static_cast<std::size_t>(each.first)].name},
         {"second", space.parameter_info[static_cast<std::size_t>(each.second)].name},
         {"coefficient", each.coefficient}});
  }
  const auto known_noise = [](const auto& from) -> Json {
    if (!from) return nullptr;
    return {{"sigma_mm", from->sigma_mm}, {"degrees_of_freedom", from->degrees_of_freedom}};
  };
  const double largest = known.singular_values.size() > 0 ? known.singular_values[0] : 0.0;
  const auto determined = known.singular_values.size() - fit.held;
  return {
      {"space", space.name},
      {"samples", space.samples()},
      {"readings", space.rows()},
      {"noise",
       {{"source", calibration::to_string(noise.source)},
        {"sigma_mm", noise.sigma_mm},
        {"degrees_of_freedom", noise.degrees_of_freedom},
        {"repeats", known_noise(noise.repeats)},
        {"residual", known_noise(noise.residual)},
        {"rig_file_mm", noise.rig_file_mm},
        {"lack_of_fit", noise.lack_of_fit ? Json(*noise.lack_of_fit) : Json(nullptr)},
        {"words", noise.words}}},
      {"parameters", parameters_json(estimates)},
      {"working_modes", working_modes_json(space, fit, g1, rig)},
      {"identifiability",
       {{"singular_values", numbers(known.singular_values)},
        {"condition", known.condition},
        {"condition_determined", determined > 0
                                     ? Json(largest / known.singular_values[determined - 1])
                                     : Json(nullptr)},
        {"observability", known.observability},
        {"free", fit.free},
        {"determined", determined},
        {"held", held_json(known, map ? &*map : nullptr)},
        {"correlations", std::move(correlations)}}},
      {"position_uncertainty", map ? map_json(*map) : Json(nullptr)}};
}

ObservationSpace space_of(
    const std::string& name, std::span<const simulation::Trial> trials,
    const session::Session& session, double noise_mm) {
  if (name == "positions") {
    return calibration::position_space(
        calibration::position_observations(trials), session.rig.robot.nominal, noise_mm);
  }
  ObservationSpace space = calibration::dial_space(trials, session.rig);
  if (space.samples() == 0) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format("G1 of {} has no dial readings that can be fitted", session.name),
        {{"session", session.name}},
        "The session gives positions (x_mm, y_mm): compare with --space positions.");
  }
  return space;
}

std::vector<char> fixed_parameters(
    const ObservationSpace& space, const std::vector<std::string>& fix,
    const std::vector<std::string>& free) {
  const auto index_of = [&](const std::string& name) {
    const auto index = space.find(name);
    if (index) return static_cast<std::size_t>(*index);
    const auto nearest = session::nearest_name(name, space.parameter_names());
    throw Error(
        ErrorCode::kInvalidParams,
        fmt::format("there is no parameter '{}'", name.substr(0, 64)), {{"param", "fix"}},
        nearest ? fmt::format("The nearest known one is '{}'.", *nearest)
                : fmt::format("One of: {}.", fmt::join(space.parameter_names(), ", ")));
  };
  std::vector<char> fixed(static_cast<std::size_t>(space.parameters()), free.empty() ? 0 : 1);
  for (const std::string& name : free) fixed[index_of(name)] = 0;
  for (const std::string& name : fix) {
    if (std::ranges::find(free, name) != free.end()) {
      throw Error(
          ErrorCode::kInvalidParams,
          fmt::format("parameter '{}' is asked to be fixed and free", name), {{"param", "fix"}},
          "Name it once.");
    }
    fixed[index_of(name)] = 1;
  }
  return fixed;
}

std::vector<std::string> gross_error_lines(const Json& gross_errors) {
  std::vector<std::string> lines;
  if (gross_errors["not_possible"].is_string()) {
    lines.push_back(
        "not checked for gross errors: " + gross_errors["not_possible"].get<std::string>());
  }
  for (const char* set : {"g1", "g2"}) {
    const int systematic = gross_errors["systematic"][set].get<int>();
    if (systematic == 0) continue;
    lines.push_back(fmt::format(
        "{} readings of {} stand out, more than accidents can: a dial, the rig file or the "
        "model is wrong; none was set aside (sixdial diagnose looks for the cause)",
        systematic, set[1] == '1' ? "G1" : "G2"));
  }
  for (const Json& each : gross_errors["found"]) {
    const std::string where =
        each["dial"].is_string()
            ? fmt::format(
                  "dial {} reads {:.3f} mm too {}", each["dial"].get<std::string>(),
                  std::abs(each["size_mm"].get<double>()),
                  each["size_mm"].get<double>() < 0.0 ? "little" : "much")
            : fmt::format("the position is {:.3f} mm off", each["size_mm"].get<double>());
    lines.push_back(fmt::format(
        "gross error: {} point {} repeat {}: {} ({:.0f} times the noise), {}",
        each["set"].get<std::string>(), each["point"].get<int>(), each["repeat"].get<int>(),
        where, each["times_sigma"].get<double>(), each["treatment"].get<std::string>()));
  }
  return lines;
}

std::vector<std::string> assessment_lines(const Json& assessment) {
  std::vector<std::string> lines;
  const Json& known = assessment["identifiability"];
  lines.push_back(fmt::format(
      "{} of {} free parameters are determined by {} samples; condition number {}, "
      "observability {:.4f}",
      known["determined"].get<int>(), known["free"].get<int>(),
      assessment["samples"].get<int>(), condition_words(known),
      known["observability"].get<double>()));
  if (std::string line = working_modes_line(assessment["working_modes"], known["condition"]);
      !line.empty()) {
    lines.push_back(std::move(line));
  }
  for (const Json& held : known["held"]) {
    const std::string effect = held["effect_mm"].is_number()
                                   ? fmt::format(
                                         " (1 mm of it moves the tool {:.3f} mm at most)",
                                         held["effect_mm"].get<double>())
                                   : std::string();
    lines.push_back(
        "held at nominal, the poses cannot tell: " + held["words"].get<std::string>() + effect);
  }
  for (const Json& each : known["correlations"]) {
    lines.push_back(fmt::format(
        "{} and {} are correlated by {:.3f}", each["first"].get<std::string>(),
        each["second"].get<std::string>(), each["coefficient"].get<double>()));
  }
  lines.push_back(assessment["noise"]["words"].get<std::string>());
  for (const Json& each : assessment["parameters"]) {
    const bool angle = each["unit"] == "rad";
    const double shown = angle ? kDeg : 1.0;
    const char* unit = angle ? "deg" : "mm";
    std::string line = fmt::format(
        "{:<8} {:>10.4f} {}", each["name"].get<std::string>(),
        shown * each["identified"].get<double>(), unit);
    if (each["fixed"].get<bool>()) {
      line += "  fixed at nominal";
    } else {
      line += fmt::format(
          "  sd {:.4f}, 95 % {:.4f} to {:.4f}{}", shown * each["sd"].get<double>(),
          shown * each["low_95"].get<double>(), shown * each["high_95"].get<double>(),
          each["partly_held"].get<bool>() ? ", leans on nominal (partly held)" : "");
    }
    lines.push_back(std::move(line));
  }
  const Json& map = assessment["position_uncertainty"];
  if (map.is_object()) {
    lines.push_back(fmt::format(
        "predicted position over the workspace: sd {:.4f} mm on average, {:.4f} mm at worst; "
        "95 % within {:.4f} mm",
        map["mean_sd_mm"].get<double>(), map["max_sd_mm"].get<double>(),
        map["max_radius_95_mm"].get<double>()));
  }
  return lines;
}

}  // namespace sixdial::studies
