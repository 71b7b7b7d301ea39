#include "calibration/pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "calibration/workers.h"

namespace sixdial::calibration {
namespace {

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

std::vector<double> norms(const Eigen::MatrixXd& errors) {
  std::vector<double> result;
  for (Eigen::Index i = 0; i < errors.cols(); ++i) result.push_back(errors.col(i).norm());
  return result;
}

Trouble cancelled() { return {Trouble::Kind::kCancelled, "the calibration was cancelled"}; }

/// One calibration in the order of its stages; each puts what it found into the result.
class Run {
 public:
  Run(const ObservationSpace& g1, const ObservationSpace& g2, const PipelineSettings& settings,
      const PipelineProgressCallback& progress, std::stop_token stop);

  void filter();
  /// The searches and the networks: false if cancelled.
  [[nodiscard]] bool search_noise();
  [[nodiscard]] bool search_parameters();
  void fit_reference();
  [[nodiscard]] bool learn_residual();
  /// What the data say about the parameters.
  void assess();
  /// Table 6.
  void judge();
  [[nodiscard]] Result take();

 private:
  void tell(
      PipelineStage stage, double fraction, const QpsoProgress& search, double rmse_mm) const {
    if (progress_) {
      progress_({stage, fraction, search.iteration, search.iterations, rmse_mm});
    }
  }
  [[nodiscard]] SearchProgress searching(PipelineStage stage, double from, double to) const {
    return [this, stage, from, to](const QpsoProgress& search) {
      const double part = static_cast<double>(search.iteration) / search.iterations;
      tell(stage, from + (to - from) * part, search, search.best);
    };
  }
  void add_stage(std::string name, const Eigen::VectorXd& v, double rmse_mm) {
    result_.stages.push_back({std::move(name), v, rmse_mm, watch_.lap()});
  }
  [[nodiscard]] SpaceFitSettings reference_settings() const {
    SpaceFitSettings reference;
    reference.fixed = result_.settings.fixed;
    reference.noise_mm = noise_mm_;
    return reference;
  }

  const ObservationSpace& g1_;
  const ObservationSpace& g2_;
  const PipelineProgressCallback& progress_;
  std::stop_token stop_;
  double noise_mm_;  // of one measured axis
  Stopwatch whole_, watch_;
  Result result_;
};

/// Settings with every list at its full length.
PipelineSettings completed(const ObservationSpace& space, PipelineSettings settings) {
  const int n = space.parameters();
  settings.fixed.resize(static_cast<std::size_t>(n), 0);
  settings.p0 = diagonal_of(settings.p0, n, 1.0);
  settings.first_noise.q = diagonal_of(settings.first_noise.q, n, kFirstVariance);
  settings.first_noise.r =
      diagonal_of(settings.first_noise.r, space.channels(), kFirstVariance);
  return settings;
}

Run::Run(
    const ObservationSpace& g1, const ObservationSpace& g2, const PipelineSettings& settings,
    const PipelineProgressCallback& progress, std::stop_token stop)
    : g1_(g1),
      g2_(g2),
      progress_(progress),
      stop_(std::move(stop)),
      noise_mm_(settings.noise_mm) {
  const auto repeats = repeat_noise(g1);
  if (repeats && repeats->sigma_mm > 0.0) noise_mm_ = repeats->sigma_mm;
  result_.settings = completed(g1, settings);
  result_.nominal = g1.nominal;
}

void Run::filter() {
  tell(PipelineStage::kFilter, 0.0, {}, 0.0);
  const PipelineSettings& settings = result_.settings;
  FilterSettings filter;
  filter.linearisation = settings.linearisation;
  filter.p0 = diagonal_of(settings.p0, g1_.parameters(), 1.0, settings.fixed);
  filter.noise = settings.first_noise;
  filter.noise.q =
      diagonal_of(filter.noise.q, g1_.parameters(), kFirstVariance, settings.fixed);
  const FilterRun run = run_filter(g1_, filter);
  add_stage("ekf", run.v, position_rmse(g1_, run.v));
}

bool Run::search_noise() {
  const PipelineSettings& settings = result_.settings;
  NoiseSearchSettings noise;
  noise.swarm = settings.qpso1;
  noise.linearisation = settings.linearisation;
  noise.p0 = settings.p0;
  noise.fixed = settings.fixed;
  noise.seed = settings.seed;
  noise.threads = settings.threads;
  const NoiseSearch tuned = calibration::search_noise(
      g1_, noise, searching(PipelineStage::kNoiseSearch, kAfterFilter, kAfterNoiseSearch),
      stop_);
  if (tuned.search.cancelled) return false;
  add_stage("ekf_qpso1", tuned.run.v, tuned.rmse_mm);
  result_.noise = tuned.noise;
  result_.qpso1_history_mm = tuned.search.history;
  result_.filter_history = tuned.run.history;
  result_.not_finite = tuned.search.not_finite;
  return true;
}

bool Run::search_parameters() {
  const PipelineSettings& settings = result_.settings;
  ParameterSearchSettings search;
  search.swarm = settings.qpso2;
  search.coordinates = settings.coordinates;
  search.fixed = settings.fixed;
  search.noise_mm = noise_mm_;
  search.seed = settings.seed;
  search.threads = settings.threads;
  const ParameterSearch found = calibration::search_parameters(
      g1_, result_.stage("ekf_qpso1").v, search,
      searching(PipelineStage::kParameterSearch, kAfterNoiseSearch, kAfterParameterSearch),
      stop_);
  if (found.search.cancelled) return false;
  add_stage("ekf_dqpso", found.v, found.rmse_mm);
  result_.v = found.v;
  result_.qpso2_history_mm = found.search.history;
  for (const Eigen::VectorXd& v : found.history) {
    result_.qpso2_history.push_back(v - g1_.nominal);
  }
  result_.not_finite += found.search.not_finite;
  return true;
}

void Run::fit_reference() {
  const double found_mm = result_.stage("ekf_dqpso").rmse_g1_mm;
  tell(PipelineStage::kReference, kAfterParameterSearch, {}, found_mm);
  const SpaceFit lm = fit_space(g1_, reference_settings());
  add_stage("lm", lm.v, lm.rmse_mm);
  result_.lm_status = lm.fit.status;
  result_.lm_iterations = lm.fit.iterations;
  result_.above_minimum_mm = found_mm - lm.rmse_mm;
}

bool Run::learn_residual() {
  const PipelineSettings& settings = result_.settings;
  tell(PipelineStage::kResidual, kAfterReference, {}, result_.stage("ekf_dqpso").rmse_g1_mm);
  const Eigen::MatrixXd residual = position_errors(g1_, result_.v);
  const Eigen::MatrixXd inputs = g1_.joints.leftCols(residual.cols()).transpose();
  const AnfisLearning learning{
      settings.anfis, settings.cross_validate, settings.holdout_fraction, settings.seed};
  result_.networks.resize(static_cast<std::size_t>(g1_.position_axes));
  Workers workers(std::min(settings.threads, g1_.position_axes));
  watch_.lap();
  workers.run(g1_.position_axes, [&](int axis) {
    result_.networks[static_cast<std::size_t>(axis)] =
        learn_anfis(inputs, residual.row(axis).transpose(), learning, stop_);
  });
  if (stop_.stop_requested()) return false;
  result_.anfis_seconds = watch_.lap();
  return true;
}

void Run::assess() {
  tell(PipelineStage::kReport, 1.0, {}, result_.stage("ekf_dqpso").rmse_g1_mm);
  const SpaceFit assessed = assess_space(g1_, result_.v, reference_settings());
  result_.covariance = assessed.covariance;
  result_.sigma_mm = assessed.sigma_mm;
  result_.degrees_of_freedom = assessed.fit.degrees_of_freedom();
  const auto names = g1_.parameter_names();
  result_.parameters =
      parameter_estimates(assessed.fit, g1_.nominal, assessed.covariance, names);
  result_.identifiability =
      identifiability(assessed.fit, names, g1_.samples(), g1_.named_directions);
}

void Run::judge() {
  result_.before_uses_targets = all_have_targets(g1_) && all_have_targets(g2_);
  result_.table_6.push_back(method_errors(
      "before", errors_before(g1_, result_.before_uses_targets),
      errors_before(g2_, result_.before_uses_targets)));
  for (const StageResult& stage : result_.stages) {
    result_.table_6.push_back(method_errors(
        stage.name, position_errors(g1_, stage.v), position_errors(g2_, stage.v)));
  }
  std::vector<AnfisModel> networks;
  for (const AnfisReport& each : result_.networks) networks.push_back(each.model);
  const auto compensated = [&](const ObservationSpace& set) {
    Eigen::MatrixXd errors = position_errors(set, result_.v);
    for (Eigen::Index i = 0; i < errors.cols(); ++i) {
      errors.col(i) -= anfis_correction(networks, set.joints.col(i));
    }
    return errors;
  };
  result_.table_6.push_back(
      method_errors("ekf_dqpso+anfis", compensated(g1_), compensated(g2_)));
  result_.g1_sample = g1_.sample;
  result_.g2_sample = g2_.sample;
}

Result Run::take() {
  result_.total_seconds = whole_.lap();
  return std::move(result_);
}

}  // namespace

Eigen::MatrixXd errors_before(const ObservationSpace& space, bool targets) {
  return targets ? space.off_target_mm : position_errors(space, space.nominal);
}

bool all_have_targets(const ObservationSpace& space) {
  return space.off_target_mm.cols() == space.samples() && space.off_target_mm.allFinite();
}

MethodErrors method_errors(
    std::string method, const Eigen::MatrixXd& g1, const Eigen::MatrixXd& g2) {
  MethodErrors result{std::move(method), norms(g1), norms(g2), {}, {}};
  result.g1 = error_stats(result.g1_mm);
  result.g2 = error_stats(result.g2_mm);
  return result;
}

std::optional<Trouble> trouble_with(const ObservationSpace& g1) {
  if (g1.samples() < kLeastSamples) {
    return Trouble{
        Trouble::Kind::kTooFewSamples,
        "G1 has " + std::to_string(g1.samples()) + " samples with a position; at least " +
            std::to_string(kLeastSamples) +
            " are needed (measure more points, or check that three dials touch)"};
  }
  const Eigen::MatrixXd errors = position_errors(g1, g1.nominal);
  for (Eigen::Index i = 0; i < errors.cols(); ++i) {
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

std::string_view to_string(PipelineStage stage) {
  switch (stage) {
    case PipelineStage::kFilter:
      return "ekf";
    case PipelineStage::kNoiseSearch:
      return "qpso1";
    case PipelineStage::kParameterSearch:
      return "qpso2";
    case PipelineStage::kReference:
      return "lm";
    case PipelineStage::kResidual:
      return "anfis";
    case PipelineStage::kReport:
      return "report";
  }
  return "unknown";
}

PipelineSettings settings_for(Profile profile) {
  PipelineSettings settings;
  settings.profile = profile;
  if (profile == Profile::kPaper) {
    settings.linearisation = Linearisation::kNominal;
    settings.coordinates = SearchCoordinates::kRaw;
    settings.cross_validate = false;
    settings.anfis.stop_at_target = true;
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

tl::expected<Result, Trouble> run_dqpso_anfis(
    const ObservationSpace& g1, const ObservationSpace& g2, const PipelineSettings& settings,
    const PipelineProgressCallback& progress, std::stop_token stop) {
  if (auto trouble = trouble_with(g1)) return tl::unexpected(*std::move(trouble));
  Run run(g1, g2, settings, progress, std::move(stop));
  run.filter();
  if (!run.search_noise()) return tl::unexpected(cancelled());
  if (!run.search_parameters()) return tl::unexpected(cancelled());
  run.fit_reference();
  if (!run.learn_residual()) return tl::unexpected(cancelled());
  run.assess();
  run.judge();
  return run.take();
}

}  // namespace sixdial::calibration
