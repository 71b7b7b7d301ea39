#include "calibration/pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "calibration/workers.h"

namespace sixdial::calibration {
namespace {

using geometry::ParameterVector;

constexpr int kLeastSamples = 3;
// Shares of the whole, for the progress bar.
constexpr double kAfterFilter = 0.01;
constexpr double kAfterNoiseSearch = 0.45;
constexpr double kAfterParameterSearch = 0.6;
constexpr double kAfterReference = 0.62;

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double> passed = now - last_;
    last_ = now;
    return passed.count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

std::vector<double> norms(const Eigen::Matrix2Xd& errors) {
  std::vector<double> result;
  for (Eigen::Index i = 0; i < errors.cols(); ++i) result.push_back(errors.col(i).norm());
  return result;
}

Trouble cancelled() { return {Trouble::Kind::kCancelled, "the calibration was cancelled"}; }

}  // namespace

Eigen::Matrix2Xd errors_before(
    const PositionObservations& observations, const ParameterVector& nominal, bool targets) {
  if (!targets) return position_residuals(observations, nominal);
  Eigen::Matrix2Xd errors(2, observations.size());
  for (int i = 0; i < observations.size(); ++i) {
    errors.col(i) =
        observations.p_WE.col(i) - *observations.target_mm[static_cast<std::size_t>(i)];
  }
  return errors;
}

bool all_have_targets(const PositionObservations& observations) {
  return std::ranges::all_of(
      observations.target_mm, [](const auto& target) { return target.has_value(); });
}

MethodErrors method_errors(
    std::string method, const Eigen::Matrix2Xd& g1, const Eigen::Matrix2Xd& g2) {
  MethodErrors result{std::move(method), norms(g1), norms(g2), {}, {}};
  result.g1 = error_stats(result.g1_mm);
  result.g2 = error_stats(result.g2_mm);
  return result;
}

std::optional<Trouble> trouble_with(
    const PositionObservations& g1, const ParameterVector& nominal) {
  if (g1.size() < kLeastSamples) {
    return Trouble{
        Trouble::Kind::kTooFewSamples,
        "G1 has " + std::to_string(g1.size()) + " samples with a position; at least " +
            std::to_string(kLeastSamples) +
            " are needed (measure more points, or check that three dials touch)"};
  }
  const Eigen::Matrix2Xd errors = position_residuals(g1, nominal);
  for (int i = 0; i < g1.size(); ++i) {
    if (errors.col(i).allFinite()) continue;
    const auto k = static_cast<std::size_t>(i);
    return Trouble{
        Trouble::Kind::kUnreachable, "G1 point " + std::to_string(g1.point[k]) + " repeat " +
                                         std::to_string(g1.repeat[k]) +
                                         ": its joint angles cannot be reached with the "
                                         "nominal parameters; check the angles "
                                         "and the nominal robot, or leave the sample out"};
  }
  return std::nullopt;
}

std::string_view to_string(Profile profile) {
  return profile == Profile::kPaper ? "paper" : "default";
}

std::optional<Profile> profile_from(std::string_view text) {
  if (text == "default") return Profile::kDefault;
  if (text == "paper") return Profile::kPaper;
  return std::nullopt;
}

std::string_view to_string(Stage stage) {
  switch (stage) {
    case Stage::kFilter:
      return "ekf";
    case Stage::kNoiseSearch:
      return "qpso1";
    case Stage::kParameterSearch:
      return "qpso2";
    case Stage::kReference:
      return "lm";
    case Stage::kResidual:
      return "anfis";
    case Stage::kReport:
      return "report";
  }
  return "unknown";
}

Settings settings_for(Profile profile) {
  Settings settings;
  settings.profile = profile;
  if (profile == Profile::kPaper) {
    settings.linearisation = Linearisation::kNominal;
    settings.coordinates = SearchCoordinates::kRaw;
    settings.cross_validate = false;
  }
  return settings;
}

ErrorStats error_stats(std::span<const double> errors_mm) {
  ErrorStats stats;
  double sum = 0.0;
  double squares = 0.0;
  for (const double e : errors_mm) {
    if (!std::isfinite(e)) {
      ++stats.unreachable;
      continue;
    }
    ++stats.count;
    sum += e;
    squares += e * e;
    stats.max_mm = std::max(stats.max_mm, e);
  }
  if (stats.count == 0) return stats;
  stats.mean_mm = sum / stats.count;
  stats.rmse_mm = std::sqrt(squares / stats.count);
  double deviations = 0.0;
  for (const double e : errors_mm) {
    if (std::isfinite(e)) deviations += (e - stats.mean_mm) * (e - stats.mean_mm);
  }
  if (stats.count > 1) stats.std_mm = std::sqrt(deviations / (stats.count - 1));
  return stats;
}

const StageResult& Result::stage(std::string_view name) const {
  for (const StageResult& each : stages) {
    if (each.name == name) return each;
  }
  throw std::out_of_range("calibration::Result: no stage '" + std::string(name) + "'");
}

const MethodErrors& Result::errors(std::string_view method) const {
  for (const MethodErrors& each : table_6) {
    if (each.method == method) return each;
  }
  throw std::out_of_range("calibration::Result: no method '" + std::string(method) + "'");
}

Eigen::Vector2d anfis_correction(
    const AnfisModel& x, const AnfisModel& y, const Eigen::Vector2d& q_rad) {
  return {x.predict(q_rad), y.predict(q_rad)};
}

tl::expected<Result, Trouble> run_dqpso_anfis(
    const PositionObservations& g1, const PositionObservations& g2,
    const ParameterVector& nominal, const Settings& settings, const ProgressCallback& progress,
    std::stop_token stop) {
  if (auto trouble = trouble_with(g1, nominal)) return tl::unexpected(*std::move(trouble));
  const auto repeats = noise_from_repeats(g1);
  const double noise_mm =
      repeats && repeats->sigma_mm > 0.0 ? repeats->sigma_mm : settings.noise_mm;
  Stopwatch whole;
  Stopwatch watch;
  Result result;
  result.settings = settings;
  result.nominal = nominal;
  const auto tell = [&](Stage stage, double fraction, const QpsoProgress& search, double rmse) {
    if (progress) {
      progress({stage, fraction, search.iteration, search.iterations, rmse});
    }
  };
  const auto searching = [&](Stage stage, double from, double to) {
    return [&tell, stage, from, to](const QpsoProgress& search) {
      const double part = static_cast<double>(search.iteration) / search.iterations;
      tell(stage, from + (to - from) * part, search, search.best);
    };
  };

  tell(Stage::kFilter, 0.0, {}, 0.0);
  ParameterVector p0 = settings.p0;
  FilterNoise first_noise = settings.first_noise;
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    if (settings.fixed[static_cast<std::size_t>(i)]) p0[i] = first_noise.q[i] = 0.0;
  }
  const FilterRun filter =
      filter_positions(g1, nominal, {settings.linearisation, p0, first_noise});
  result.stages.push_back({"ekf", filter.v, position_rmse(g1, filter.v), watch.lap()});

  NoiseSearchSettings noise;
  noise.swarm = settings.qpso1;
  noise.linearisation = settings.linearisation;
  noise.p0 = p0;
  noise.fixed = settings.fixed;
  noise.seed = settings.seed;
  noise.threads = settings.threads;
  const NoiseSearch tuned = search_noise(
      g1, nominal, noise, searching(Stage::kNoiseSearch, kAfterFilter, kAfterNoiseSearch),
      stop);
  if (tuned.search.cancelled) return tl::unexpected(cancelled());
  result.stages.push_back({"ekf_qpso1", tuned.run.v, tuned.rmse_mm, watch.lap()});
  result.noise = tuned.noise;
  result.qpso1_history_mm = tuned.search.history;
  result.filter_history = tuned.run.history;
  result.not_finite = tuned.search.not_finite;

  ParameterSearchSettings search;
  search.swarm = settings.qpso2;
  search.coordinates = settings.coordinates;
  search.fixed = settings.fixed;
  search.noise_mm = noise_mm;
  search.seed = settings.seed;
  search.threads = settings.threads;
  const ParameterSearch found = search_parameters(
      g1, nominal, tuned.run.v, search,
      searching(Stage::kParameterSearch, kAfterNoiseSearch, kAfterParameterSearch), stop);
  if (found.search.cancelled) return tl::unexpected(cancelled());
  result.stages.push_back({"ekf_dqpso", found.v, found.rmse_mm, watch.lap()});
  result.v = found.v;
  result.qpso2_history_mm = found.search.history;
  for (const ParameterVector& v : found.history) result.qpso2_history.push_back(v - nominal);
  result.not_finite += found.search.not_finite;

  tell(Stage::kReference, kAfterParameterSearch, {}, found.rmse_mm);
  PositionFitSettings reference;
  reference.fixed = settings.fixed;
  reference.noise_mm = noise_mm;
  const PositionFit lm = fit_positions(g1, nominal, reference);
  result.stages.push_back({"lm", lm.v, lm.rmse_mm, watch.lap()});
  result.lm_status = lm.fit.status;
  result.lm_iterations = lm.fit.iterations;
  result.above_minimum_mm = found.rmse_mm - lm.rmse_mm;

  tell(Stage::kResidual, kAfterReference, {}, found.rmse_mm);
  const Eigen::MatrixXd inputs = g1.q_rad.transpose();
  const Eigen::Matrix2Xd residual = position_residuals(g1, found.v);
  const AnfisLearning learning{
      settings.anfis, settings.cross_validate, settings.holdout_fraction, settings.seed};
  Workers workers(std::min(settings.threads, 2));
  watch.lap();
  workers.run(2, [&](int axis) {
    (axis == 0 ? result.anfis_x : result.anfis_y) =
        learn_anfis(inputs, residual.row(axis).transpose(), learning, stop);
  });
  if (stop.stop_requested()) return tl::unexpected(cancelled());
  result.anfis_seconds = watch.lap();

  tell(Stage::kReport, 1.0, {}, found.rmse_mm);
  const PositionFit assessed = assess_positions(g1, nominal, found.v, reference);
  result.covariance = assessed.covariance;
  result.sigma_mm = assessed.sigma_mm;
  result.degrees_of_freedom = assessed.fit.degrees_of_freedom();
  const auto names = parameter_names();
  result.parameters = parameter_estimates(assessed.fit, nominal, assessed.covariance, names);
  result.identifiability = identifiability(assessed.fit, names, g1.size());

  result.before_uses_targets = all_have_targets(g1) && all_have_targets(g2);
  result.table_6.push_back(method_errors(
      "before", errors_before(g1, nominal, result.before_uses_targets),
      errors_before(g2, nominal, result.before_uses_targets)));
  for (const StageResult& stage : result.stages) {
    result.table_6.push_back(method_errors(
        stage.name, position_residuals(g1, stage.v), position_residuals(g2, stage.v)));
  }
  const auto compensated = [&](const PositionObservations& set) {
    Eigen::Matrix2Xd errors = position_residuals(set, found.v);
    for (int i = 0; i < set.size(); ++i) {
      errors.col(i) -=
          anfis_correction(result.anfis_x.model, result.anfis_y.model, set.q_rad.col(i));
    }
    return errors;
  };
  result.table_6.push_back(method_errors("ekf_dqpso+anfis", compensated(g1), compensated(g2)));
  result.g1_sample = g1.sample;
  result.g2_sample = g2.sample;
  result.total_seconds = whole.lap();
  return result;
}

}  // namespace sixdial::calibration
