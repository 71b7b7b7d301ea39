#include "diagnosis/diagnosis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "calibration/five_bar/spaces.h"
#include "diagnosis/baseline.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kLn10 = 2.302585092994046;

/// From repeats without their gross readings, where there are enough, else from the rig file;
/// of all dials, or of one.
Noise noise_of(
    const Readings& readings, const JointFit& fit, std::optional<std::size_t> only = {}) {
  std::vector<simulation::Trial> trials = readings.trials();
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    const bool other = only && each.dial != static_cast<int>(*only);
    if (fit.weight[row] > 0.5 && !other) continue;
    auto& trial = trials[static_cast<std::size_t>(each.trial)];
    if (readings.has_dials()) {
      trial.reading[static_cast<std::size_t>(each.dial)].reset();
    } else {
      trial.position_mm.reset();
    }
  }
  constexpr int kEnough = 10;
  const auto repeats = calibration::repeat_noise(trials, readings.has_dials());
  if (repeats && repeats->degrees_of_freedom >= kEnough && repeats->sigma_mm > 0) {
    return {NoiseSource::kRepeats, repeats->sigma_mm, repeats->degrees_of_freedom};
  }
  return {
      NoiseSource::kRigFile, only ? readings.rig_noise_of(*only) : readings.rig_noise_mm(), 0};
}

/// More scatter than the noise explains. A rig file's figure is a maker's word, not a
/// measurement: it must be missed by more.
bool scatters(const Noise& noise, double s_mm, double freedom) {
  constexpr double kLevel = 1e-3;
  constexpr double kMakersWord = 1.3;
  if (!(noise.sigma_mm > 0) || freedom < 1) return false;
  const double ratio = s_mm * s_mm / (noise.sigma_mm * noise.sigma_mm);
  if (noise.degrees_of_freedom > 0) {
    const boost::math::fisher_f law(freedom, noise.degrees_of_freedom);
    return ratio > boost::math::quantile(boost::math::complement(law, kLevel));
  }
  const boost::math::chi_squared law(freedom);
  return std::sqrt(ratio) > kMakersWord &&
         ratio * freedom > boost::math::quantile(boost::math::complement(law, kLevel));
}

/// Scatter of what is left: dials that stand out by themselves, the others together.
void add_scatter(
    Remainder& result, const Noise& noise, const Readings& readings, const JointFit& fit,
    bool smooth) {
  const std::size_t dials = readings.has_dials() ? readings.model().rig().dials.size() : 1;
  std::vector<double> squares(dials, 0.0);
  std::vector<double> freedom(dials, 0.0);
  std::vector<double> relative(dials, 1.0);
  const double share = 1 - fit.fitted / std::max(1.0 + fit.fitted, fit.weight.sum());
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const int dial = readings.rows()[static_cast<std::size_t>(row)].dial;
    const auto d = static_cast<std::size_t>(readings.has_dials() ? dial : 0);
    squares[d] += fit.weight[row] * fit.residual_mm[row] * fit.residual_mm[row];
    freedom[d] += share * fit.weight[row];
    relative[d] = fit.noise[row];
  }
  double in_noise = 0.0;
  double others = 0.0;
  for (std::size_t d = 0; d < dials; ++d) {
    constexpr double kStandsOut = 1.3;
    if (freedom[d] <= 0) continue;
    const double sigma_mm = std::sqrt(squares[d] / freedom[d]);
    if (relative[d] > kStandsOut) {
      const Noise own = noise_of(readings, fit, d);
      if (scatters(own, sigma_mm, freedom[d])) {
        result.noisy_dials.push_back(
            {readings.model().rig().dials[d].id, sigma_mm, own.sigma_mm});
      }
      continue;
    }
    in_noise += squares[d];
    others += freedom[d];
  }
  const double s_mm = std::sqrt(in_noise / std::max(1.0, others));
  result.scatter = (!smooth && scatters(noise, s_mm, others)) || !result.noisy_dials.empty();
}

std::vector<Estimate> estimates_of(const JointFit& fit, std::size_t cause) {
  std::vector<Estimate> result;
  Eigen::Index column = fit.model.size();
  for (std::size_t k = 0; k < cause; ++k) column += fitted_count(*fit.effects[k].effect);
  const ActiveEffect& active = fit.effects[cause];
  for (std::size_t i = 0; i < active.x.size(); ++i) {
    const auto parameter =
        simulation::parameter_at(*active.effect, active.place, static_cast<int>(i));
    const bool fitted = static_cast<int>(i) < fitted_count(*active.effect);
    // Either the place lacks it (a step in a joint has no y) or no reading moves with it.
    if (!parameter || (fitted && fit.J.col(column).squaredNorm() <= 0)) {
      if (fitted) ++column;
      continue;
    }
    result.push_back(
        {std::string(parameter->name), std::string(parameter->unit), active.x[i],
         fitted ? std::sqrt(std::max(0.0, fit.covariance(column, column))) : kNan});
    if (fitted) ++column;
  }
  return result;
}

/// RMS of what a fitted effect does that nothing else can take over, over the noise.
double visible_ratio(const Readings& readings, const JointFit& fit, std::size_t cause) {
  Eigen::Index column = fit.model.size();
  for (std::size_t k = 0; k < cause; ++k) column += fitted_count(*fit.effects[k].effect);
  const ActiveEffect& active = fit.effects[cause];
  const int own = fitted_count(*active.effect);
  Eigen::MatrixXd others(fit.J.rows(), fit.J.cols() - own);
  others << fit.J.leftCols(column), fit.J.rightCols(fit.J.cols() - column - own);
  const Eigen::VectorXd root = fit.root();
  Eigen::VectorXd does = Eigen::VectorXd::Zero(fit.J.rows());
  for (int i = 0; i < linear_count(*active.effect); ++i) {
    does += fit.J.col(column + i) * active.x[static_cast<std::size_t>(i)];
  }
  does = root.cwiseProduct(does);
  const Eigen::MatrixXd Q = orthonormal_basis(root.asDiagonal() * others);
  does -= Q * (Q.transpose() * does);
  return does.norm() / std::sqrt(static_cast<double>(readings.count())) /
         std::max(1e-12, fit.s_mm);
}

/// One name for a finding and all it is tied with.
bool shares_a_name(const Finding& a, const Finding& b) {
  const auto names = [](const Finding& each) {
    std::vector<Hypothesis> all{each.hypothesis};
    for (const Rival& rival : each.tied_with) all.push_back(rival.hypothesis);
    return all;
  };
  for (const Hypothesis& x : names(a)) {
    for (const Hypothesis& y : names(b)) {
      if (x == y) return true;
    }
  }
  return false;
}

void add_dependence(
    Diagnosis& result, const Readings& readings, const JointFit& before,
    const JointFit& after) {
  const auto left = score_unknown(readings, after);
  for (const UnknownCandidate& first : score_unknown(readings, before)) {
    Dependence each{first.covariates, first.enters, first.evidence, 0.0, first.rms_mm, 0.0};
    for (const UnknownCandidate& second : left) {
      if (second.covariates == first.covariates && second.enters == first.enters) {
        each.log_odds_after = second.evidence;
        each.rms_after_mm = second.rms_mm;
      }
    }
    result.dependence.push_back(std::move(each));
  }
}

void add_parameters(Diagnosis& result, const Readings& readings) {
  const simulation::ModelVector nominal = readings.model().nominal();
  const JointFit& baseline = result.identified.baseline;
  const JointFit& extended = result.identified.extended;
  const auto sd = [](const JointFit& fit, Eigen::Index i) {
    return std::sqrt(std::max(0.0, fit.covariance(i, i)));
  };
  const simulation::ForwardModel& model = readings.model();
  for (Eigen::Index i = 0; i < model.parameter_count(); ++i) {
    if (i >= model.robot_parameter_count() && !readings.has_dials()) continue;
    const auto& info = model.parameters()[static_cast<std::size_t>(i)];
    result.parameters.push_back(
        {info.name, info.unit, nominal[i], baseline.model[i], sd(baseline, i),
         extended.model[i], sd(extended, i)});
  }
}

}  // namespace

Diagnosis diagnose(
    const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
    std::vector<bool> held_out, const DiagnosisSettings& settings,
    const std::function<void(const DiagnosisProgress&)>& progress,
    const std::stop_token& stop) {
  constexpr int kStages = 5;
  const auto stage = [&](const char* name, int done) {
    if (progress) progress({name, done, kStages});
    return stop.stop_requested();
  };
  Diagnosis result;
  result.seed = settings.seed;
  held_out.resize(trials.size(), false);
  if (std::none_of(held_out.begin(), held_out.end(), [](bool out) { return out; })) {
    result.held_out_by_program = true;
    for (std::size_t t = 2; t < trials.size(); t += 3) held_out[t] = true;
  }
  std::vector<bool> fitted(held_out.size());
  for (std::size_t t = 0; t < fitted.size(); ++t) {
    fitted[t] = !held_out[t];
    ++(fitted[t] ? result.g1_samples : result.g2_samples);
  }

  const Readings measured(model, std::move(trials));
  const Eigen::Index fewest = model.parameter_count() + 10;
  if (measured.count() < fewest) {
    throw std::invalid_argument(
        "a diagnosis needs at least " + std::to_string(fewest) +
        " readings; this session has " + std::to_string(measured.count()));
  }
  if (stage("naming causes", 0)) return result;
  Readings readings = measured;
  result.identified = identify(readings, settings.search);
  const Identification& found = result.identified;
  const JointFit& extended = found.extended;

  result.readings = found.swap ? measured.with_swapped_dials(
                                     found.swap->place.dial, found.swap->place.other_dial)
                               : measured;
  result.readings->place_tool(extended.model);

  if (stage("confirming on G1 alone", 1)) return result;
  Readings g1 = readings.counting(fitted);
  Readings g2 = readings.counting(held_out);
  const bool enough_g1 = g1.count() >= fewest;
  std::optional<Identification> alone;
  if (enough_g1 && (!found.findings.empty() || found.swap)) {
    Readings on_g1 = g1;
    alone = identify(on_g1, settings.search);
  }

  result.noise = noise_of(readings, extended);
  if (stage("what is left", 2)) return result;
  add_dependence(result, readings, found.baseline, extended);
  add_parameters(result, readings);
  result.not_testable = found.not_testable;

  // The smooth part counts as left over.
  const JointFit names = found.unknown.empty()
                             ? extended
                             : fit_jointly(readings, extended.model, extended.effects);
  const double good = names.weight.sum();
  result.unexplained.rms_mm =
      std::sqrt(names.weight.dot(names.residual_mm.cwiseAbs2()) / std::max(1.0, good));
  result.unexplained.depends_on = found.depends_on();
  add_scatter(result.unexplained, result.noise, readings, extended, !found.unknown.empty());
  result.unexplained.significant = !found.unknown.empty() || result.unexplained.scatter;

  if (stage("gain on G2", 3)) return result;
  GainStudy study;
  if (enough_g1 && settings.with_gain) {
    const Readings raw_g1 = measured.counting(fitted);
    const Readings raw_g2 = measured.counting(held_out);
    GainSettings how;
    how.draws = settings.gain_draws;
    how.seed = settings.seed;
    how.noise_mm = result.noise.sigma_mm;
    study =
        found.swap
            ? study_gain(readings, g1, g2, raw_g1, raw_g2, found.baseline, extended, how, stop)
            : study_gain(readings, g1, g2, g1, g2, found.baseline, extended, how, stop);
    result.gain = study.rows;
  }
  const auto mean_of = [&](GainModel which, const std::optional<Hypothesis>& without = {}) {
    for (const GainRow& row : result.gain) {
      if (row.model == which && !row.network && row.without == without) return row.mean_mm;
    }
    return kNan;
  };

  if (found.swap) {
    Cause cause;
    cause.finding = {*found.swap, at_rest(*found.swap), 0.0, {}, false};
    const JointFit as_it_was = fit_baseline(measured);
    cause.finding.evidence = found.baseline.log_likelihood - as_it_was.log_likelihood;
    cause.delta_bic = 2 * cause.finding.evidence;
    cause.visible_ratio =
        std::sqrt(as_it_was.residual_mm.squaredNorm() / static_cast<double>(measured.count())) /
        std::max(1e-12, result.noise.sigma_mm);
    cause.on_g1 = alone.has_value();
    if (enough_g1) {
      const Readings raw_g2 = measured.counting(held_out);
      const double crossed = fit_jointly(raw_g2, found.baseline.model, {}).log_likelihood;
      const double straight = fit_jointly(g2, found.baseline.model, {}).log_likelihood;
      cause.g2_log_odds = straight - crossed;
    }
    cause.confirmed = cause.on_g1 && cause.g2_log_odds > kLn10;
    cause.gain_mm = mean_of(GainModel::kCalibrated) - mean_of(GainModel::kExtended);
    result.causes.push_back(std::move(cause));
  }
  for (std::size_t i = 0; i < found.findings.size(); ++i) {
    Cause cause;
    cause.finding = found.findings[i];
    cause.estimate = estimates_of(extended, i);
    cause.delta_bic = 2 * cause.finding.evidence;
    cause.visible_ratio = visible_ratio(readings, extended, i);
    if (alone) {
      for (const Finding& each : alone->findings) {
        cause.on_g1 = cause.on_g1 || shares_a_name(each, cause.finding);
      }
    }
    if (i < study.g2_log_odds.size()) cause.g2_log_odds = study.g2_log_odds[i];
    cause.confirmed = cause.on_g1 && cause.g2_log_odds > kLn10;
    cause.gain_mm =
        mean_of(GainModel::kWithout, cause.finding.hypothesis) - mean_of(GainModel::kExtended);
    result.causes.push_back(std::move(cause));
  }
  std::stable_sort(
      result.causes.begin(), result.causes.end(), [](const Cause& a, const Cause& b) {
        const bool swap_a = a.finding.hypothesis.effect->exchanges_dials;
        const bool swap_b = b.finding.hypothesis.effect->exchanges_dials;
        if (swap_a != swap_b) return swap_a;
        return a.finding.evidence > b.finding.evidence;
      });

  if (stage("limits", 4)) return result;
  std::vector<NotTestable> ignored;
  const std::vector<Hypothesis> testable = hypotheses_for(readings, ignored);
  if (settings.with_limits) {
    std::vector<Hypothesis> open;
    for (const Hypothesis& each : testable) {
      const bool named = std::any_of(
          result.causes.begin(), result.causes.end(),
          [&](const Cause& cause) { return cause.finding.hypothesis == each; });
      if (!named) open.push_back(each);
    }
    result.limits = limits_of(readings, names, open, settings.search);
    for (const Limit& limit : result.limits) {
      constexpr double kAbsorbed = 0.01;
      constexpr double kBelievable = 5.0;
      if (limit.surviving > kAbsorbed && limit.detect < kBelievable * limit.plausible) continue;
      if (limit.detect < kBelievable * limit.plausible) continue;
      result.not_testable.push_back({limit.hypothesis, WhyNotTestable::kAbsorbed});
    }
  }
  result.false_alarm_probability = found.family_p_value;
  if (settings.null_draws > 0) {
    result.false_alarm_probability = simulated_false_alarm(
        readings, found.baseline, testable, found.family_p_value, settings.null_draws,
        settings.seed);
  }
  if (progress) progress({"done", kStages, kStages});
  return result;
}

}  // namespace sixdial::diagnosis
