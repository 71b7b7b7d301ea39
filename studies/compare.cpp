#include "studies/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "calibration/comparison.h"
#include "calibration/five_bar/spaces.h"
#include "session/bundle.h"
#include "session/clock_text.h"
#include "session/nearest.h"
#include "session/trials.h"
#include "studies/assessment.h"
#include "studies/calibrate.h"

namespace sixdial::studies {
namespace {

using calibration::ComparedMethod;
using calibration::Comparison;
using calibration::MethodChoice;

MethodChoice choice_of(const std::string& id) {
  auto choice = calibration::method_choice(id);
  if (choice) return *std::move(choice);
  const calibration::UnknownMethod& unknown = choice.error();
  const auto nearest = session::nearest_name(unknown.word, unknown.known);
  const std::string shown = id.substr(0, 64);
  const std::string part = unknown.word.substr(0, 64);
  throw Error(
      ErrorCode::kInvalidParams,
      part == shown ? fmt::format("there is no method '{}'", shown)
                    : fmt::format("there is no '{}' for the method '{}'", part, shown),
      {{"param", "methods"}},
      nearest ? fmt::format("The nearest known one is '{}'.", *nearest)
              : fmt::format("One of: {}.", fmt::join(unknown.known, ", ")));
}

std::vector<MethodChoice> choices_of(const CompareRequest& request) {
  std::vector<MethodChoice> choices;
  const auto add = [&](const std::string& id) {
    if (std::ranges::find(choices, id, &MethodChoice::id) == choices.end()) {
      choices.push_back(choice_of(id));
    }
  };
  for (const std::string& id : request.methods) add(id);
  if (request.methods.empty()) {
    for (const std::string_view id : calibration::kComparedMethods) add(std::string(id));
  }
  return choices;
}

calibration::Loss loss_of(const std::string& name) {
  if (name == "huber") return calibration::Loss::kHuber;
  if (name == "cauchy") return calibration::Loss::kCauchy;
  return calibration::Loss::kSquare;
}

calibration::ComparisonSettings settings_of(const CompareRequest& request) {
  calibration::ComparisonSettings settings;
  const auto profile =
      calibration::profile_from(request.profile).value_or(calibration::Profile::kDefault);
  const calibration::Settings paper = calibration::settings_for(profile);
  calibration::IdentifySettings& identify = settings.identify;
  identify.linearisation = paper.linearisation;
  identify.coordinates = paper.coordinates;
  identify.loss = loss_of(request.loss);
  identify.seed = settings.residual.seed = request.seed;
  const auto cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  identify.threads = request.threads > 0 ? request.threads : cores;
  const auto use = [](int asked, int& setting) {
    if (asked > 0) setting = asked;
  };
  use(request.particles, identify.qpso1.particles);
  use(request.particles, identify.qpso2.particles);
  use(request.qpso1_iterations, identify.qpso1.iterations);
  use(request.qpso2_iterations, identify.qpso2.iterations);
  use(request.anfis_epochs, settings.residual.anfis.epochs);
  use(request.bpnn_epochs, settings.residual.bpnn_epochs);
  return settings;
}

Json stats_json(const calibration::ErrorStats& stats) {
  if (stats.count == 0) return nullptr;
  return {{"mean_mm", stats.mean_mm}, {"std_mm", stats.std_mm},
          {"max_mm", stats.max_mm},   {"rmse_mm", stats.rmse_mm},
          {"points", stats.count},    {"unreachable", stats.unreachable}};
}

Json method_json(
    const ComparedMethod& method, const Comparison& all,
    const calibration::ObservationSpace& space) {
  Json json{
      {"id", method.choice.id},
      {"name", method_name(method.choice.id)},
      {"identifier", nullptr},
      {"residual_model", nullptr},
      {"description", "as the robot is commanded today"},
      {"g1", stats_json(method.errors.g1)},
      {"g2", stats_json(method.errors.g2)},
      {"g1_errors_mm", method.errors.g1_mm},
      {"g2_errors_mm", method.errors.g2_mm},
      {"seconds", method.identify_seconds + method.residual_seconds},
      {"identify_seconds", method.identify_seconds},
      {"residual_seconds", method.residual_seconds}};
  if (!method.robot) return json;
  const calibration::IdentifiedRobot& robot = all.robots[*method.robot];
  json["identifier"] = robot.identifier->name;
  json["description"] = robot.identifier->description;
  json["status"] = calibration::describe(robot.found.status);
  json["iterations"] = robot.found.iterations;
  json["objective_rmse_mm"] = robot.found.rmse;
  Json parameters = Json::object();
  for (int i = 0; i < space.parameters(); ++i) {
    const std::string name(space.parameter_info[static_cast<std::size_t>(i)].name);
    parameters[name] = {
        {"value", robot.found.x[i]}, {"sd", std::sqrt(robot.found.covariance(i, i))}};
  }
  json["parameters"] = std::move(parameters);
  if (method.choice.residual != nullptr) {
    json["residual_model"] = method.choice.residual->name;
    json["description"] = fmt::format(
        "{}; {}", robot.identifier->description, method.choice.residual->description);
    json["note"] = method.residual.note;
    json["effective_parameters"] = std::vector<double>(
        method.residual.effective_parameters.begin(),
        method.residual.effective_parameters.end());
  }
  return json;
}

/// Lowest mean error on G2 (on G1 where there is no G2); null without any.
Json best_of(const Json& methods) {
  Json best = nullptr;
  double least = HUGE_VAL;
  for (const char* set : {"g2", "g1"}) {
    for (const Json& method : methods) {
      if (!method[set].is_object() || method[set]["unreachable"] != 0) continue;
      const auto mean = method[set]["mean_mm"].get<double>();
      if (mean < least) {
        least = mean;
        best = method["id"];
      }
    }
    if (!best.is_null()) break;
  }
  return best;
}

Json swarm_json(const calibration::SwarmSize& size) {
  return {{"particles", size.particles}, {"iterations", size.iterations}};
}

Json inputs_json(
    const session::Session& session, const CompareRequest& request,
    const calibration::ComparisonSettings& settings,
    const calibration::ObservationSpace& space) {
  Json fixed = Json::array();
  for (int i = 0; i < space.parameters(); ++i) {
    if (calibration::is_fixed(settings.identify, i)) {
      fixed.push_back(space.parameter_info[static_cast<std::size_t>(i)].name);
    }
  }
  return {
      {"session", session.name},
      {"rig_name", session.rig.name},
      {"rig_hash", "sha256:" + session::rig_sha256(session)},
      {"data_hash", "sha256:" + session::data_sha256(session)},
      {"samples", session.samples.size()},
      {"rejected_rows", session.rejected.size()},
      {"seed", request.seed},
      {"version", SIXDIAL_VERSION},
      {"settings",
       {{"space", request.space},
        {"profile", request.profile},
        {"loss", request.loss},
        {"fixed", std::move(fixed)},
        {"gross_errors", request.keep_gross_errors ? "listed" : "set aside"},
        {"noise_mm", settings.identify.noise_mm},
        {"hold_uncertainty_mm", settings.identify.hold_uncertainty_mm},
        {"first_variance", settings.identify.first_variance},
        {"qpso1", swarm_json(settings.identify.qpso1)},
        {"qpso2", swarm_json(settings.identify.qpso2)},
        {"anfis_epochs", settings.residual.anfis.epochs},
        {"bpnn_epochs", settings.residual.bpnn_epochs}}}};
}

[[noreturn]] void refuse(const calibration::Trouble& trouble, const std::string& session) {
  const bool cancelled = trouble.kind == calibration::Trouble::Kind::kCancelled;
  throw Error(
      cancelled ? ErrorCode::kCancelled : ErrorCode::kBadData, trouble.message,
      {{"session", session}});
}

}  // namespace

void check_methods(const std::vector<std::string>& methods) {
  for (const std::string& id : methods) static_cast<void>(choice_of(id));
}

Json compare(
    const session::Session& session, const CompareRequest& request,
    const ProgressCallback& progress, std::stop_token stop) {
  const std::vector<MethodChoice> choices = choices_of(request);
  calibration::ComparisonSettings settings = settings_of(request);
  const auto first_g1 = calibration::position_observations(session::trials_of(session, "G1"));
  settings.identify.noise_mm = rig_noise_mm(first_g1).value_or(settings.identify.noise_mm);

  if (progress) progress({.stage = "check", .done = 0, .total = 100});
  const bool set_aside = !request.keep_gross_errors;
  const CheckedSession checked = check_gross_errors(session, settings.identify, set_aside);
  const auto g1_trials = session::trials_of(checked.session, "G1");
  const auto positions = [&](std::span<const simulation::Trial> trials) {
    return calibration::position_space(
        calibration::position_observations(trials), session.rig.robot.nominal,
        settings.identify.noise_mm);
  };
  const auto g1 = positions(g1_trials);
  const auto g2 = positions(session::trials_of(checked.session, "G2"));
  if (auto trouble = calibration::trouble_with(g1)) refuse(*trouble, session.name);
  calibration::ObservationSpace space =
      space_of(request.space, g1_trials, checked.session, settings.identify.noise_mm);
  settings.identify.fixed = fixed_parameters(space, request.fix, request.free);

  const auto began = std::chrono::steady_clock::now();
  const auto tell = [&](const calibration::ComparisonProgress& now) {
    if (!progress) return;
    constexpr double kTooEarly = 0.02;
    Progress told{.stage = now.stage, .done = std::llround(100.0 * now.fraction), .total = 100};
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
    if (now.fraction > kTooEarly) {
      told.eta_s = spent.count() * (1.0 - now.fraction) / now.fraction;
    }
    if (now.best_mm > 0.0) told.best_mm = now.best_mm;
    progress(std::move(told));
  };
  const auto found = calibration::compare_methods(space, g1, g2, choices, settings, tell, stop);
  if (!found) refuse(found.error(), session.name);

  // What the data can tell is judged at the least-squares answer, whether asked for or not.
  const calibration::Identified reference =
      calibration::identify(*calibration::find_identifier("lm"), space, settings.identify);
  Json methods = Json::array();
  for (const ComparedMethod& method : found->methods) {
    methods.push_back(method_json(method, *found, space));
  }
  Json best = best_of(methods);
  return {
      {"schema", "sixdial.comparison"},
      {"schema_version", kComparisonSchemaVersion},
      {"created_utc", session::now_utc_text()},
      {"inputs", inputs_json(session, request, settings, space)},
      {"before_is",
       found->before_uses_targets ? "measured minus target" : "measured minus nominal model"},
      {"methods", std::move(methods)},
      {"best", std::move(best)},
      {"least_squares_rmse_mm", reference.rmse},
      {"assessment", assessment_json(
                         space, reference.fit, g1_trials,
                         session::trials_of(checked.session, ""), session.rig)},
      {"precision", precision_json(g1_trials, checked.session, settings.identify)},
      {"gross_errors", gross_errors_json(checked, session, set_aside)},
      {"seconds", found->seconds}};
}

std::string comparison_text(const Json& document) {
  std::string text = fmt::format(
      "{:<24}{:^27}  {:^27}\n{:<24}{:>9}{:>9}{:>9}  {:>9}{:>9}{:>9}{:>10}\n",
      "position error, mm", "G1 calibration", "G2 validation", "method", "mean", "std", "max",
      "mean", "std", "max", "time, s");
  for (const Json& method : document.at("methods")) {
    text += fmt::format("{:<24}", method["id"].get<std::string>());
    for (const char* set : {"g1", "g2"}) {
      for (const char* key : {"mean_mm", "std_mm", "max_mm"}) {
        text += method[set].is_object() ? fmt::format("{:9.4f}", method[set][key].get<double>())
                                        : fmt::format("{:>9}", "-");
      }
      if (std::string_view(set) == "g1") text += "  ";
    }
    text += fmt::format("{:10.4f}", method["seconds"].get<double>());
    if (document["best"] == method["id"]) text += "  best on G2";
    text += '\n';
  }
  return text;
}

}  // namespace sixdial::studies
