#include "diagnosis/gain.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "calibration/crew.h"
#include "calibration/pose_groups.h"
#include "calibration/random.h"
#include "diagnosis/judging.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t kDrawStream = 72;

std::vector<simulation::ActiveEffect> less(
    const std::vector<simulation::ActiveEffect>& effects, std::size_t i) {
  std::vector<simulation::ActiveEffect> result = effects;
  result.erase(result.begin() + static_cast<std::ptrdiff_t>(i));
  return result;
}

double log_density(double e, double s_mm, double gross_share) {
  const double z = e / s_mm;
  return std::log(
      (1 - gross_share) * std::exp(-0.5 * z * z) / (s_mm * std::sqrt(2 * std::numbers::pi)) +
      gross_share / kGrossRange_mm);
}

/// The fits on G1: robot, robot and all causes, and less each cause in turn.
GainStudy fits_on_g1(const GainQuestion& question) {
  const Readings& g1 = question.explained.fitted;
  const JointFit& extended = question.extended;
  GainStudy study;
  study.calibrated = fit_jointly(g1, question.baseline.model, {}, &question.baseline);
  study.extended = extended_on(g1, extended, question.curves, study.calibrated);
  study.without.resize(extended.effects.size());
  calibration::in_parallel(static_cast<int>(study.without.size()), [&](int k) {
    const auto i = static_cast<std::size_t>(k);
    // Also from the start: beside the causes that stay, readings that only this one explains
    // look gross, and a fit that starts there leaves them out.
    JointFit from_here =
        fit_jointly(g1, study.extended.model, less(study.extended.effects, i), &study.extended);
    JointFit afresh = fit_jointly(g1, question.baseline.model, less(study.extended.effects, i));
    study.without[i] = afresh.log_likelihood > from_here.log_likelihood ? std::move(afresh)
                                                                        : std::move(from_here);
  });
  return study;
}

/// Shifts that the readings of an arrival share, found in these readings: fills shift_mm. What
/// they cost the log likelihood.
double shared_shifts(JointFit& here, const Eigen::VectorXd& counted) {
  if (!here.shared) return 0.0;
  double cost = 0.0;
  here.weight = counted;
  constexpr int kPasses = 3;  // a gross reading pulls the shift until it is known as one
  for (int pass = 0; pass < kPasses; ++pass) {
    const Whitening whitening = here.whitening();
    Whitening::Shifts shifts = whitening.shifts_of(here.residual_mm);
    cost = 0.5 * shifts.squares / (here.s_mm * here.s_mm) + 0.5 * whitening.log_volume();
    here.shift_mm = std::move(shifts.in_readings_mm);
    const Eigen::VectorXd own_mm = here.own_residual_mm();
    for (Eigen::Index row = 0; row < own_mm.size(); ++row) {
      const double s_mm = here.s_mm * here.noise[row];
      const double all = log_density(own_mm[row], s_mm, here.gross_share);
      const double gross = std::log(here.gross_share / kGrossRange_mm);
      here.weight[row] = counted[row] * -std::expm1(std::min(0.0, gross - all));
    }
  }
  return cost;
}

/// Log odds of each cause: G2 with it against without.
std::vector<double> odds_on_g2(
    const Readings& g2, const Eigen::VectorXd& weight, const GainStudy& study) {
  const auto likelihood = [&](const JointFit& fit) {
    JointFit here = applied(g2, fit);
    const Eigen::VectorXd counted =
        here.residual_mm.unaryExpr([](double e) { return std::isfinite(e) ? 1.0 : 0.0; })
            .cwiseProduct(weight);
    here.residual_mm =
        here.residual_mm.unaryExpr([](double e) { return std::isfinite(e) ? e : 0.0; });
    // Independent readings are judged by the noise of the whole explanation. Where one side has
    // shared shifts, these are its way to explain G2, and each side is judged by its own noise.
    if (!study.extended.shared && !fit.shared) {
      here.s_mm = study.extended.s_mm;
      here.gross_share = study.extended.gross_share;
    }
    double sum = -shared_shifts(here, counted);
    const Eigen::VectorXd own_mm = here.own_residual_mm();
    for (Eigen::Index row = 0; row < g2.count(); ++row) {
      if (counted[row] == 0) continue;
      sum += log_density(own_mm[row], here.s_mm * here.noise[row], here.gross_share);
    }
    return sum;
  };
  const double with_all = likelihood(study.extended);
  std::vector<double> result;
  for (const JointFit& each : study.without) result.push_back(with_all - likelihood(each));
  return result;
}

/// All models; the calibrated one, which the others are compared with, is number kReference.
constexpr std::size_t kReference = 1;
std::vector<Judged> judged_models(
    const GainQuestion& question, const GainStudy& study, const std::vector<std::size_t>& poses,
    const Eigen::VectorXd& weight, const GainSettings& settings, const std::stop_token& stop) {
  const bool exchanged = question.as_measured.has_value();
  const FittedAndJudged& measured = exchanged ? *question.as_measured : question.explained;
  // Which readings are gross is known of the dials set right only.
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(measured.judged.count());
  const Side as_measured{measured, exchanged ? ones : weight};
  const Side set_right{question.explained, weight};
  const auto nominal_model = measured.fitted.nominal();
  const JointFit calibrated =
      exchanged ? fit_jointly(measured.fitted, nominal_model, {}) : study.calibrated;
  JointFit nominal = calibrated;
  nominal.model = nominal_model;

  std::vector<Judged> result;
  const auto add = [&](GainModel model, const Side& side, const JointFit& fit,
                       const std::optional<Hypothesis>& without = {}) {
    result.push_back(judged_on(side, poses, fit, nullptr));
    result.back().model = model;
    result.back().without = without;
  };
  const auto add_with_network = [&](GainModel model, const Side& side, const JointFit& fit) {
    if (!settings.networks) return;
    const auto network = trained_on(side.readings.fitted, fit, settings.seed, stop);
    if (!network) return;
    result.push_back(judged_on(side, poses, fit, &*network));
    result.back().model = model;
  };
  add(GainModel::kNominal, as_measured, nominal);
  add(GainModel::kCalibrated, as_measured, calibrated);
  add_with_network(GainModel::kCalibrated, as_measured, calibrated);
  const bool nothing = question.extended.effects.empty() && question.curves.empty();
  if (nothing && !exchanged) return result;
  add(GainModel::kExtended, set_right, study.extended);
  add_with_network(GainModel::kExtended, set_right, study.extended);
  for (std::size_t i = 0; i < study.without.size(); ++i) {
    const auto& effect = question.extended.effects[i];
    add(GainModel::kWithout, set_right, study.without[i],
        Hypothesis{effect.effect, effect.place});
  }
  return result;
}

double mean_square(const Judged& judged, const std::vector<std::size_t>& poses) {
  const Readings& test = *judged.readings;
  double sum = 0.0;
  Eigen::Index count = 0;
  for (const std::size_t t : poses) {
    for (Eigen::Index row = test.first_row(t); row < test.first_row(t + 1); ++row, ++count) {
      sum += judged.residual_mm[row] * judged.residual_mm[row];
    }
  }
  return sum / static_cast<double>(std::max<Eigen::Index>(1, count));
}

std::vector<double> rms_by_dial(const Judged& judged, const std::vector<std::size_t>& poses) {
  const Readings& test = *judged.readings;
  std::vector<double> result;
  for (std::size_t place = 0; place < test.channel_count(); ++place) {
    double sum = 0.0;
    int present = 0;
    for (const std::size_t t : poses) {
      for (Eigen::Index at = test.first_row(t); at < test.first_row(t + 1); ++at) {
        if (test.rows()[static_cast<std::size_t>(at)].dial != static_cast<int>(place)) continue;
        sum += judged.residual_mm[at] * judged.residual_mm[at];
        ++present;
      }
    }
    result.push_back(present > 0 ? std::sqrt(sum / present) : kNan);
  }
  return result;
}

/// Of one pose: how many samples of it were judged, and the sum of their differences.
struct PoseDifference {
  double sum_mm = 0.0;
  double samples = 0.0;
};

/// Of the usable samples, pose by pose.
std::vector<PoseDifference> by_pose(
    const Judged& each, const Judged& reference, const std::vector<std::size_t>& samples,
    const std::vector<Eigen::Index>& usable) {
  if (usable.empty()) return {};
  const auto& trials = each.readings->trials();
  Eigen::MatrixXd q(std::ssize(usable), trials.front().q.size());
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    const Eigen::Index i = usable[static_cast<std::size_t>(row)];
    q.row(row) = trials[samples[static_cast<std::size_t>(i)]].q.transpose();
  }
  std::vector<PoseDifference> poses;
  for (const std::vector<int>& rows : calibration::rows_by_group(calibration::pose_groups(q))) {
    PoseDifference& pose = poses.emplace_back();
    for (const int row : rows) {
      const Eigen::Index i = usable[static_cast<std::size_t>(row)];
      pose.sum_mm += each.error_mm[i] - reference.error_mm[i];
      pose.samples += 1.0;
    }
  }
  return poses;
}

/// 95 % interval of the mean difference: poses are drawn with all their repeats, the same for
/// both models. Repeats share their pose's error, so that drawing them one by one would make
/// the interval too short.
void add_interval(
    GainRow& row, const std::vector<PoseDifference>& poses, const GainSettings& settings) {
  if (poses.empty() || settings.draws <= 0) return;
  std::vector<double> drawn(static_cast<std::size_t>(settings.draws));
  for (std::size_t d = 0; d < drawn.size(); ++d) {
    PoseDifference all;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const auto words = calibration::random_words(
          settings.seed, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(d), 0,
          kDrawStream);
      const auto pick = static_cast<std::size_t>(
          calibration::open_unit(words[0]) * static_cast<double>(poses.size()));
      const PoseDifference& pose = poses[std::min(pick, poses.size() - 1)];
      all.sum_mm += pose.sum_mm;
      all.samples += pose.samples;
    }
    drawn[d] = all.sum_mm / all.samples;
  }
  std::sort(drawn.begin(), drawn.end());
  const auto quantile = [&](double share) {
    return drawn[static_cast<std::size_t>(share * static_cast<double>(drawn.size() - 1))];
  };
  row.low_mm = quantile(0.025);
  row.high_mm = quantile(0.975);
}

GainRow row_of(
    const Judged& each, const Judged& reference, const std::vector<std::size_t>& poses,
    const GainSettings& settings) {
  GainRow row;
  row.model = each.model;
  row.network = each.network;
  row.without = each.without;
  std::vector<Eigen::Index> usable;
  for (Eigen::Index i = 0; i < each.error_mm.size(); ++i) {
    if (std::isfinite(each.error_mm[i]) && std::isfinite(reference.error_mm[i])) {
      usable.push_back(i);
    }
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, usable.size()));
  for (const Eigen::Index i : usable) {
    row.mean_mm += each.error_mm[i] / count;
    row.max_mm = std::max(row.max_mm, each.error_mm[i]);
    row.difference_mm += (each.error_mm[i] - reference.error_mm[i]) / count;
  }
  for (const Eigen::Index i : usable) {
    row.std_mm += std::pow(each.error_mm[i] - row.mean_mm, 2) / std::max(1.0, count - 1);
  }
  row.std_mm = std::sqrt(row.std_mm);
  const double square = mean_square(each, poses);
  const double noise_square = settings.noise_mm * settings.noise_mm;
  row.rms_mm = std::sqrt(square);
  row.rms_by_dial_mm = rms_by_dial(each, poses);
  // Where next to nothing is above the noise, a share of it means nothing.
  constexpr double kWorthSharing = 0.05;
  const double reference_square = mean_square(reference, poses);
  const double explainable = reference_square - noise_square;
  const bool shares =
      each.model != GainModel::kNominal && explainable > kWorthSharing * noise_square;
  row.removed_share = shares ? (reference_square - square) / explainable : kNan;
  add_interval(row, by_pose(each, reference, poses, usable), settings);
  return row;
}

}  // namespace

GainStudy study_gain(
    const GainQuestion& question, const GainSettings& settings, const std::stop_token& stop) {
  GainStudy study = fits_on_g1(question);
  const Readings& g2 = question.explained.judged;
  const double s_mm = std::max(study.extended.s_mm, settings.noise_mm);
  const Eigen::VectorXd weight = weights_to_judge(question.all, question.extended, g2, s_mm);
  const std::vector<std::size_t> poses = poses_to_judge(g2, weight, study.excluded);
  if (poses.empty()) return study;
  study.g2_log_odds = odds_on_g2(g2, weight, study);
  if (!settings.table) return study;
  const std::vector<Judged> judged =
      judged_models(question, study, poses, weight, settings, stop);
  for (const Judged& each : judged) {
    study.rows.push_back(row_of(each, judged[kReference], poses, settings));
  }
  return study;
}

}  // namespace sixdial::diagnosis
