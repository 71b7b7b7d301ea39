#include "diagnosis/gain.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "calibration/random.h"
#include "calibration/residual_model.h"
#include "diagnosis/stages.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t kDrawStream = 72;

/// d(readings)/d(shift of the tool) and d/d(angle of the cuboid), count x 2 and count x 1.
struct ToolColumns {
  Eigen::MatrixXd shift;
  Eigen::VectorXd turn;  // empty in a session of positions
};

ToolColumns tool_columns(const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  ToolColumns result{stage_columns(readings, fit, simulated, Stage::kTool), {}};
  if (readings.has_dials()) {
    result.turn = stage_columns(readings, fit, simulated, Stage::kCuboidAngle).col(0);
  }
  return result;
}

std::vector<simulation::ActiveEffect> less(
    const std::vector<simulation::ActiveEffect>& effects, std::size_t i) {
  std::vector<simulation::ActiveEffect> result = effects;
  result.erase(result.begin() + static_cast<std::ptrdiff_t>(i));
  return result;
}

/// A fitted model's answer to other readings of the same session.
JointFit applied(const Readings& readings, const JointFit& fitted) {
  JointFit result = fitted;
  const simulation::ExtendedModel extended(readings.model(), fitted.effects);
  result.residual_mm = readings.measured_mm() - readings.simulate(fitted.model, extended);
  result.noise = readings.relative_noise();
  result.random.resize(readings.count(), 0);
  result.u.resize(0);
  return result;
}

double log_density(double e, double s_mm, double gross_share) {
  constexpr double kGrossRange_mm = 1.0;
  const double z = e / s_mm;
  return std::log(
      (1 - gross_share) * std::exp(-0.5 * z * z) / (s_mm * std::sqrt(2 * std::numbers::pi)) +
      gross_share / kGrossRange_mm);
}

}  // namespace

Eigen::Matrix2Xd tool_shift(
    const Readings& readings, const JointFit& fit, const Eigen::VectorXd& residual_mm,
    const Eigen::VectorXd& weight) {
  const ToolColumns columns = tool_columns(readings, fit);
  const std::size_t trials = readings.trials().size();
  Eigen::Matrix2Xd shift =
      Eigen::Matrix2Xd::Constant(2, static_cast<Eigen::Index>(trials), kNan);
  for (std::size_t t = 0; t < trials; ++t) {
    const Eigen::Index first = readings.first_row(t);
    const Eigen::Index rows = readings.first_row(t + 1) - first;
    if (rows < 2 || !residual_mm.segment(first, rows).allFinite()) continue;
    const Eigen::VectorXd root =
        weight.segment(first, rows)
            .cwiseSqrt()
            .cwiseQuotient(readings.relative_noise().segment(first, rows));
    const bool turns = columns.turn.size() > 0 && rows >= 3;
    Eigen::MatrixXd A(rows, turns ? 3 : 2);
    A.leftCols(2) = columns.shift.middleRows(first, rows);
    // A turn in units that move a face by about as much as a shift does.
    constexpr double kLever_mm = 40.0;
    if (turns) A.col(2) = columns.turn.segment(first, rows) / kLever_mm;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * A);
    qr.setThreshold(1e-3);
    if (qr.rank() < A.cols()) {
      qr.compute(root.asDiagonal() * A.leftCols(2));
      if (qr.rank() < 2) continue;
    }
    shift.col(static_cast<Eigen::Index>(t)) =
        qr.solve(root.cwiseProduct(residual_mm.segment(first, rows))).head<2>();
  }
  return shift;
}

GainStudy study_gain(
    const Readings& all, const Readings& g1, const Readings& g2, const Readings& raw_g1,
    const Readings& raw_g2, const JointFit& baseline, const JointFit& extended,
    const GainSettings& settings, const std::stop_token& stop) {
  GainStudy study;
  study.calibrated = fit_jointly(g1, baseline.model, {}, &baseline);
  study.extended = extended.effects.empty() ? study.calibrated
                                            : fit_jointly(g1, extended.model, extended.effects);
  for (std::size_t i = 0; i < extended.effects.size(); ++i) {
    // Afresh: beside the causes that stay, readings that only this one explains look gross.
    JointFit from_here =
        fit_jointly(g1, study.extended.model, less(extended.effects, i), &study.extended);
    JointFit afresh = fit_jointly(g1, baseline.model, less(study.extended.effects, i));
    study.without.push_back(
        afresh.log_likelihood > from_here.log_likelihood ? std::move(afresh)
                                                         : std::move(from_here));
  }

  // Samples with a gross reading say nothing about the robot. Which readings are gross the
  // extended model tells, and each model is judged on the same ones.
  const Eigen::Index n = g2.count();
  const JointFit seen = applied(g2, study.extended);
  const double gross_mm = 5.0 * std::max(study.extended.s_mm, settings.noise_mm);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(n);
  {
    // By what the whole session's fit called gross.
    Eigen::Index at = 0;
    for (Eigen::Index row = 0; row < all.count() && at < n; ++row) {
      const Row& each = all.rows()[static_cast<std::size_t>(row)];
      const Row& here = g2.rows()[static_cast<std::size_t>(at)];
      if (each.trial != here.trial || each.dial != here.dial) continue;
      const double size_mm = std::abs(extended.residual_mm[row]) / extended.noise[row];
      if (extended.weight[row] < 0.5 && size_mm > gross_mm) {
        weight[at] = 0.0;
      }
      ++at;
    }
  }
  std::vector<std::size_t> poses;
  for (std::size_t t = 0; t < g2.trials().size(); ++t) {
    const Eigen::Index first = g2.first_row(t);
    const Eigen::Index rows = g2.first_row(t + 1) - first;
    if (rows == 0) continue;
    if (weight.segment(first, rows).minCoeff() > 0) {
      poses.push_back(t);
    } else {
      ++study.excluded;
    }
  }
  if (poses.empty()) return study;

  const auto likelihood = [&](const JointFit& fit) {
    const JointFit here = applied(g2, fit);
    double sum = 0.0;
    for (Eigen::Index row = 0; row < n; ++row) {
      if (weight[row] > 0 && std::isfinite(here.residual_mm[row])) {
        sum += log_density(
            here.residual_mm[row], study.extended.s_mm * here.noise[row],
            study.extended.gross_share);
      }
    }
    return sum;
  };
  const double with_all = likelihood(study.extended);
  for (const JointFit& each : study.without) {
    study.g2_log_odds.push_back(with_all - likelihood(each));
  }

  struct Sides {
    const Readings* g1;
    const Readings* g2;
    const Eigen::VectorXd* weight;
  };
  struct Judged {
    GainModel model;
    bool network;
    std::optional<Hypothesis> without;
    const Sides* sides;
    Eigen::VectorXd error_mm;  // by pose
    Eigen::VectorXd residual_mm;
  };
  std::vector<Judged> judged;
  const auto judge = [&](GainModel model, const std::optional<Hypothesis>& without,
                         const JointFit& fit, bool network, const Sides& sides) {
    const Readings& learn = *sides.g1;
    const Readings& test = *sides.g2;
    const JointFit here = applied(test, fit);
    Eigen::VectorXd residual = here.residual_mm;
    const Eigen::Matrix2Xd shift = tool_shift(test, here, residual, *sides.weight);
    std::optional<calibration::TrainedResidual> learned;
    if (network) {
      const Eigen::Matrix2Xd train = tool_shift(learn, fit, fit.residual_mm, fit.weight);
      std::vector<std::size_t> usable;
      for (std::size_t t = 0; t < learn.trials().size(); ++t) {
        const Eigen::Index rows = learn.first_row(t + 1) - learn.first_row(t);
        if (rows == 0 || !train.col(static_cast<Eigen::Index>(t)).allFinite()) continue;
        if (fit.weight.segment(learn.first_row(t), rows).minCoeff() > 0.5) usable.push_back(t);
      }
      constexpr std::size_t kFewest = 12;
      if (usable.size() < kFewest) return;
      Eigen::MatrixX2d q(static_cast<Eigen::Index>(usable.size()), 2);
      Eigen::MatrixX2d target(q.rows(), 2);
      for (std::size_t i = 0; i < usable.size(); ++i) {
        q.row(static_cast<Eigen::Index>(i)) = learn.trials()[usable[i]].q.transpose();
        target.row(static_cast<Eigen::Index>(i)) =
            train.col(static_cast<Eigen::Index>(usable[i])).transpose();
      }
      calibration::ResidualSettings how;
      how.seed = settings.seed;
      learned = calibration::train_residual(
          *calibration::find_residual_model("anfis"), q, target, how, stop);
    }
    Judged result{model,
                  network,
                  without,
                  &sides,
                  Eigen::VectorXd(static_cast<Eigen::Index>(poses.size())),
                  residual};
    const ToolColumns columns = tool_columns(test, here);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const std::size_t t = poses[i];
      Eigen::Vector2d error = shift.col(static_cast<Eigen::Index>(t));
      if (learned) {
        const Eigen::Vector2d said = learned->correction(test.trials()[t].q);
        error -= said;
        const Eigen::Index first = test.first_row(t);
        const Eigen::Index rows = test.first_row(t + 1) - first;
        result.residual_mm.segment(first, rows) -= columns.shift.middleRows(first, rows) * said;
      }
      result.error_mm[static_cast<Eigen::Index>(i)] = error.norm();
    }
    judged.push_back(std::move(result));
  };

  // What was measured, before exchanged dials were set right.
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(raw_g2.count());
  const bool exchanged = &raw_g1 != &g1;
  const Sides as_measured{&raw_g1, &raw_g2, exchanged ? &ones : &weight};
  const Sides set_right{&g1, &g2, &weight};
  const JointFit raw_calibrated =
      exchanged ? fit_jointly(raw_g1, g1.model().nominal(), {}) : study.calibrated;
  JointFit nominal = raw_calibrated;
  nominal.model = g1.model().nominal();
  judge(GainModel::kNominal, {}, nominal, false, as_measured);
  judge(GainModel::kCalibrated, {}, raw_calibrated, false, as_measured);
  if (settings.networks) judge(GainModel::kCalibrated, {}, raw_calibrated, true, as_measured);
  if (!extended.effects.empty() || exchanged) {
    judge(GainModel::kExtended, {}, study.extended, false, set_right);
    if (settings.networks) judge(GainModel::kExtended, {}, study.extended, true, set_right);
    for (std::size_t i = 0; i < study.without.size(); ++i) {
      const auto& effect = extended.effects[i];
      judge(
          GainModel::kWithout, Hypothesis{effect.effect, effect.place}, study.without[i], false,
          set_right);
    }
  }

  const auto mean_square = [&](const Judged& each) {
    const Readings& test = *each.sides->g2;
    double sum = 0.0;
    Eigen::Index count = 0;
    for (const std::size_t t : poses) {
      for (Eigen::Index row = test.first_row(t); row < test.first_row(t + 1); ++row, ++count) {
        sum += each.residual_mm[row] * each.residual_mm[row];
      }
    }
    return sum / static_cast<double>(std::max<Eigen::Index>(1, count));
  };
  const Judged& reference = judged[1];
  const double reference_square = mean_square(reference);
  const std::size_t places = g2.has_dials() ? g2.model().rig().dials.size() : 2;
  for (const Judged& each : judged) {
    const Readings& test = *each.sides->g2;
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
    row.rms_mm = std::sqrt(mean_square(each));
    for (std::size_t place = 0; place < places; ++place) {
      double sum = 0.0;
      int present = 0;
      for (const std::size_t t : poses) {
        for (Eigen::Index at = test.first_row(t); at < test.first_row(t + 1); ++at) {
          if (test.rows()[static_cast<std::size_t>(at)].dial != static_cast<int>(place))
            continue;
          sum += each.residual_mm[at] * each.residual_mm[at];
          ++present;
        }
      }
      row.rms_by_dial_mm.push_back(present > 0 ? std::sqrt(sum / present) : kNan);
    }
    const double explainable = reference_square - settings.noise_mm * settings.noise_mm;
    // Where next to nothing is above the noise, a share of it means nothing.
    constexpr double kWorthSharing = 0.05;
    const bool shares = each.model != GainModel::kNominal &&
                        explainable > kWorthSharing * settings.noise_mm * settings.noise_mm;
    row.removed_share = shares ? (reference_square - mean_square(each)) / explainable : kNan;
    // Poses are drawn, the same for both models.
    if (!usable.empty() && settings.draws > 0) {
      std::vector<double> drawn(static_cast<std::size_t>(settings.draws));
      for (std::size_t d = 0; d < drawn.size(); ++d) {
        double sum = 0.0;
        for (std::size_t k = 0; k < usable.size(); ++k) {
          const auto words = calibration::random_words(
              settings.seed, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(d), 0,
              kDrawStream);
          const auto pick = static_cast<std::size_t>(
              calibration::open_unit(words[0]) * static_cast<double>(usable.size()));
          const Eigen::Index i = usable[std::min(pick, usable.size() - 1)];
          sum += each.error_mm[i] - reference.error_mm[i];
        }
        drawn[d] = sum / count;
      }
      std::sort(drawn.begin(), drawn.end());
      const auto quantile = [&](double share) {
        return drawn[static_cast<std::size_t>(share * static_cast<double>(drawn.size() - 1))];
      };
      row.low_mm = quantile(0.025);
      row.high_mm = quantile(0.975);
    }
    study.rows.push_back(std::move(row));
  }
  return study;
}

}  // namespace sixdial::diagnosis
