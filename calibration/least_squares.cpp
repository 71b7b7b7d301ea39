#include "calibration/least_squares.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/long_work.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMostDamping = 1e30;
constexpr double kSmallStep = 1e-14;      // relative to the parameters
constexpr double kSmallDecrease = 1e-26;  // predicted, relative to the cost
constexpr double kSmallPull = 1e-11;      // of held directions, in units of scale
constexpr int kMostPulls = 60;
constexpr double kFlat = 1e-12;  // decrease that the cost itself cannot show, relative
constexpr int kMostFlat =
    20;  // such steps in all: with an approximate Jacobian they go on and on
// Of the normal equations. They square the condition number: 1e5 leaves six digits in a step,
// and steps correct each other.
constexpr int kMostNormal = 64;           // parameters
constexpr double kNormalCondition = 1e5;  // above it every step is by QR and singular values
// Decrease still possible, relative to the cost: the answer is 1e-10 standard deviations away.
constexpr double kNormalSettled = 1e-20;
constexpr int kMostNormalRefusals = 10;  // steps in a row

struct LossValue {
  double cost, weight;  // rho(s), rho'(s)
};

LossValue loss_of(Loss loss, double scale, double s) {
  const double c2 = scale * scale;
  switch (loss) {
    case Loss::kSquare:
      break;
    case Loss::kHuber:
      if (s > c2) return {2 * scale * std::sqrt(s) - c2, scale / std::sqrt(s)};
      break;
    case Loss::kCauchy:
      return {c2 * std::log1p(s / c2), 1.0 / (1.0 + s / c2)};
  }
  return {s, 1.0};
}

class Solver {
 public:
  Solver(
      const LeastSquaresProblem& problem, const VectorXd& start,
      const LeastSquaresSettings& settings)
      : problem_(problem), settings_(settings) {
    const int n = problem.parameters;
    if (start.size() != n || problem.residuals < 1 || !start.allFinite() ||
        (settings.scale.size() != 0 &&
         (settings.scale.size() != n || settings.scale.minCoeff() <= 0.0)) ||
        (settings.anchor.size() != 0 && settings.anchor.size() != n) ||
        (!settings.fixed.empty() && settings.fixed.size() != static_cast<std::size_t>(n)) ||
        settings.block < 1 || problem.residuals % settings.block != 0) {
      throw std::invalid_argument(
          "solve_least_squares: start, scale, anchor and fixed need one finite value for each "
          "parameter, and residuals must be a multiple of the block");
    }
    for (int i = 0; i < n; ++i) {
      if (settings.fixed.empty() || settings.fixed[static_cast<std::size_t>(i)] == 0) {
        free_.push_back(i);
      }
    }
    fit_.x = start;
    anchor_ = settings.anchor.size() != 0 ? settings.anchor : start;
    scale_ = settings.scale.size() != 0 ? settings.scale : VectorXd::Zero(n);
  }

  LeastSquaresFit solve() {
    fit_.free = static_cast<int>(free_.size());
    if (problem_.normal && settings_.max_iterations > 0 && settings_.loss == Loss::kSquare &&
        settings_.scale.size() != 0 && !free_.empty() && problem_.parameters <= kMostNormal) {
      approach();
    }
    if (!approached_ && !value_at(fit_.x, fit_.residual, fit_.cost)) {
      fit_.status = FitStatus::kBadStart;
      fit_.scale =
          settings_.scale.size() != 0 ? settings_.scale : VectorXd::Ones(problem_.parameters);
      return std::move(fit_);
    }
    bool done = false;
    for (int pull = 0; !done; ++pull) {
      const bool descended = descend();
      done = !descended || pull == kMostPulls || !pull_to_anchor();
      fit_.status =
          descended && pull < kMostPulls ? FitStatus::kConverged : FitStatus::kIterationLimit;
    }
    finish();
    return std::move(fit_);
  }

 private:
  using SmallMatrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostNormal, kMostNormal>;
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostNormal, 1>;

  /// Normal equations in free, scaled coordinates.
  struct Normal {
    VectorXd x;
    MatrixXd JtJ;
    VectorXd Jtr;
    double rss = 0.0;
    SmallMatrix A;
    SmallVector b;
  };

  [[nodiscard]] bool normal_at(Normal& at) {
    ++fit_.evaluations;
    if (!problem_.normal(at.x, at.JtJ, at.Jtr, at.rss) || !std::isfinite(at.rss)) return false;
    const auto n = static_cast<Eigen::Index>(free_.size());
    for (Eigen::Index j = 0; j < n; ++j) {
      const int column = free_[static_cast<std::size_t>(j)];
      const double scale = scale_[column];
      at.b[j] = at.Jtr[column] * scale;
      for (Eigen::Index i = j; i < n; ++i) {
        const int row = free_[static_cast<std::size_t>(i)];
        at.A(i, j) = at.JtJ(row, column) * scale * scale_[row];
      }
    }
    return true;
  }

  /// All singular values of J diag(scale) are above what would be held, with room for rounding.
  [[nodiscard]] bool well_determined(const Normal& at) const {
    const double largest =
        std::sqrt(at.A.diagonal().maxCoeff() * static_cast<double>(at.A.rows()));
    const double limit = std::max(
        {settings_.hold_below, settings_.hold_relative * largest, largest / kNormalCondition});
    SmallMatrix shifted = at.A;
    shifted.diagonal().array() -= limit * limit;
    return Eigen::LLT<Eigen::Ref<SmallMatrix>>(shifted).info() == Eigen::Success;
  }

  /// Levenberg-Marquardt by normal equations to within rounding of the minimum. Leaves the
  /// start alone if a direction is not well determined somewhere on the way.
  void approach() {
    const auto n = static_cast<Eigen::Index>(free_.size());
    const int parameters = problem_.parameters;
    Normal at;
    at.x = fit_.x;
    at.JtJ.resize(parameters, parameters);
    at.Jtr.resize(parameters);
    at.A.resize(n, n);
    at.b.resize(n);
    Normal next = at;
    if (!normal_at(at)) return;
    double damping = settings_.first_damping * at.A.diagonal().maxCoeff();
    double grow = 2.0;
    double last_decrease = HUGE_VAL;
    SmallVector u(n);
    int iterations = 0;
    for (; iterations < settings_.max_iterations; ++iterations) {
      geometry::check_end();
      if (!well_determined(at)) return;
      int refused = 0;
      while (true) {
        SmallMatrix damped = at.A;
        damped.diagonal().array() += damping;
        const Eigen::LLT<Eigen::Ref<SmallMatrix>> llt(damped);
        u = -at.b;
        llt.solveInPlace(u);
        const double decrease = u.dot(damping * u - at.b);
        const bool flat = decrease < kFlat * at.rss;
        if (decrease <= kNormalSettled * at.rss || (flat && decrease >= last_decrease)) {
          return reach(at, iterations);
        }
        next.x = at.x;
        for (Eigen::Index j = 0; j < n; ++j) {
          const int column = free_[static_cast<std::size_t>(j)];
          next.x[column] += u[j] * scale_[column];
        }
        const bool has_value = normal_at(next);
        const double ratio = has_value ? (at.rss - next.rss) / decrease : -1.0;
        if (ratio > 0.0 || (flat && has_value)) {
          std::swap(at, next);
          damping *= flat ? 1.0 : std::max(1.0 / 9.0, 1.0 - std::pow(2.0 * ratio - 1.0, 3));
          grow = 2.0;
          last_decrease = flat ? decrease : HUGE_VAL;
          break;
        }
        if (++refused > kMostNormalRefusals) return reach(at, iterations);
        damping *= grow;
        grow *= 2.0;
      }
    }
    reach(at, iterations);
  }

  void reach(const Normal& at, int iterations) {
    VectorXd r;
    double cost = 0.0;
    if (!value_at(at.x, r, cost)) return;
    fit_.x = at.x;
    fit_.residual = r;
    fit_.cost = cost;
    fit_.iterations = iterations;
    approached_ = true;
  }

  [[nodiscard]] bool value_at(const VectorXd& x, VectorXd& r, double& cost) {
    ++fit_.evaluations;
    r.resize(problem_.residuals);
    if (!problem_.evaluate(x, r, nullptr) || !r.allFinite()) return false;
    cost = 0.0;
    for (int b = 0; b < problem_.residuals; b += settings_.block) {
      cost +=
          loss_of(
              settings_.loss, settings_.loss_scale, r.segment(b, settings_.block).squaredNorm())
              .cost;
    }
    return std::isfinite(cost);
  }

  /// J, scaling, singular values at fit_.x. False if the model has no derivative there.
  [[nodiscard]] bool linearise() {
    fit_.J.resize(problem_.residuals, problem_.parameters);
    ++fit_.evaluations;
    if (!problem_.evaluate(fit_.x, fit_.residual, &fit_.J) || !fit_.J.allFinite()) return false;
    const auto m = fit_.J.rows();
    const auto n = static_cast<Eigen::Index>(free_.size());
    MatrixXd A(m, n);
    VectorXd b = fit_.residual;
    for (Eigen::Index j = 0; j < n; ++j) {
      const int column = free_[static_cast<std::size_t>(j)];
      A.col(j) = fit_.J.col(column);
    }
    if (settings_.loss != Loss::kSquare) weigh(A, b);
    for (Eigen::Index j = 0; j < n; ++j) {
      double& scale = scale_[free_[static_cast<std::size_t>(j)]];
      if (settings_.scale.size() == 0) {
        const double norm = A.col(j).norm();
        if (norm > 0.0) scale = scale > 0.0 ? std::min(scale, 1.0 / norm) : 1.0 / norm;
        if (scale <= 0.0) scale = 1.0;
      }
      A.col(j) *= scale;
    }
    if (m > n) {
      const Eigen::HouseholderQR<MatrixXd> qr(A);
      b.applyOnTheLeft(qr.householderQ().adjoint());
      const MatrixXd R = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
      decompose(R, b.head(n));
    } else {
      decompose(A, b);
    }
    return true;
  }

  void weigh(MatrixXd& A, VectorXd& b) const {
    for (int k = 0; k < problem_.residuals; k += settings_.block) {
      const double weight =
          loss_of(
              settings_.loss, settings_.loss_scale, b.segment(k, settings_.block).squaredNorm())
              .weight;
      A.middleRows(k, settings_.block) *= std::sqrt(weight);
      b.segment(k, settings_.block) *= std::sqrt(weight);
    }
  }

  void decompose(const MatrixXd& A, const VectorXd& b) {
    const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeFullV);
    const auto n = A.cols();
    singular_ = VectorXd::Zero(n);
    singular_.head(svd.singularValues().size()) = svd.singularValues();
    V_ = svd.matrixV();
    projected_ = VectorXd::Zero(n);
    projected_.head(svd.matrixU().cols()) = svd.matrixU().transpose() * b;
    const double limit =
        std::max(settings_.hold_below, n > 0 ? settings_.hold_relative * singular_[0] : 0.0);
    int held = 0;
    for (Eigen::Index i = 0; i < n; ++i) held += singular_[i] <= limit ? 1 : 0;
    // Once held for being too uncertain, held for good: a direction at the limit must not make
    // the fit go back and forth.
    held_ = settings_.hold_below > 0.0 ? std::max(held_, held) : held;
  }

  [[nodiscard]] VectorXd in_parameters(const VectorXd& along_directions) const {
    const VectorXd u = V_ * along_directions;
    VectorXd step = VectorXd::Zero(problem_.parameters);
    for (std::size_t j = 0; j < free_.size(); ++j) {
      step[free_[j]] = u[static_cast<Eigen::Index>(j)] * scale_[free_[j]];
    }
    return step;
  }

  /// Levenberg-Marquardt in the determined directions. False at the iteration limit.
  [[nodiscard]] bool descend() {
    double damping = -1.0;
    double grow = 2.0;
    double last_decrease = HUGE_VAL;
    int flat_steps = 0;
    if (!linearise()) return false;
    while (fit_.iterations < settings_.max_iterations) {
      const auto n = singular_.size() - held_;
      if (n <= 0) return true;
      if (damping < 0.0) damping = settings_.first_damping * singular_[0] * singular_[0];
      const double possible = projected_.head(n).squaredNorm();
      const double settled = approached_ ? kNormalSettled : kSmallDecrease;
      const double enough =
          settings_.enough * settings_.enough / static_cast<double>(problem_.residuals);
      if (possible <= std::max(settled, enough) * fit_.cost) return true;
      ++fit_.iterations;
      bool accepted = false;
      while (!accepted) {
        VectorXd along = VectorXd::Zero(singular_.size());
        double predicted = 0.0;
        for (Eigen::Index i = 0; i < n; ++i) {
          const double s = singular_[i];
          along[i] = -s * projected_[i] / (s * s + damping);
          const double left = projected_[i] + s * along[i];
          predicted += projected_[i] * projected_[i] - left * left;
        }
        const VectorXd step = in_parameters(along);
        if (small(step)) return true;
        const bool flat = predicted < kFlat * fit_.cost;
        if (flat && (predicted >= last_decrease || ++flat_steps > kMostFlat)) return true;
        VectorXd r;
        double cost = 0.0;
        const VectorXd x = fit_.x + step;
        const bool has_value = value_at(x, r, cost);
        const double ratio = has_value && predicted > 0.0 ? (fit_.cost - cost) / predicted : -1;
        if (ratio > 0.0 || (flat && has_value)) {
          accepted = true;
          fit_.x = x;
          fit_.residual = r;
          fit_.cost = cost;
          last_decrease = flat ? predicted : HUGE_VAL;
          damping *= flat ? 1.0 : std::max(1.0 / 9.0, 1.0 - std::pow(2.0 * ratio - 1.0, 3));
          damping = std::max(damping, 1e-20 * singular_[0] * singular_[0]);
          grow = 2.0;
        } else {
          damping *= grow;
          grow *= 2.0;
          if (damping > kMostDamping * std::max(1.0, singular_[0] * singular_[0])) return true;
        }
      }
      if (!linearise()) return false;
    }
    return false;
  }

  [[nodiscard]] bool small(const VectorXd& step) const {
    for (const int i : free_) {
      if (std::abs(step[i]) > kSmallStep * (std::abs(fit_.x[i]) + 1e-3 * scale_[i])) {
        return false;
      }
    }
    return true;
  }

  /// Moves held directions back to the anchor. False if they are there already.
  [[nodiscard]] bool pull_to_anchor() {
    if (held_ == 0) return false;
    const auto n = singular_.size();
    VectorXd u(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const int i = free_[static_cast<std::size_t>(j)];
      u[j] = (anchor_[i] - fit_.x[i]) / scale_[i];
    }
    VectorXd along = V_.transpose() * u;
    along.head(n - held_).setZero();
    if (along.norm() <= kSmallPull * (1.0 + u.norm())) return false;
    for (double part = 1.0; part > 1e-3; part /= 2) {
      VectorXd r;
      double cost = 0.0;
      const VectorXd x = fit_.x + in_parameters(part * along);
      if (value_at(x, r, cost)) {
        fit_.x = x;
        fit_.residual = r;
        fit_.cost = cost;
        return true;
      }
    }
    return false;
  }

  void finish() {
    fit_.rss = fit_.residual.squaredNorm();
    for (int b = 0; b < problem_.residuals; b += settings_.block) {
      fit_.block_weight.push_back(loss_of(
                                      settings_.loss, settings_.loss_scale,
                                      fit_.residual.segment(b, settings_.block).squaredNorm())
                                      .weight);
    }
    fit_.scale = scale_;
    fit_.singular_values = singular_;
    fit_.held = held_;
    fit_.directions = MatrixXd::Zero(problem_.parameters, V_.cols());
    for (std::size_t j = 0; j < free_.size(); ++j) {
      fit_.directions.row(free_[j]) = V_.row(static_cast<Eigen::Index>(j));
    }
  }

  const LeastSquaresProblem& problem_;
  const LeastSquaresSettings& settings_;
  std::vector<int> free_;
  VectorXd anchor_;
  VectorXd scale_;
  VectorXd singular_;
  VectorXd projected_;  // U'r
  MatrixXd V_;
  int held_ = 0;
  bool approached_ = false;  // by normal equations
  LeastSquaresFit fit_;
};

}  // namespace

LeastSquaresFit solve_least_squares(
    const LeastSquaresProblem& problem, const Eigen::VectorXd& start,
    const LeastSquaresSettings& settings) {
  return Solver(problem, start, settings).solve();
}

}  // namespace sixdial::calibration
