#include "diagnosis/joint_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "calibration/crew.h"
#include "diagnosis/eliminated.h"
#include "diagnosis/plausible_robot.h"
#include "diagnosis/shareable.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;
using simulation::ExtendedModel;
using simulation::ModelVector;

// A pose that does not exist is as far off as can be.
constexpr double kOutOfReach_mm = 100.0;

/// Gross errors lie within a millimetre; far from a fit everything does, and they lie further.
double gross_range_mm(double s_mm) { return std::max(kGrossRange_mm, 30.0 * s_mm); }

double robust_scale(const Eigen::VectorXd& e) {
  std::vector<double> size(static_cast<std::size_t>(e.size()));
  for (Eigen::Index i = 0; i < e.size(); ++i)
    size[static_cast<std::size_t>(i)] = std::abs(e[i]);
  if (size.empty()) return 0.0;
  const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  return 1.4826 * *middle;
}

/// Noise of each reading in s: that of its dial, and what nobody knows of its sample.
void set_noise(JointFit& fit, const Eigen::VectorXd& relative, const Eigen::VectorXd& doubt) {
  fit.noise = relative;
  for (Eigen::Index i = 0; i < doubt.size(); ++i) {
    if (doubt[i] > 0) fit.noise[i] = std::hypot(relative[i], doubt[i] / fit.s_mm);
  }
}

/// Expectation steps: weights, shared shifts, s, share of gross errors, likelihood.
void weigh(
    JointFit& fit, const Eigen::VectorXd& relative, const Eigen::VectorXd& doubt,
    double smallest_s_mm) {
  const Eigen::VectorXd& e = fit.residual_mm;
  const double n = static_cast<double>(e.size());
  if (fit.weight.size() != e.size()) fit.weight = Eigen::VectorXd::Ones(e.size());
  fit.shift_mm = Eigen::VectorXd::Zero(e.size());
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) {
    const bool last = pass + 1 == kPasses;  // only its likelihood is told
    double squares = 0.0;
    double good = 0.0;
    fit.log_likelihood = 0.0;
    const double density = 1.0 / std::sqrt(2 * std::numbers::pi);
    const double as_gross = fit.gross_share / gross_range_mm(fit.s_mm);
    set_noise(fit, relative, doubt);
    if (fit.shared) {
      const Whitening whitening = fit.whitening();
      Whitening::Shifts shifts = whitening.shifts_of(e);
      fit.shift_mm = std::move(shifts.in_readings_mm);
      squares = shifts.squares;
      fit.log_likelihood =
          -0.5 * squares / (fit.s_mm * fit.s_mm) - 0.5 * whitening.log_volume();
    }
    for (Eigen::Index i = 0; i < e.size(); ++i) {
      const double s_mm = fit.s_mm * fit.noise[i];
      const double own_mm = e[i] - fit.shift_mm[i];
      const double z = own_mm / s_mm;
      const double as_good = (1 - fit.gross_share) * density / s_mm * std::exp(-0.5 * z * z);
      fit.weight[i] = as_good / (as_good + as_gross);
      if (last) fit.log_likelihood += std::log(as_good + as_gross);
      squares += fit.weight[i] * std::pow(own_mm / fit.noise[i], 2);
      good += fit.weight[i];
    }
    squares += fit.u.tail(fit.u.size() - fit.known).squaredNorm();
    fit.s_mm = std::max(smallest_s_mm, std::sqrt(squares / std::max(1.0, good)));
    fit.gross_share = std::clamp(1 - good / n, kLeastGrossShare, kMostGrossShare);
  }
}

/// Of a shared part: what the parameters' uncertainty changes by it, and that it must show
/// itself.
double cost_of_sharing(const JointFit& fit, const Whitening& whitening) {
  const Eigen::MatrixXd Q = orthonormal_basis(whitening.root().asDiagonal() * fit.J);
  const Eigen::MatrixXd spread = whitening.spread(Q);
  const Eigen::LLT<Eigen::MatrixXd> llt(spread.transpose() * spread);
  return llt.matrixLLT().diagonal().array().log().sum() + kSharedLogOdds;
}

/// Equations of a fit in which what is plausible counts as a reading of each number.
EliminatedEquations equations_of(
    const JointFit& fit, const Whitening& whitening, const PlausibleRobot& plausible,
    const Eigen::VectorXd& root_of_u) {
  Eigen::MatrixXd A = whitening(fit.J);
  Eigen::MatrixXd C = whitening(fit.random);
  Eigen::VectorXd e = whitening(fit.residual_mm);
  if (const Eigen::Index p = plausible.per_sd.size(); p > 0) {
    const Eigen::Index n = A.rows();
    A.conservativeResize(n + p, Eigen::NoChange);
    C.conservativeResize(n + p, Eigen::NoChange);
    e.conservativeResize(n + p);
    A.bottomRows(p).setZero();
    C.bottomRows(p).setZero();
    for (Eigen::Index i = 0; i < p; ++i) {
      // A number that is held has no slope, and stays.
      const bool moves = (A.col(i).head(n).array() != 0.0).any();
      A(n + i, i) = moves ? fit.s_mm * plausible.per_sd[i] : 0.0;
      e[n + i] = A(n + i, i) * (plausible.at[i] - fit.model[i]);
    }
  }
  return {A, C, e, root_of_u, fit.u};
}

/// Covariance, and u integrated out of the likelihood, with r = s / (standard deviation of u):
///   -|r u|^2 / 2s^2 - ln det(I + C'P C / r^2) / 2,   P projects off the fitted columns;
/// shared shifts likewise: their likelihood is the residual one (sample_scatter.h).
void finish(JointFit& fit, const PlausibleRobot& plausible) {
  const Whitening whitening = fit.whitening();
  const Eigen::Index m = fit.random.cols();
  const Eigen::VectorXd own = fit.root_of_u();
  const EliminatedEquations equations = equations_of(fit, whitening, plausible, own);
  const Eigen::VectorXd variance_of_u = equations.variance_of_u();
  // A known prior is no reading of the noise; what the data take from it they spend.
  const Eigen::VectorXd left = variance_of_u.cwiseProduct(own.cwiseAbs2());
  const double spent = static_cast<double>(fit.known) - left.head(fit.known).sum();
  const double squares =
      whitening(fit.residual_mm).squaredNorm() + fit.u.tail(m - fit.known).squaredNorm();
  const double variance = squares / std::max(1.0, fit.weight.sum() - fit.fitted - spent);
  fit.covariance = equations.covariance() * variance;
  fit.u_sd_mm = (variance_of_u * variance).cwiseMax(0.0).cwiseSqrt();
  if (fit.shared) fit.log_likelihood -= cost_of_sharing(fit, whitening);
  if (m == 0) return;
  fit.log_likelihood += 0.5 * equations.log_volume_of_u() + own.array().log().sum() -
                        0.5 * own.cwiseProduct(fit.u).squaredNorm() / (fit.s_mm * fit.s_mm);
}

Eigen::VectorXd tamed(Eigen::VectorXd e) {
  return e.unaryExpr([](double v) { return std::isfinite(v) ? v : kOutOfReach_mm; });
}

// Standard deviations are not fitted below this, nor below a share of the rig's noise: exact
// data would make the weights of gross readings meaningless.
constexpr double kFinest_mm = 1e-6;
constexpr double kFinestShare = 0.05;
// Damping of the normal matrix, in its largest eigenvalue. Some effects bend the readings the
// same way as lengths do, to a millionth.
constexpr double kLeastDamping = 1e-10;
constexpr double kMostDamping = 10.0;
constexpr int kMostSteps = 60;

// A fit has settled where a step of least squares would raise the log likelihood by no more
// than this, which no parameter's unit and no long valley can hide.
constexpr double kNoGain = 5e-4;
// A step that is taken from nearer than this, and gains as little, ends there: in a bent valley
// many small ones could follow, and be worth no more together.
constexpr double kNearGain = 5e-3;

/// One fit from one start, step by step.
class Fitter {
 public:
  Fitter(
      const Readings& readings, const ModelVector& start, std::vector<ActiveEffect> effects,
      const JointFit* near, const Eigen::MatrixXd& random)
      : readings_(readings),
        parameters_(start.size()),
        plausible_(plausible_robot(readings, start.size())),
        smallest_s_mm_(std::max(kFinest_mm, kFinestShare * readings.rig_noise_mm())) {
    const Eigen::MatrixXd& nuisance = readings.nuisance();
    fit_.known = nuisance.cols();
    fit_.known_sd_mm = std::max(kFinest_mm, readings.rig_noise_mm());
    fit_.random.resize(readings.count(), nuisance.cols() + random.cols());
    // What has no columns may have no rows either.
    if (nuisance.cols() > 0) fit_.random.leftCols(nuisance.cols()) = nuisance;
    if (random.cols() > 0) fit_.random.rightCols(random.cols()) = random;
    fit_.u = Eigen::VectorXd::Zero(fit_.random.cols());
    fit_.noise = readings.relative_noise();
    fit_.model = start;
    fit_.effects = std::move(effects);
    fit_.gross_share = near ? near->gross_share : kLeastGrossShare;
    fit_.shift_mm = Eigen::VectorXd::Zero(readings.count());
    if (near) share_as(*near);
    fit_.residual_mm = residual_of(fit_.model, fit_.effects, fit_.u);
    fit_.s_mm = std::max({smallest_s_mm_, near ? near->s_mm : 0.0, scale_of_residual()});
  }

  /// `plain_steps`: so many steps of least squares with every reading counted, before the
  /// weights come in; fewer if these settle.
  [[nodiscard]] JointFit run(int plain_steps) {
    iterate(plain_steps);
    constexpr int kMostChanges = 5;
    for (int i = 0; i < kMostChanges && fit_.converged && share_anew(); ++i) {
      fit_.converged = false;
      iterate(0);
    }
    finish(fit_, plausible_);
    return std::move(fit_);
  }

 private:
  void iterate(int plain_steps) {
    // In space slopes are dear. Where a step did what they had promised, to a hundredth, they
    // hold for the next one too, and for the end: what they are off by moves the answer by
    // less than where a fit ends.
    bool keeps_slopes = false;
    for (int step = 0; step < kMostSteps && !fit_.converged; ++step) {
      const bool plain = step < plain_steps;
      doubt_mm_ = readings_.doubt_mm(fit_.model, extended_here());
      weigh_here();
      if (plain) fit_.weight.setOnes();
      const bool fresh = !keeps_slopes;
      if (fresh) linearise();
      const Equations equations = equations_here();
      const double gain = gain_of(equations);
      if (!plain && gain < kNoGain) {
        fit_.converged = true;
        break;
      }
      std::optional<Moved> next = downhill(equations);
      if (!next) {
        if (std::exchange(keeps_slopes, false)) continue;
        if (!plain) break;  // nowhere to go, though the slope says so
        plain_steps = step;
        continue;
      }
      const double fall = equations.squares - next->squares;
      const double promised = equations.solved.fall();
      constexpr double kAsPromised = 0.01;
      keeps_slopes = readings_.axes() == 3 && damping_ == 0.0 &&
                     std::abs(fall - promised) < kAsPromised * std::abs(promised);
      const double last = fit_.log_likelihood;
      fit_.model = std::move(next->model);
      fit_.effects = std::move(next->effects);
      fit_.residual_mm = std::move(next->residual);
      fit_.u = std::move(next->u);
      weigh_here();
      if (plain) {
        // Of the squares: a smaller fall ends the plain steps.
        constexpr double kSettled = 0.01;
        fit_.s_mm = std::max(smallest_s_mm_, scale_of_residual());
        fit_.gross_share = kLeastGrossShare;
        if (fall < kSettled * equations.squares) plain_steps = step;
        continue;
      }
      constexpr double kNoRise = 1e-2;  // of the log likelihood
      fit_.converged = (fresh || keeps_slopes) && gain < kNearGain &&
                       std::abs(fit_.log_likelihood - last) < kNoRise;
    }
  }

  /// Starts from the shared part that a similar fit has.
  void share_as(const JointFit& near) {
    fit_.shared = readings_.shareable_like(near.shared.get());
    if (fit_.shared) fit_.shared_ratio = near.shared_ratio;
  }

  /// Looks again at what readings of an arrival share, now that the fit stands. Whether
  /// anything changed by that.
  [[nodiscard]] bool share_anew() {
    const Eigen::VectorXd root = fit_.root();
    const double freedom = std::max(3.0, fit_.weight.sum() - fit_.fitted);
    const Eigen::MatrixXd random = fit_.scaled_random();
    const Eigen::VectorXd u = fit_.scaled_u();
    const LeftOver left{root, fit_.residual_mm, fit_.J, random, u, freedom};
    const auto before = fit_.shared;
    const double ratio_before = fit_.shared_ratio;
    fit_.shared = nullptr;
    fit_.shared_ratio = 0.0;
    const auto& kinds = readings_.shareable();
    std::vector<std::optional<ScatterSize>> sizes(kinds.size());
    calibration::in_parallel(static_cast<int>(kinds.size()), [&](int i) {
      const auto& each = kinds[static_cast<std::size_t>(i)];
      // Beside smooth functions a look is dear: the kind of sharing then stays.
      const bool same = each == before;
      if (before && !same && fit_.random.cols() > fit_.known) return;
      if (!before && !may_be_shared(left, *each)) return;
      if (comes_back(readings_, *each, {fit_.residual_mm, fit_.weight, fit_.noise})) return;
      sizes[static_cast<std::size_t>(i)] =
          scatter_size(left, *each, {.near = same ? ratio_before : 0.0});
    });
    double most = kSharedLogOdds;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (!sizes[i] || sizes[i]->gain <= most) continue;
      most = sizes[i]->gain;
      fit_.shared = kinds[i];
      fit_.shared_ratio = sizes[i]->ratio;
    }
    if (!fit_.shared) fit_.shift_mm.setZero();
    constexpr double kSettled = 0.03;  // of the ratio's logarithm: a hundredth of log evidence
    return fit_.shared != before ||
           (fit_.shared && std::abs(std::log(fit_.shared_ratio / ratio_before)) > kSettled);
  }

  /// Least squares of one step.
  struct Equations {
    Whitening whitening;
    Eigen::VectorXd root_of_u;  // of the prior's rows
    EliminatedEquations solved;
    double squares;  // to be made less
  };
  struct Moved {
    ModelVector model;
    std::vector<ActiveEffect> effects;
    Eigen::VectorXd residual, u;
    double squares;
  };

  [[nodiscard]] ExtendedModel extended_here() const {
    return {readings_.model(), fit_.effects};
  }
  [[nodiscard]] Eigen::VectorXd simulated(
      const ModelVector& model, const std::vector<ActiveEffect>& effects) const {
    return readings_.simulate(model, ExtendedModel(readings_.model(), effects));
  }
  /// What a step makes less [mm^2, by relative noise].
  [[nodiscard]] double squares_at(
      const Equations& equations, const Eigen::VectorXd& residual, const ModelVector& model,
      const Eigen::VectorXd& u) const {
    const double of_u = u.size() > 0 ? equations.root_of_u.cwiseProduct(u).squaredNorm() : 0.0;
    return equations.whitening(residual).squaredNorm() + of_u +
           fit_.s_mm * fit_.s_mm * plausible_.squares(model);
  }
  void weigh_here() { weigh(fit_, readings_.relative_noise(), doubt_mm_, smallest_s_mm_); }
  [[nodiscard]] Eigen::VectorXd residual_of(
      const ModelVector& model, const std::vector<ActiveEffect>& effects,
      const Eigen::VectorXd& u) const {
    Eigen::VectorXd e = tamed(readings_.measured_mm() - simulated(model, effects));
    if (u.size() > 0) e -= fit_.random * u;
    return e;
  }
  [[nodiscard]] double scale_of_residual() const {
    return robust_scale(fit_.residual_mm.cwiseQuotient(fit_.noise));
  }

  /// fit_.J where the fit stands.
  void linearise() {
    std::vector<simulation::EffectNumber> numbers;
    for (std::size_t k = 0; k < fit_.effects.size(); ++k) {
      const ActiveEffect& active = fit_.effects[k];
      const auto& effect = *active.effect;
      for (int i = 0; i < fitted_count(effect); ++i) {
        const auto index = static_cast<std::size_t>(i);
        const auto here = simulation::parameter_at(effect, active.place, i);
        constexpr double kShareOfSize = 1e-2;
        const double step =
            i < linear_count(effect)
                ? kShareOfSize * (here ? here->sigma : effect.parameters[index].sigma)
                : effect.searched_change(active.x[index]);
        numbers.push_back({k, index, step});
      }
    }
    fit_.J = readings_.jacobian(fit_.model, extended_here(), numbers);
  }

  /// By how much the least-squares step would raise the log likelihood.
  [[nodiscard]] double gain_of(const Equations& equations) const {
    return 0.5 * equations.solved.fall() / (fit_.s_mm * fit_.s_mm);
  }

  /// Also says how many parameters the data determine.
  [[nodiscard]] Equations equations_here() {
    const Whitening whitening = fit_.whitening();
    const Eigen::VectorXd root_of_u = fit_.root_of_u();
    Equations result{
        whitening, root_of_u, equations_of(fit_, whitening, plausible_, root_of_u), 0.0};
    fit_.fitted = static_cast<int>(result.solved.determined());
    result.squares = squares_at(result, fit_.residual_mm, fit_.model, fit_.u);
    return result;
  }

  /// The least damped step that does not go uphill; empty if there is none.
  [[nodiscard]] std::optional<Moved> downhill(const Equations& equations) {
    for (damping_ /= 100; damping_ < kMostDamping;
         damping_ = std::max(10 * damping_, kLeastDamping)) {
      if (damping_ < kLeastDamping) damping_ = 0.0;
      const Eigen::VectorXd change = equations.solved.step(damping_);
      if (!change.allFinite()) return std::nullopt;
      Moved next{fit_.model + change.head(parameters_), fit_.effects, {}, {}, 0.0};
      Eigen::Index at = parameters_;
      for (ActiveEffect& active : next.effects) {
        for (int i = 0; i < fitted_count(*active.effect); ++i) {
          active.x[static_cast<std::size_t>(i)] += change[at++];
        }
      }
      next.u = fit_.u + change.tail(fit_.random.cols());
      next.residual = residual_of(next.model, next.effects, next.u);
      next.squares = squares_at(equations, next.residual, next.model, next.u);
      if (next.squares <= equations.squares * (1 + 1e-12)) return next;
    }
    return std::nullopt;
  }

  const Readings& readings_;
  Eigen::Index parameters_;  // of the model, before those of the effects
  PlausibleRobot plausible_;
  double smallest_s_mm_;
  double damping_ = 0.0;
  Eigen::VectorXd doubt_mm_;
  JointFit fit_;
};

}  // namespace

Eigen::VectorXd residual_at_rest_mm(const Readings& readings, const JointFit& fit) {
  return fit.own_residual_mm().cwiseProduct(readings.relative_noise()).cwiseQuotient(fit.noise);
}

std::optional<ScatterSize> JointFit::scatter(bool with_interval) const {
  if (!shared) return std::nullopt;
  const Eigen::VectorXd roots = root();
  const double freedom = std::max(3.0, weight.sum() - fitted);
  return scatter_size(
      {roots, residual_mm, J, scaled_random(), scaled_u(), freedom}, *shared,
      {.near = shared_ratio, .with_interval = with_interval});
}

JointFit fit_jointly(
    const Readings& readings, const ModelVector& start, std::vector<ActiveEffect> effects,
    const JointFit* near, const Eigen::MatrixXd& random) {
  // From far away every reading counts until the steps are small.
  constexpr int kFromFar = 12;
  JointFit fit = Fitter(readings, start, effects, near, random).run(near ? 0 : kFromFar);
  // A fit that settled on a part of the session calls the rest gross.
  if (near && (fit.gross_share > kSuspiciousGrossShare || !fit.converged)) {
    JointFit again = Fitter(readings, start, effects, near, random).run(kFromFar);
    if (again.log_likelihood > fit.log_likelihood) fit = std::move(again);
  }
  return fit;
}

}  // namespace sixdial::diagnosis
