// Scores of all hypotheses against one fit. With Q an orthonormal basis of the fitted columns
// and e the residual projected off it, a candidate's columns C enter only through
//   C'C - (Q'C)'(Q'C)   and   C'e,   all of it whitened (sample_scatter.h),
// so that an effect on one dial costs that dial's rows, and a step at every sample costs one
// pass from the last sample to the first.
#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>

#include "calibration/column_products.h"
#include "calibration/crew.h"
#include "calibration/random.h"
#include "diagnosis/evidence.h"
#include "diagnosis/search.h"
#include "diagnosis/significance.h"
#include "diagnosis/thresholds.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;
using simulation::Effect;

/// Whitened columns; or as they are, on some rows only, if `rows` is not null.
struct Columns {
  Eigen::MatrixXd values;
  const std::vector<Eigen::Index>* rows = nullptr;
};

/// What a candidate's columns amount to after projection.
struct Projected {
  Eigen::MatrixXd normal;
  double before = 0.0;  // squared norm without projection
};

constexpr std::size_t kLookEvery = 1024;  // samples, whether the work is to end

class Scorer {
 public:
  Scorer(const Readings& readings, const JointFit& fit)
      : readings_(readings),
        fit_(fit),
        extended_(readings.model(), fit.effects),
        projector_(fit),
        whitening_(projector_.whitening()),
        Q_(projector_.Q()),
        back_q_(whitening_.transposed(Q_)),
        simulated_(readings.simulate(fit.model, extended_)),
        dial_rows_(readings.has_dials() ? readings.model().rig().dials.size() : 0) {
    for (std::size_t d = 0; d < dial_rows_.size(); ++d) {
      dial_rows_[d] = readings.rows_of_dial(d);
    }
    for (const auto& rows : dial_rows_) {
      Eigen::MatrixXd part(static_cast<Eigen::Index>(rows.size()), Q_.cols());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        part.row(static_cast<Eigen::Index>(i)) = back_q_.row(rows[i]);
      }
      Q_of_dial_.push_back(std::move(part));
    }
  }

  /// A hypothesis' columns, one set for each searched value.
  struct Prepared {
    Hypothesis hypothesis;
    bool by_order = false;
    std::vector<double> values;  // searched; one 0 if nothing is
    std::vector<Columns> columns;
    std::vector<Projected> projected;  // without `right`
  };
  [[nodiscard]] Prepared prepare(const Hypothesis& hypothesis) const {
    const Effect& effect = *hypothesis.effect;
    Prepared result{hypothesis, effect.is_step, {0.0}, {}, {}};
    if (effect.searched) {
      result.values =
          effect.searched(readings_.model().rig(), readings_.circumstances(), hypothesis.place);
    }
    if (result.by_order) {
      result.columns.push_back(columns_of(at_rest(hypothesis, -1.0)));
      result.projected = steps(result.columns[0], result.values);
    } else {
      for (const double value : result.values) {
        geometry::check_end();
        result.columns.push_back(columns_of(at_rest(hypothesis, value)));
        result.projected.push_back(projected(result.columns.back()));
      }
    }
    return result;
  }

  /// A whitened residual that is projected already; and whitened a second time, for columns
  /// that are not.
  struct Left {
    Eigen::VectorXd e, back;
    double squares;
  };
  [[nodiscard]] Left left(Eigen::VectorXd e, double squares) const {
    Eigen::VectorXd back = whitening_.transposed(e);
    return {std::move(e), std::move(back), squares};
  }

  /// Without evidence: the p value only.
  [[nodiscard]] Candidate score(
      const Prepared& prepared, const Left& left, bool with_evidence = true) const {
    Candidate best;
    if (prepared.values.empty()) return best;
    std::vector<Eigen::VectorXd> step_rights;
    if (prepared.by_order) {
      step_rights = step_right(prepared.columns[0], left.e, prepared.values);
    }
    std::vector<double> evidences;
    double most = -1.0;
    for (std::size_t i = 0; i < prepared.values.size(); ++i) {
      geometry::check_end();
      const Projected& seen = prepared.projected[i];
      Candidate here;
      here.hypothesis = prepared.hypothesis;
      here.searched = prepared.values[i];
      take(
          here, seen, prepared.by_order ? step_rights[i] : right_of(prepared.columns[i], left),
          left.squares, with_evidence);
      evidences.push_back(here.evidence);
      if (here.gain > most) {
        most = here.gain;
        best = std::move(here);
      }
    }
    best.p_value = p_value_of_gain(best.gain, static_cast<int>(best.normal.cols()));
    if (prepared.values.size() > 1) {
      // The search is averaged over.
      best.evidence = log_mean_exp(evidences);
      best.p_value = p_value_of_best(
          best.p_value, independent_tries(*prepared.hypothesis.effect, evidences.size()));
    }
    return best;
  }

  [[nodiscard]] const Projector& projector() const { return projector_; }

 private:
  [[nodiscard]] Columns columns_of(const ActiveEffect& candidate) const {
    const Effect& effect = *candidate.effect;
    const bool only_reading =
        !effect.before_kinematics && !effect.after_kinematics && !effect.before_contact;
    Columns result;
    if (!only_reading) {
      result.values = effect_columns(readings_, fit_.model, extended_, candidate, simulated_);
    } else {
      const int count = linear_count(effect);
      if (candidate.place.dial >= 0 && candidate.place.other_dial < 0) {
        const auto dial = static_cast<std::size_t>(candidate.place.dial);
        result.rows = &dial_rows_[dial];
        result.values = readings_.reading_columns(candidate, count);
      } else {
        result.values = effect_columns(readings_, fit_.model, extended_, candidate, simulated_);
      }
    }
    // Parameters that do nothing here (the second one of a step in a joint).
    Eigen::Index kept = 0;
    for (Eigen::Index i = 0; i < result.values.cols(); ++i) {
      if (result.values.col(i).squaredNorm() <= 0) continue;
      if (kept != i) result.values.col(kept) = result.values.col(i).eval();
      ++kept;
    }
    result.values.conservativeResize(Eigen::NoChange, kept);
    if (!result.rows) result.values = whitening_(result.values);
    return result;
  }

  [[nodiscard]] Projected projected(const Columns& columns) const {
    Projected result;
    const Eigen::MatrixXd& C = columns.values;
    Eigen::MatrixXd plain;
    Eigen::MatrixXd shared;
    if (columns.rows) {
      plain = whitening_.normal(C, *columns.rows);
      const auto dial = static_cast<std::size_t>(columns.rows - dial_rows_.data());
      shared = calibration::column_products(Q_of_dial_[dial], C);
    } else {
      plain = calibration::column_products(C);
      shared = calibration::column_products(Q_, C);
    }
    result.normal = plain - shared.transpose() * shared;
    result.before = plain.trace();
    return result;
  }

  [[nodiscard]] static Eigen::VectorXd right_of(const Columns& columns, const Left& left) {
    if (!columns.rows) return columns.values.transpose() * left.e;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(columns.values.cols());
    for (Eigen::Index at = 0; at < columns.values.rows(); ++at) {
      right += columns.values.row(at).transpose() *
               left.back[(*columns.rows)[static_cast<std::size_t>(at)]];
    }
    return right;
  }

  /// Rows from the last one up to the first of each of these samples, which rise: `add` takes a
  /// row in, `done` says that all of sample number i are in.
  template <class Add, class Done>
  void from_the_end(
      const std::vector<double>& samples, const Add& add, const Done& done) const {
    Eigen::Index row = readings_.count();
    for (std::size_t i = samples.size(); i-- > 0;) {
      if (i % kLookEvery == 0) geometry::check_end();
      const Eigen::Index first = readings_.first_row(static_cast<std::size_t>(samples[i]));
      while (row > first) add(--row);
      done(i);
    }
  }

  /// C'e of the step at each of these samples.
  [[nodiscard]] std::vector<Eigen::VectorXd> step_right(
      const Columns& columns, const Eigen::VectorXd& e,
      const std::vector<double>& samples) const {
    std::vector<Eigen::VectorXd> result(samples.size());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(columns.values.cols());
    from_the_end(
        samples,
        [&](Eigen::Index row) { right += columns.values.row(row).transpose() * e[row]; },
        [&](std::size_t i) { result[i] = right; });
    return result;
  }

  /// Of a constant shift's columns: the step at each of these samples.
  [[nodiscard]] std::vector<Projected> steps(
      const Columns& columns, const std::vector<double>& samples) const {
    const Eigen::MatrixXd& C = columns.values;
    const Eigen::Index k = C.cols();
    Eigen::MatrixXd plain = Eigen::MatrixXd::Zero(k, k);
    Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(Q_.cols(), k);
    std::vector<Projected> result(samples.size());
    from_the_end(
        samples,
        [&](Eigen::Index row) {
          plain += C.row(row).transpose() * C.row(row);
          shared += Q_.row(row).transpose() * C.row(row);
        },
        [&](std::size_t i) {
          result[i] = {plain - shared.transpose() * shared, plain.trace()};
        });
    return result;
  }

  void take(
      Candidate& candidate, const Projected& seen, const Eigen::VectorXd& right, double sse,
      bool with_evidence) const {
    candidate.surviving =
        seen.before > 0 ? std::sqrt(std::max(0.0, seen.normal.trace()) / seen.before) : 0.0;
    candidate.normal = seen.normal;
    if (candidate.surviving < kLeastSurviving) return;
    if (right.size() == 1) {
      candidate.sizes = right / seen.normal(0, 0);
    } else {
      candidate.sizes = seen.normal.completeOrthogonalDecomposition().solve(right);
    }
    double explained = right.dot(candidate.sizes);
    explained = std::clamp(explained, 0.0, sse * (1 - 1e-12));
    const double freedom = projector_.freedom();
    candidate.gain = -0.5 * freedom * std::log1p(-explained / sse);
    if (!with_evidence) return;
    const MarginalLikelihood found = marginal_likelihood(seen.normal, right, sse, freedom);
    candidate.evidence = found.by_scale.empty() ? 0.0 : log_mean_exp(found.by_scale);
  }

  const Readings& readings_;
  const JointFit& fit_;
  simulation::ExtendedModel extended_;
  Projector projector_;
  const Whitening& whitening_;
  const Eigen::MatrixXd& Q_;
  Eigen::MatrixXd back_q_;  // W'Q, for columns that are not whitened
  Eigen::VectorXd simulated_;
  std::vector<std::vector<Eigen::Index>> dial_rows_;
  std::vector<Eigen::MatrixXd> Q_of_dial_;
};

}  // namespace

simulation::ActiveEffect at_rest(const Hypothesis& hypothesis, double searched) {
  const Effect& effect = *hypothesis.effect;
  ActiveEffect active{
      &effect, hypothesis.place, std::vector<double>(effect.parameters.size(), 0.0)};
  if (effect.searched) active.x.back() = searched;
  return active;
}

namespace {

/// But the exchanges of dials, which are tried on the readings themselves.
std::vector<Hypothesis> tried_here(const std::vector<Hypothesis>& hypotheses) {
  std::vector<Hypothesis> result;
  std::ranges::copy_if(hypotheses, std::back_inserter(result), [](const Hypothesis& each) {
    return !each.effect->exchanges_dials;
  });
  return result;
}

}  // namespace

double simulated_false_alarm(
    const Readings& readings, const JointFit& baseline,
    const std::vector<Hypothesis>& hypotheses, double p_value, int draws, std::uint64_t seed) {
  const Scorer scorer(readings, baseline);
  const std::vector<Hypothesis> asked = tried_here(hypotheses);
  std::vector<Scorer::Prepared> prepared(asked.size());
  calibration::in_parallel(static_cast<int>(asked.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    prepared[k] = scorer.prepare(asked[k]);
  });
  constexpr std::uint32_t kStream = 71;
  const Projector& projector = scorer.projector();
  std::atomic<int> as_good = 0;
  std::atomic<int> done = 0;
  calibration::in_parallel(draws, [&](int draw) {
    geometry::tell_step("sessions of noise alone", done++, draws);
    Eigen::VectorXd e(readings.count());
    for (Eigen::Index row = 0; row < e.size(); ++row) {
      e[row] = calibration::random_normal(
          seed, static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(draw), 0, kStream);
    }
    e -= projector.Q() * (projector.Q().transpose() * e);
    const double squares = e.squaredNorm();
    const Scorer::Left left = scorer.left(std::move(e), squares);
    std::vector<Candidate> candidates;
    for (const auto& each : prepared) {
      Candidate candidate = scorer.score(each, left, false);
      if (candidate.hypothesis.effect) candidates.push_back(std::move(candidate));
    }
    if (family_p_value(candidates) <= p_value) ++as_good;
  });
  return (as_good + 1.0) / (draws + 1.0);
}

std::vector<Candidate> score_all(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses) {
  const Scorer scorer(readings, fit);
  const Scorer::Left left =
      scorer.left(scorer.projector().residual(), scorer.projector().squares());
  const std::vector<Hypothesis> asked = tried_here(hypotheses);
  std::vector<Candidate> result(asked.size());
  std::atomic<std::int64_t> done = 0;
  calibration::in_parallel(static_cast<int>(asked.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    geometry::tell_step("scoring causes", done++, std::ssize(asked));
    result[k] = scorer.score(scorer.prepare(asked[k]), left);
  });
  std::erase_if(result, [](const Candidate& each) { return !each.hypothesis.effect; });
  std::stable_sort(result.begin(), result.end(), [](const Candidate& a, const Candidate& b) {
    if (a.evidence != b.evidence) return a.evidence > b.evidence;
    return a.hypothesis.name() < b.hypothesis.name();
  });
  return result;
}

}  // namespace sixdial::diagnosis
