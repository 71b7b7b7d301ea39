#include "diagnosis/search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "diagnosis/evidence.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;
using simulation::Circumstance;
using simulation::Effect;

/// P(chi-squared with k degrees > x), k = 1, 2, 3.
double chi2_tail(double x, int k) {
  if (x <= 0) return 1.0;
  const double normal = std::erfc(std::sqrt(x / 2));
  if (k <= 1) return normal;
  if (k == 2) return std::exp(-x / 2);
  return normal + std::sqrt(2 * x / 3.14159265358979323846) * std::exp(-x / 2);
}

/// Rise of the log likelihood by adding columns to a weighted least squares residual.
double gain_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& e, double sse, double n) {
  if (columns.cols() == 0) return 0.0;
  double explained = 0.0;
  if (columns.cols() == 1) {
    const double norm2 = columns.col(0).squaredNorm();
    if (norm2 <= 0) return 0.0;
    const double dot = columns.col(0).dot(e);
    explained = dot * dot / norm2;
  } else {
    const Eigen::VectorXd right = columns.transpose() * e;
    const Eigen::MatrixXd normal = columns.transpose() * columns;
    explained = right.dot(normal.completeOrthogonalDecomposition().solve(right));
  }
  explained = std::min(explained, sse * (1 - 1e-12));
  return -0.5 * n * std::log1p(-explained / sse);
}

}  // namespace

std::string Hypothesis::name() const { return std::string(effect->cause) + "@" + place.name; }

std::vector<Hypothesis> hypotheses_for(
    const Readings& readings, std::vector<NotTestable>& not_testable) {
  const auto& samples = readings.circumstances();
  const auto varies = [&](auto&& value) {
    std::set<double> seen;
    for (const Circumstance& sample : samples) seen.insert(value(sample));
    return seen.size() > 1;
  };
  bool time = false, temperature = false;
  for (const auto& trial : readings.trials()) {
    time = time || trial.time_s.has_value();
    temperature = temperature || trial.temperature_c.has_value();
  }
  const bool temperature_varies =
      temperature && varies([](const Circumstance& s) { return s.temperature_degC; });
  std::vector<Hypothesis> result;
  for (const Effect* effect : simulation::all_effects()) {
    for (const simulation::Place& place : effect->places(readings.model().rig())) {
      const Hypothesis each{effect, place};
      std::string reason;
      std::string needs;
      if ((effect->needs & simulation::kDials || place.dial >= 0) && !readings.has_dials()) {
        reason = "needs raw dial readings; this session has positions only";
        needs = "dial columns";
      } else if (effect->needs & simulation::kTemperature && !temperature_varies) {
        reason = temperature ? "the temperature did not change"
                             : "the session has no temperature_c column";
        needs = temperature ? "a session whose temperature changes" : "temperature_c";
      } else if (effect->needs & simulation::kTime && !time) {
        reason = "the session has no time_utc column";
        needs = "time_utc";
      } else if (effect->needs & simulation::kApproach && place.joint >= 0) {
        const int joint = place.joint;
        std::map<double, int> counts;
        for (const Circumstance& sample : samples) ++counts[sample.approach[joint]];
        if (counts[1.0] < 3 || counts[-1.0] < 3) {
          const bool none = counts[1.0] + counts[-1.0] == 0;
          reason = none ? "the session has no approach column for this joint"
                        : "the joint always arrived from the same side";
          needs = none ? "approach1, approach2" : "points approached from both sides";
        }
      }
      if (reason.empty()) {
        result.push_back(each);
      } else {
        not_testable.push_back({each, reason, needs});
      }
    }
  }
  return result;
}

std::vector<Candidate> score_all(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd root = fit.weight.cwiseSqrt();
  const Eigen::MatrixXd Q = orthonormal_basis(root.asDiagonal() * fit.J);
  const auto projected = [&](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
    const Eigen::MatrixXd weighted = root.asDiagonal() * columns;
    return weighted - Q * (Q.transpose() * weighted);
  };
  const Eigen::VectorXd weighted_e = root.cwiseProduct(fit.residual_mm);
  const Eigen::VectorXd e = weighted_e - Q * (Q.transpose() * weighted_e);
  const double sse = e.squaredNorm();
  const double n = std::max(3.0, fit.weight.sum() - fit.fitted);

  // Every sample's scene once: effects that only change a reading start from here.
  std::vector<simulation::Scene> scenes(readings.trials().size());
  Eigen::VectorXd simulated = readings.measured_mm() - fit.residual_mm;
  for (std::size_t t = 0; t < scenes.size(); ++t) {
    if (!extended.run(
            fit.model, readings.trials()[t], readings.circumstances()[t], scenes[t])) {
      scenes[t].reading_mm.clear();
    }
  }
  const auto columns_of = [&](const ActiveEffect& candidate) -> Eigen::MatrixXd {
    const Effect& effect = *candidate.effect;
    const bool only_reading =
        !effect.before_kinematics && !effect.after_kinematics && !effect.before_contact;
    if (!only_reading) {
      return effect_columns(readings, fit.model, extended, candidate, simulated);
    }
    const int count = linear_count(effect);
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(readings.count(), count);
    Eigen::VectorXd values = simulated;
    simulation::Scene scene;
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      ActiveEffect moved = candidate;
      const double step = 1e-3 * effect.parameters[k].sigma;
      moved.x[k] += step;
      for (std::size_t t = 0; t < scenes.size(); ++t) {
        if (scenes[t].reading_mm.empty()) continue;
        scene.reading_mm = scenes[t].reading_mm;
        effect.after_reading(moved.x, moved.place, readings.circumstances()[t], scene);
        readings.pick(scene, t, values);
      }
      columns.col(i) = (values - simulated) / step;
    }
    return columns;
  };

  const auto evidence_of = [&](const Eigen::MatrixXd& columns) {
    const MarginalLikelihood found =
        marginal_likelihood(columns.transpose() * columns, columns.transpose() * e, sse, n);
    return found.by_scale.empty() ? 0.0 : log_mean_exp(found.by_scale);
  };
  std::vector<Candidate> result;
  for (const Hypothesis& hypothesis : hypotheses) {
    const Effect& effect = *hypothesis.effect;
    if (effect.parameters.empty()) continue;  // swaps are tried on the data itself
    Candidate candidate;
    candidate.hypothesis = hypothesis;
    ActiveEffect active{
        &effect, hypothesis.place, std::vector<double>(effect.parameters.size(), 0.0)};
    const auto without_empty = [](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
      Eigen::MatrixXd kept(columns.rows(), 0);
      for (Eigen::Index i = 0; i < columns.cols(); ++i) {
        if (columns.col(i).squaredNorm() <= 0) continue;
        kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
        kept.rightCols(1) = columns.col(i);
      }
      return kept;
    };
    int k = 0;
    if (!effect.searched) {
      const Eigen::MatrixXd raw = without_empty(columns_of(active));
      candidate.columns = projected(raw);
      k = static_cast<int>(raw.cols());
      const double before = (root.asDiagonal() * raw).norm();
      candidate.surviving = before > 0 ? candidate.columns.norm() / before : 0.0;
      candidate.gain = candidate.surviving > 1e-7 ? gain_of(candidate.columns, e, sse, n) : 0.0;
      candidate.evidence = evidence_of(candidate.columns);
      candidate.p_value = chi2_tail(2 * candidate.gain, k);
    } else {
      const auto values =
          effect.searched(readings.model().rig(), readings.circumstances(), hypothesis.place);
      if (values.empty()) continue;
      const bool by_order = effect.cause == "step";
      Eigen::MatrixXd from_start;
      if (by_order) {
        active.x.back() = -1.0;
        from_start = without_empty(columns_of(active));
      }
      double best = -1.0;
      std::vector<double> evidences;
      for (const double value : values) {
        Eigen::MatrixXd raw;
        if (by_order) {
          raw = from_start;
          raw.topRows(readings.first_row(static_cast<std::size_t>(value))).setZero();
        } else {
          active.x.back() = value;
          raw = without_empty(columns_of(active));
        }
        Eigen::MatrixXd columns = projected(raw);
        const double gain = gain_of(columns, e, sse, n);
        evidences.push_back(evidence_of(columns));
        k = static_cast<int>(raw.cols());
        if (gain > best) {
          best = gain;
          candidate.searched = value;
          candidate.gain = gain;
          candidate.columns = std::move(columns);
        }
      }
      // The search is averaged over.
      candidate.evidence = log_mean_exp(evidences);
      const double tries = by_order ? 12.0 : 0.7 * static_cast<double>(evidences.size());
      const double p = chi2_tail(2 * best, k);
      candidate.p_value = -std::expm1(tries * std::log1p(-std::min(p, 1 - 1e-12)));
    }
    if (candidate.columns.cols() > 0) {
      const Eigen::BDCSVD<Eigen::MatrixXd> svd(candidate.columns);
      candidate.size_per_unit = svd.singularValues()[0];
    }
    candidate.plausible = effect.parameters[0].sigma;
    result.push_back(std::move(candidate));
  }
  std::stable_sort(result.begin(), result.end(), [](const Candidate& a, const Candidate& b) {
    if (a.evidence != b.evidence) return a.evidence > b.evidence;
    return a.hypothesis.name() < b.hypothesis.name();
  });
  return result;
}

double family_p_value(const std::vector<Candidate>& candidates) {
  double smallest = 1.0;
  for (const Candidate& each : candidates) smallest = std::min(smallest, each.p_value);
  return -std::expm1(
      static_cast<double>(candidates.size()) * std::log1p(-std::min(smallest, 1 - 1e-12)));
}

}  // namespace sixdial::diagnosis
