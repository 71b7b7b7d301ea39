#include "studies/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "session/bundle.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/assessment.h"
#include "studies/network_json.h"

namespace sixdial::studies {
namespace {

using calibration::PositionObservations;

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

constexpr int kKnownNoise = 1'000'000;  // degrees of freedom of a figure that is taken as known

std::string_view unit_of(int parameter) { return parameter >= geometry::kAlpha ? "rad" : "mm"; }

calibration::Settings settings_of(const CalibrationRequest& request) {
  calibration::Settings settings = calibration::settings_for(request.profile);
  settings.seed = request.seed;
  const auto cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  settings.threads = request.threads > 0 ? request.threads : cores;
  if (request.particles) {
    settings.qpso1.particles = *request.particles;
    settings.qpso2.particles = *request.particles;
  }
  if (request.qpso1_iterations) settings.qpso1.iterations = *request.qpso1_iterations;
  if (request.qpso2_iterations) settings.qpso2.iterations = *request.qpso2_iterations;
  if (request.anfis_epochs) settings.anfis.epochs = *request.anfis_epochs;
  return settings;
}

Json settings_json(const calibration::Settings& settings) {
  const auto swarm = [](const calibration::SwarmSize& size) {
    return Json{{"particles", size.particles}, {"iterations", size.iterations}};
  };
  return {
      {"profile", calibration::to_string(settings.profile)},
      {"filter_linearised_at",
       settings.linearisation == calibration::Linearisation::kNominal ? "nominal" : "estimate"},
      {"search_coordinates",
       settings.coordinates == calibration::SearchCoordinates::kRaw ? "raw" : "whitened"},
      {"q", numbers(settings.first_noise.q)},
      {"r", numbers(settings.first_noise.r)},
      {"p0", numbers(settings.p0)},
      {"noise_mm", settings.noise_mm},
      {"qpso1", swarm(settings.qpso1)},
      {"qpso2", swarm(settings.qpso2)},
      {"anfis",
       {{"kind",
         settings.anfis.kind == calibration::MembershipKind::kGaussian ? "gaussian" : "bell"},
        {"functions", settings.anfis.functions},
        {"epochs", settings.anfis.epochs},
        {"ridge", settings.anfis.ridge},
        {"target_mse_mm2", settings.anfis.target_mse},
        {"cross_validate", settings.cross_validate},
        {"holdout_fraction", settings.holdout_fraction}}},
      {"fixed", std::vector<bool>(settings.fixed.begin(), settings.fixed.end())}};
}

Json inputs_json(const session::Session& session, const calibration::Settings& settings) {
  return {
      {"session", session.name},
      {"rig_name", session.rig.name},
      {"rig_hash", "sha256:" + session::rig_sha256(session)},
      {"data_hash", "sha256:" + session::data_sha256(session)},
      {"samples", session.samples.size()},
      {"rejected_rows", session.rejected.size()},
      {"seed", settings.seed},
      {"settings", settings_json(settings)},
      {"version", SIXDIAL_VERSION}};
}

Json stats_json(const calibration::ErrorStats& stats) {
  if (stats.count == 0) return nullptr;
  const auto n = static_cast<double>(stats.count);
  const double half =
      stats.count > 1 ? calibration::student_95(stats.count - 1) * stats.std_mm / std::sqrt(n)
                      : std::numeric_limits<double>::quiet_NaN();
  return {
      {"mean_mm", stats.mean_mm},
      {"std_mm", stats.std_mm},
      {"max_mm", stats.max_mm},
      {"rmse_mm", stats.rmse_mm},
      {"mean_low_mm", stats.mean_mm - half},
      {"mean_high_mm", stats.mean_mm + half},
      {"points", stats.count},
      {"unreachable", stats.unreachable}};
}

/// Measured minus modelled position [mm] of one sample by a method of table_6; null where a
/// pose cannot be reached.
Json residual(
    const calibration::Result& result, const std::string& method,
    const PositionObservations& set, int sample) {
  const auto column = static_cast<Eigen::Index>(sample);
  const auto row = static_cast<std::size_t>(sample);
  const Eigen::Vector2d measured = set.p_WE.col(column);
  const Eigen::Vector2d q_rad = set.q_rad.col(column);
  if (method == "before" && result.before_uses_targets && set.target_mm[row]) {
    const Eigen::Vector2d missed = measured - *set.target_mm[row];
    return {missed.x(), missed.y()};
  }
  const bool with_network = method.ends_with("+anfis");
  const Eigen::VectorXd& v = method == "before" ? result.nominal
                             : with_network     ? result.v
                                                : result.stage(method).v;
  const auto pose = geometry::forward(v, q_rad, set.assembly[row]);
  if (!pose) return nullptr;
  Eigen::Vector2d left = measured - pose->p_WE;
  if (with_network) {
    const std::vector networks{result.networks[0].model, result.networks[1].model};
    left -= calibration::anfis_correction(networks, q_rad);
  }
  return {left.x(), left.y()};
}

void add_points(
    Json& points, const calibration::Result& result, const session::Session& session,
    const PositionObservations& set) {
  for (int i = 0; i < set.size(); ++i) {
    const int row = set.sample[static_cast<std::size_t>(i)];
    const session::Sample& sample = session.samples[static_cast<std::size_t>(row)];
    Json residuals = Json::array();
    for (const auto& method : result.table_6) {
      residuals.push_back(residual(result, method.method, set, i));
    }
    points.push_back(
        {{"sample", row},
         {"set", sample.set},
         {"point", sample.point},
         {"repeat", sample.repeat},
         {"measured_mm", {set.p_WE(0, i), set.p_WE(1, i)}},
         {"residual_mm", std::move(residuals)}});
  }
}

Json methods_json(const calibration::Result& result) {
  Json methods = Json::array();
  for (const auto& row : result.table_6) {
    Json seconds = nullptr;  // of all stages up to this one
    double sum_s = 0.0;
    for (const auto& stage : result.stages) {
      if (stage.name == "lm" && row.method != "lm") continue;
      sum_s = stage.name == "lm" ? stage.seconds : sum_s + stage.seconds;
      if (stage.name == row.method) seconds = sum_s;
      if (row.method == stage.name + "+anfis") seconds = sum_s + result.anfis_seconds;
    }
    methods.push_back(
        {{"id", row.method},
         {"name", method_name(row.method)},
         {"g1", stats_json(row.g1)},
         {"g2", stats_json(row.g2)},
         {"seconds", std::move(seconds)}});
  }
  return methods;
}

Json parameters_json(const calibration::Result& result) {
  Json parameters = Json::array();
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto& each = result.parameters[i];
    parameters.push_back(
        {{"name", each.name},
         {"unit", unit_of(static_cast<int>(i))},
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

Json identification_json(const calibration::Result& result) {
  const calibration::Identifiability& known = result.identifiability;
  Json held = Json::array();
  for (const auto& each : known.held) {
    held.push_back(
        {{"words", each.words},
         {"direction", numbers(each.direction)},
         {"singular_value", each.singular_value}});
  }
  Json correlations = Json::array();
  for (const auto& each : known.correlations) {
    correlations.push_back(
        {{"first", geometry::kParameters[static_cast<std::size_t>(each.first)].name},
         {"second", geometry::kParameters[static_cast<std::size_t>(each.second)].name},
         {"coefficient", each.coefficient}});
  }
  return {
      {"sigma_mm", result.sigma_mm},
      {"degrees_of_freedom", result.degrees_of_freedom},
      {"covariance", matrix(result.covariance)},
      {"singular_values", numbers(known.singular_values)},
      {"condition", known.condition},
      {"observability", known.observability},
      {"held", std::move(held)},
      {"correlations", std::move(correlations)}};
}

Json trace_json(
    std::string_view name, std::string_view step, const std::vector<Eigen::VectorXd>& history) {
  Json errors = Json::array();
  for (const auto& each : history) errors.push_back(numbers(each));
  return {{"name", name}, {"step", step}, {"error", std::move(errors)}};
}

Json document_of(
    const session::Session& session, const calibration::Result& result,
    const PositionObservations& g1, const PositionObservations& g2) {
  Json points = Json::array();
  add_points(points, result, session, g1);
  add_points(points, result, session, g2);
  Json stages = Json::array();
  for (const auto& stage : result.stages) {
    stages.push_back(
        {{"name", stage.name},
         {"parameters", numbers(stage.v)},
         {"rmse_g1_mm", stage.rmse_g1_mm},
         {"seconds", stage.seconds}});
  }
  const double rmse_mm = result.stage("ekf_dqpso").rmse_g1_mm;
  return {
      {"schema", "sixdial.calibration"},
      {"schema_version", kCalibrationSchemaVersion},
      {"created_utc", session::now_utc_text()},
      {"inputs", inputs_json(session, result.settings)},
      {"parameters", parameters_json(result)},
      {"identification", identification_json(result)},
      {"methods", methods_json(result)},
      {"result_method", "ekf_dqpso+anfis"},
      {"before_is",
       result.before_uses_targets ? "measured minus target" : "measured minus nominal model"},
      {"rmse_mm", rmse_mm},
      {"least_squares_rmse_mm", result.stage("lm").rmse_g1_mm},
      {"above_minimum_mm", result.above_minimum_mm},
      {"noise", {{"q", numbers(result.noise.q)}, {"r", numbers(result.noise.r)}}},
      {"not_finite_evaluations", result.not_finite},
      {"seconds", result.total_seconds},
      {"stages", std::move(stages)},
      {"convergence", Json::array(
                          {{{"name", "QPSO-1"}, {"best_mm", result.qpso1_history_mm}},
                           {{"name", "QPSO-2"}, {"best_mm", result.qpso2_history_mm}}})},
      {"traces", Json::array(
                     {trace_json("EKF", "point", result.filter_history),
                      trace_json("QPSO-2", "iteration", result.qpso2_history)})},
      {"anfis",
       {{"x", network_json(result.networks[0])}, {"y", network_json(result.networks[1])}}},
      {"points", std::move(points)}};
}

/// The part of a number of seconds that is still to come.
std::optional<double> time_left(std::chrono::steady_clock::time_point began, double fraction) {
  constexpr double kTooEarly = 0.02;
  if (fraction < kTooEarly) return std::nullopt;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  return spent.count() * (1.0 - fraction) / fraction;
}

/// Standard deviations and intervals rest on the same noise wherever they are shown.
void use_noise_of(const Json& assessment, Json& document) {
  const int freedom = assessment["noise"]["degrees_of_freedom"].get<int>();
  const double quantile =
      freedom > 0 ? calibration::student_95(freedom) : calibration::student_95(kKnownNoise);
  for (std::size_t i = 0; i < document["parameters"].size(); ++i) {
    Json& each = document["parameters"][i];
    const auto sd = assessment["parameters"][i]["sd"].get<double>();
    const auto value = each["identified"].get<double>();
    each["sd"] = sd;
    each["low_95"] = value - quantile * sd;
    each["high_95"] = value + quantile * sd;
  }
  Json& identification = document["identification"];
  const auto sigma_mm = assessment["noise"]["sigma_mm"].get<double>();
  const auto before_mm = identification["sigma_mm"].get<double>();
  if (before_mm > 0.0) {
    const double factor = sigma_mm * sigma_mm / (before_mm * before_mm);
    for (Json& row : identification["covariance"]) {
      for (Json& each : row) each = factor * each.get<double>();
    }
  }
  identification["sigma_mm"] = sigma_mm;
}

[[noreturn]] void refuse(const calibration::Trouble& trouble, const std::string& session) {
  const bool cancelled = trouble.kind == calibration::Trouble::Kind::kCancelled;
  throw Error(
      cancelled ? ErrorCode::kCancelled : ErrorCode::kBadData, trouble.message,
      {{"session", session}},
      cancelled ? ""
                : "Measure more points of set G1: collect.start, or look at the rig file.");
}

}  // namespace

Json calibrate(
    const session::Session& session, const CalibrationRequest& request,
    const ProgressCallback& progress, std::stop_token stop) {
  calibration::Settings settings = settings_of(request);
  const auto stored_g1 = session::trials_of(session, "G1");
  settings.noise_mm =
      rig_noise_mm(calibration::position_observations(stored_g1)).value_or(settings.noise_mm);
  calibration::IdentifySettings assess;
  assess.noise_mm = settings.noise_mm;
  const bool set_aside = !request.keep_gross_errors;
  const CheckedSession checked = check_gross_errors(session, assess, set_aside);
  const auto g1_trials = session::trials_of(checked.session, "G1");
  const PositionObservations g1 = calibration::position_observations(g1_trials);
  const PositionObservations g2 =
      calibration::position_observations(session::trials_of(checked.session, "G2"));
  const auto space = space_of("positions", g1_trials, checked.session, settings.noise_mm);
  assess.fixed = fixed_parameters(space, request.fix, request.free);
  settings.fixed = assess.fixed;
  const auto began = std::chrono::steady_clock::now();
  const auto tell = [&](const calibration::Progress& now) {
    if (!progress) return;
    const bool counted = now.iterations > 0;
    Progress told{
        .stage = std::string(calibration::to_string(now.stage)),
        .done = counted ? now.iteration : std::llround(100.0 * now.fraction),
        .total = counted ? now.iterations : 100,
        .eta_s = time_left(began, now.fraction)};
    if (now.rmse_mm > 0.0) told.best_mm = now.rmse_mm;
    progress(std::move(told));
  };
  const auto result = calibration::run_dqpso_anfis(
      space, calibration::position_space(g2, session.rig.robot.nominal, settings.noise_mm),
      settings, tell, std::move(stop));
  if (!result) refuse(result.error(), session.name);
  Json document = document_of(session, *result, g1, g2);
  const auto reference =
      calibration::identify(*calibration::find_identifier("lm"), space, assess);
  document["assessment"] = assessment_json(
      space, reference.fit, g1_trials, session::trials_of(checked.session, ""), session.rig);
  use_noise_of(document["assessment"], document);
  document["precision"] = precision_json(g1_trials, checked.session, assess);
  document["gross_errors"] = gross_errors_json(checked, session, set_aside);
  return document;
}

Json result_summary(const Json& document) {
  Json summary = document;
  for (const char* key :
       {"points", "convergence", "traces", "anfis", "residuals", "tool_shift", "by_covariate",
        "dependence", "gross_readings"}) {
    summary.erase(key);
  }
  if (summary.contains("causes")) {
    for (Json& cause : summary["causes"]) cause.erase("signature_plot");
  }
  return summary;
}

std::string method_name(const std::string& id) {
  constexpr std::array kNames{
      std::pair{"before", "before calibration"},
      std::pair{"lse", "LSE"},
      std::pair{"lse_iterated", "LSE, iterated"},
      std::pair{"lm", "least squares (LM)"},
      std::pair{"tikhonov", "Tikhonov"},
      std::pair{"ekf", "EKF"},
      std::pair{"ekf_qpso1", "EKF-QPSO-1"},
      std::pair{"ekf_dqpso", "EKF-DQPSO"},
      std::pair{"anfis", "ANFIS"},
      std::pair{"anfis_paper", "ANFIS as printed"},
      std::pair{"bpnn", "BPNN"},
      std::pair{"gp", "Gaussian process"},
      std::pair{"rbf", "RBF"}};
  const std::size_t plus = id.find('+');
  if (plus != std::string::npos) {
    return method_name(id.substr(0, plus)) + " + " + method_name(id.substr(plus + 1));
  }
  const auto* found =
      std::ranges::find(kNames, id, [](const auto& pair) { return std::string(pair.first); });
  return found == kNames.end() ? id : found->second;
}

std::string table_6_text(const Json& document) {
  constexpr std::array<const char*, 3> kRows{"before", "ekf_dqpso", "ekf_dqpso+anfis"};
  std::string text = fmt::format(
      "{:<20} {:>8} {:>8} {:>8}   {:>8} {:>8} {:>8}\n{:<20} {:>8} {:>8} {:>8}   {:>8} {:>8} "
      "{:>8}\n",
      "position error, mm", "G1", "", "", "G2", "", "", "", "mean", "std", "max", "mean", "std",
      "max");
  const auto cell = [](const Json& set, const char* key) {
    return set.is_object() && set[key].is_number()
               ? fmt::format("{:8.4f}", set[key].get<double>())
               : fmt::format("{:>8}", "-");
  };
  for (const char* id : kRows) {
    for (const Json& method : document.at("methods")) {
      if (method["id"] != id) continue;
      text += fmt::format("{:<20}", method["name"].get<std::string>());
      for (const char* set : {"g1", "g2"}) {
        for (const char* key : {"mean_mm", "std_mm", "max_mm"}) {
          text += ' ' + cell(method[set], key);
        }
        if (std::string_view(set) == "g1") text += "  ";
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace sixdial::studies
