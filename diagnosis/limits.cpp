#include "diagnosis/limits.h"

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/column_products.h"
#include "calibration/crew.h"
#include "diagnosis/absorbers.h"
#include "diagnosis/eliminated.h"
#include "diagnosis/limit_power.h"
#include "diagnosis/limit_search.h"
#include "diagnosis/significance.h"
#include "diagnosis/thresholds.h"
#include "diagnosis/unknown.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kPower = 0.8;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// What one session can show: each hypothesis against its rivals.
class LimitStudy {
 public:
  LimitStudy(
      const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses,
      const NamingSettings& settings)
      : readings_(readings),
        fit_(fit),
        projector_(fit),
        settings_(settings),
        noise_(projector_, kLimitDraws) {
    const simulation::ExtendedModel extended(readings.model(), fit.effects);
    const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
    all_.resize(hypotheses.size());
    calibration::in_parallel(static_cast<int>(hypotheses.size()), [&](int i) {
      geometry::check_end();
      const auto k = static_cast<std::size_t>(i);
      if (hypotheses[k].effect->exchanges_dials) return;  // no size to be told
      all_[k] = seen_of(hypotheses[k], extended, simulated);
    });
    std::erase_if(all_, [](const SeenEffect& each) { return each.values.empty(); });
    for (const SeenEffect& each : all_)
      needs_time_ = needs_time_ || each.hypothesis.effect->in_time;
    if (needs_time_) add_smooth_in_time();
    add_rig_rivals();
    // The prior of one among so many: the search tries all that can be tested.
    std::vector<NotTestable> ignored;
    catalogue_ =
        static_cast<double>(std::max<std::size_t>(2, hypotheses_for(readings, ignored).size()));
    prior_cost_ = std::log(catalogue_);
  }

  [[nodiscard]] std::vector<Limit> limits() const {
    std::vector<Limit> result(all_.size());
    std::atomic<std::int64_t> done = 0;
    calibration::in_parallel(static_cast<int>(all_.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      geometry::tell_step("limits of causes", done++, std::ssize(all_));
      result[k] = limit_of(all_[k]);
    });
    return result;
  }

 private:
  /// What dials do within their makers' limits, and what the rig file claims exactly.
  void add_rig_rivals() {
    const double tried =
        std::log(std::max(1.0, static_cast<double>(count_of_smooth(readings_))));
    for (const RigRival& each : rig_rivals(readings_, fit_)) {
      const double cost = is_background(each.kind) ? 0.0 : settings_.name_preference + tried;
      unnamed_.emplace_back(each.kind, cost, projector_, noise_.rows, each.boxes);
    }
  }

  void add_smooth_in_time() {
    std::vector<RandomBox> smooth = smooth_in_time(readings_, fit_);
    const double cost =
        settings_.name_preference +
        std::log(std::max(1.0, static_cast<double>(count_of_smooth(readings_)))) +
        std::log(static_cast<double>(std::max<std::size_t>(1, smooth.size())));
    for (RandomBox& each : smooth) {  // of a long session all of them are much memory
      const std::vector<RandomBox> one{std::move(each)};
      unnamed_.emplace_back(UnknownKind::kSmooth, cost, projector_, noise_.rows, one);
    }
  }

  /// Whether it could stand for an effect. What six dials do by themselves can be a tip, a
  /// cuboid or a robot that is not as the file says: evidence tells how well.
  static bool is_rival(UnknownKind kind, const Hypothesis& own) {
    if (kind == UnknownKind::kSmooth) return own.effect->in_time;
    if (kind == UnknownKind::kRigGeometry) return own.effect->of_rig_geometry;
    return true;
  }

  /// By value of the effect: the best of each kind.
  [[nodiscard]] std::vector<std::vector<BestUnnamed>> best_unnamed(
      const SeenEffect& own) const {
    std::vector<std::vector<BestUnnamed>> result;
    for (const LimitColumns& at : own.values) {
      std::vector<BestUnnamed>& best = result.emplace_back();
      for (const UnnamedRival& each : unnamed_) {
        if (!is_rival(each.kind(), own.hypothesis)) continue;
        UnnamedRival::Shared shared = each.shared_with(at.projected);
        const double sum = evidence_of_well_seen(at, [&](const auto& x, double sse) {
          return each.evidence(shared, x, sse, projector_.freedom());
        });
        const auto known = std::ranges::find(
            best, each.kind(), [](const BestUnnamed& other) { return other.of->kind(); });
        if (known == best.end()) {
          best.push_back({&each, std::move(shared), sum});
        } else if (sum > known->score) {
          *known = {&each, std::move(shared), sum};
        }
      }
    }
    return result;
  }

  [[nodiscard]] SeenEffect seen_of(
      const Hypothesis& each, const simulation::ExtendedModel& extended,
      const Eigen::VectorXd& simulated) const {
    SeenEffect seen{each, {}, 1.0, 1.0, 1.0, {}};
    std::vector<double> values{0.0};
    if (each.effect->searched) {
      values =
          each.effect->searched(readings_.model().rig(), readings_.circumstances(), each.place);
      seen.searched = static_cast<double>(std::max<std::size_t>(1, values.size()));
      seen.tries = independent_tries(*each.effect, values.size());
      values = few_of(std::move(values), each.effect->is_step);
    }
    const Eigen::MatrixXd& Q = projector_.Q();
    for (const double value : values) {
      const Eigen::MatrixXd raw = projector_.whitening()(
          effect_columns(readings_, fit_.model, extended, at_rest(each, value), simulated));
      Eigen::MatrixXd kept(raw.rows(), 0);
      LimitColumns columns;
      for (Eigen::Index i = 0; i < raw.cols(); ++i) {
        const auto here =
            simulation::parameter_at(*each.effect, each.place, static_cast<int>(i));
        if (!here || raw.col(i).squaredNorm() <= 0) continue;
        kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
        kept.rightCols(1) = raw.col(i);
        columns.sizes.conservativeResize(kept.cols());
        columns.sizes[kept.cols() - 1] = here->sigma;
        columns.one_sided = columns.one_sided || here->never_negative;
      }
      if (kept.cols() == 0) continue;
      if (seen.raw.size() == 0) seen.raw = kept.col(0);
      const Eigen::MatrixXd fitted = calibration::column_products(Q, kept);
      columns.projected = kept - Q * fitted;
      columns.normal = gram(kept) - gram(fitted);
      seen.surviving = std::min(
          seen.surviving, std::sqrt(std::max(0.0, columns.normal.trace())) / kept.norm());
      columns.noise = calibration::column_products(kept, noise_.rows);
      columns.weighted = std::move(kept);
      columns.inverse = columns.normal.completeOrthogonalDecomposition().pseudoInverse();
      columns.evidence = MarginalEvidence(columns.normal);
      seen.values.push_back(std::move(columns));
    }
    return seen;
  }

  [[nodiscard]] Limit limit_of(const SeenEffect& own) const {
    Limit limit;
    limit.hypothesis = own.hypothesis;
    const auto parameter =
        simulation::parameter_at(*own.hypothesis.effect, own.hypothesis.place, 0);
    limit.unit = std::string(parameter->unit);
    limit.plausible = parameter->sigma;
    limit.surviving = own.surviving;
    limit.detect = limit.name = kInfinite;
    if (own.surviving >= kLeastSurviving) find_sizes(own, limit);
    limit.absorbed_by =
        absorbers(readings_.model().parameters(), own.raw, projector_.whitening()(fit_.J));
    return limit;
  }

  /// Mean over the parameters of an effect, each alone at a size that is named, without noise:
  /// `evidence(x, squares of what is left)`.
  template <typename Evidence>
  [[nodiscard]] double evidence_of_well_seen(
      const LimitColumns& at, const Evidence& evidence) const {
    constexpr double kSeen = 40.0;  // squares of a signal that is named, over the noise's
    const double s2 = projector_.squares() / projector_.freedom();
    const Eigen::VectorXd squares = at.squares_of_plausible();  // of each column's signal
    const double scale = std::sqrt(kSeen * s2 / std::max(1e-300, squares.sum()));
    double sum = 0.0;
    for (Eigen::Index k = 0; k < at.sizes.size(); ++k) {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(at.sizes.size());
      x[k] = scale * at.sizes[k];
      sum += evidence(x, projector_.squares() + scale * scale * squares[k]);
    }
    return sum / static_cast<double>(at.sizes.size());
  }

  void find_sizes(const SeenEffect& own, Limit& limit) const {
    const LimitPower::Study study{projector_, noise_, settings_, catalogue_, prior_cost_};
    const LimitPower power(
        study, own, {held_against(own, own).cost, hardest_rivals(own), best_unnamed(own)});
    double most = 0.0;  // signal of a plausible size, in any direction
    for (const LimitColumns& each : own.values) {
      most = std::max(most, std::sqrt(each.squares_of_plausible().sum()));
    }
    const double s_mm = std::sqrt(projector_.squares() / projector_.freedom());
    const double low = 1e-1 * s_mm / std::max(1e-300, most) * limit.plausible;
    const double high = 1e7 * low;
    limit.detect = least_size(low, high, [&](double size) {
      return power.detected(size / limit.plausible) >= kPower;
    });
    limit.name = least_size(
        low, high, [&](double size) { return power.named(size / limit.plausible) >= kPower; });
    limit.name = std::max(limit.name, limit.detect);
    // The rival that most often stands in the way, just below the limit.
    const double near = std::isfinite(limit.name) ? 0.8 * limit.name : high;
    if (const LimitRival* worst = power.worst_rival(near / limit.plausible)) {
      limit.rival = worst->seen->hypothesis;
    }
  }

  /// How well a hypothesis explains each value of `own`; of itself, what its search costs.
  [[nodiscard]] LimitRival held_against(const SeenEffect& own, const SeenEffect& other) const {
    LimitRival rival{&other, {}, {}, {}, -kInfinite};
    for (const LimitColumns& at : own.values) {
      std::vector<double> evidences;
      std::size_t best = 0;
      rival.cross.emplace_back();
      for (const LimitColumns& there : other.values) {
        Eigen::MatrixXd cross = calibration::column_products(there.weighted, at.projected);
        evidences.push_back(evidence_of_well_seen(at, [&](const auto& x, double sse) {
          return there.evidence(cross * x, sse, projector_.freedom());
        }));
        if (evidences.back() < evidences[best]) continue;
        best = evidences.size() - 1;
        rival.cross.back() = std::move(cross);
      }
      rival.at.push_back(&other.values[best]);
      rival.cost.push_back(cost_of_search(evidences, best, other.searched));
      rival.evidence = std::max(rival.evidence, evidences[best] - rival.cost.back());
    }
    return rival;
  }

  /// The five that explain most of a signal that is well seen.
  [[nodiscard]] std::vector<LimitRival> hardest_rivals(const SeenEffect& own) const {
    std::vector<LimitRival> result;
    for (const SeenEffect& other : all_) {
      if (other.hypothesis == own.hypothesis || other.surviving < kLeastSurviving) continue;
      result.push_back(held_against(own, other));
    }
    std::stable_sort(
        result.begin(), result.end(), [](const LimitRival& a, const LimitRival& b) {
          return a.evidence != b.evidence
                     ? a.evidence > b.evidence
                     : a.seen->hypothesis.name() < b.seen->hypothesis.name();
        });
    constexpr std::size_t kHardest = 5;
    if (result.size() > kHardest) result.erase(result.begin() + kHardest, result.end());
    return result;
  }

  const Readings& readings_;
  const JointFit& fit_;
  Projector projector_;
  const NamingSettings& settings_;
  const DrawnNoise noise_;
  std::vector<SeenEffect> all_;
  double catalogue_ = 2.0;  // hypotheses that the search tries
  double prior_cost_ = 0.0;
  bool needs_time_ = false;
  std::vector<UnnamedRival> unnamed_;
};

}  // namespace

std::vector<Limit> limits_of(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses,
    const NamingSettings& settings) {
  return LimitStudy(readings, fit, hypotheses, settings).limits();
}

}  // namespace sixdial::diagnosis
