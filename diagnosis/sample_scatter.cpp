#include "diagnosis/sample_scatter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "diagnosis/eliminated.h"
#include "diagnosis/orthonormal.h"

namespace sixdial::diagnosis {
namespace {

/// Columns of each block turned so that they are orthogonal there; their squared lengths.
void turn(
    Eigen::MatrixXd& columns, const std::vector<Eigen::Index>& first_row,
    Eigen::MatrixXd& lambda) {
  const auto blocks = static_cast<Eigen::Index>(first_row.size()) - 1;
  lambda.resize(blocks, columns.cols());
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index first = first_row[static_cast<std::size_t>(b)];
    const Eigen::Index rows = first_row[static_cast<std::size_t>(b) + 1] - first;
    const Eigen::MatrixXd block = columns.middleRows(first, rows);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(block.transpose() * block);
    lambda.row(b) = eigen.eigenvalues().cwiseMax(0.0).transpose();
    columns.middleRows(first, rows) = block * eigen.eigenvectors();
  }
}

}  // namespace

Whitening::Whitening(Eigen::VectorXd root, const ScatterColumns* shared, double ratio)
    : root_(std::move(root)) {
  if (shared == nullptr || !(ratio > 0.0)) return;
  first_row_ = shared->first_row;
  scaled_ = std::sqrt(ratio) * (root_.asDiagonal() * shared->columns);
  turn(scaled_, first_row_, lambda_);
  log_volume_ = lambda_.array().log1p().sum();
}

/// B~'X of each block, one below the other.
Eigen::MatrixXd Whitening::along(const Eigen::MatrixXd& X) const {
  const Eigen::Index k = scaled_.cols();
  Eigen::MatrixXd result(lambda_.rows() * k, X.cols());
  for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
    const Eigen::Index first = first_row_[static_cast<std::size_t>(b)];
    const Eigen::Index rows = first_row_[static_cast<std::size_t>(b) + 1] - first;
    result.middleRows(b * k, k).noalias() =
        scaled_.middleRows(first, rows).transpose() * X.middleRows(first, rows);
  }
  return result;
}

Eigen::MatrixXd Whitening::spread(Eigen::MatrixXd X) const {
  // (I + B~B~')^-1/2 = I + B~ diag(((1 + lambda)^-1/2 - 1) / lambda) B~'.
  const Eigen::Index k = scaled_.cols();
  for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
    const Eigen::Index first = first_row_[static_cast<std::size_t>(b)];
    const Eigen::Index rows = first_row_[static_cast<std::size_t>(b) + 1] - first;
    const auto block = scaled_.middleRows(first, rows);
    Eigen::MatrixXd share = block.transpose() * X.middleRows(first, rows);
    for (Eigen::Index i = 0; i < k; ++i) {
      const double root = std::sqrt(1 + lambda_(b, i));
      share.row(i) *= -1.0 / (root * (1 + root));  // the same, also at lambda = 0
    }
    X.middleRows(first, rows).noalias() += block * share;
  }
  return X;
}

Eigen::MatrixXd Whitening::operator()(const Eigen::MatrixXd& X) const {
  return spread(root_.asDiagonal() * X);
}

Eigen::MatrixXd Whitening::transposed(const Eigen::MatrixXd& X) const {
  return root_.asDiagonal() * spread(X);
}

Eigen::MatrixXd Whitening::normal(
    const Eigen::MatrixXd& C, const std::vector<Eigen::Index>& rows) const {
  Eigen::MatrixXd weighted = C;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    weighted.row(static_cast<Eigen::Index>(i)) *= root_[rows[i]];
  }
  Eigen::MatrixXd result = weighted.transpose() * weighted;
  if (independent()) return result;
  std::size_t at = 0;
  for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
    Eigen::MatrixXd share = Eigen::MatrixXd::Zero(scaled_.cols(), C.cols());
    const std::size_t before = at;
    for (; at < rows.size() && rows[at] < first_row_[static_cast<std::size_t>(b) + 1]; ++at) {
      share.noalias() +=
          scaled_.row(rows[at]).transpose() * weighted.row(static_cast<Eigen::Index>(at));
    }
    if (at == before) continue;
    const Eigen::VectorXd less = (1 + lambda_.row(b).transpose().array()).inverse();
    result.noalias() -= share.transpose() * less.asDiagonal() * share;
  }
  return result;
}

Whitening::Shifts Whitening::shifts_of(const Eigen::VectorXd& residual_mm) const {
  Shifts result{Eigen::VectorXd::Zero(residual_mm.size()), 0.0};
  if (independent()) return result;
  const Eigen::Index k = scaled_.cols();
  Eigen::VectorXd v = along(root_.cwiseProduct(residual_mm));
  for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
    const Eigen::Index first = first_row_[static_cast<std::size_t>(b)];
    const Eigen::Index rows = first_row_[static_cast<std::size_t>(b) + 1] - first;
    for (Eigen::Index i = 0; i < k; ++i) v[b * k + i] /= 1 + lambda_(b, i);
    result.in_readings_mm.segment(first, rows) =
        scaled_.middleRows(first, rows) * v.segment(b * k, k);
  }
  result.squares = v.squaredNorm();
  // D was in B~: a reading that is not counted shares the shift, but nobody asks it.
  for (Eigen::Index row = 0; row < root_.size(); ++row) {
    result.in_readings_mm[row] = root_[row] > 0 ? result.in_readings_mm[row] / root_[row] : 0.0;
  }
  return result;
}

Eigen::VectorXd Whitening::leverage() const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(root_.size());
  for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
    const Eigen::VectorXd less = (1 + lambda_.row(b).transpose().array()).inverse();
    for (Eigen::Index row = first_row_[static_cast<std::size_t>(b)];
         row < first_row_[static_cast<std::size_t>(b) + 1]; ++row) {
      result[row] = scaled_.row(row).cwiseAbs2().dot(less.transpose());
    }
  }
  return result;
}

namespace {

/// Residual likelihood of a fit's left-over as a function of the ratio. Everything is projected
/// off the fitted columns once; a ratio then costs k numbers of each block.
class ResidualLikelihood {
 public:
  ResidualLikelihood(const LeftOver& left, const ScatterColumns& columns)
      : freedom_(left.freedom) {
    const Eigen::Index n = left.residual_mm.size();
    const Eigen::Index m = left.random.cols();
    Eigen::VectorXd e(n + m);
    e.head(n) = left.root.cwiseProduct(left.residual_mm);
    e.tail(m) = -left.u;
    const Eigen::MatrixXd Q = orthonormal_basis(
        left.root.asDiagonal() * left.fitted, left.root.asDiagonal() * left.random,
        Eigen::VectorXd::Ones(m));
    e -= Q * (Q.transpose() * e);
    squares_ = e.squaredNorm();
    fitted_ = Q.cols();
    Eigen::MatrixXd B = left.root.asDiagonal() * columns.columns;
    turn(B, columns.first_row, lambda_);
    const Eigen::Index k = B.cols();
    seen_.resize(lambda_.rows() * k, fitted_ + 1);
    for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
      const Eigen::Index first = columns.first_row[static_cast<std::size_t>(b)];
      const Eigen::Index rows = columns.first_row[static_cast<std::size_t>(b) + 1] - first;
      const auto block = B.middleRows(first, rows).transpose();
      seen_.block(b * k, 0, k, fitted_).noalias() = block * Q.middleRows(first, rows);
      seen_.block(b * k, fitted_, k, 1).noalias() = block * e.segment(first, rows);
    }
  }

  struct At {
    double value;  // log likelihood less that at ratio 0
    double s_mm;   // of a single reading
  };
  [[nodiscard]] At at(double ratio) const {
    const Eigen::Index k = lambda_.cols();
    Eigen::VectorXd share(seen_.rows());
    double volume = 0.0;
    for (Eigen::Index b = 0; b < lambda_.rows(); ++b) {
      for (Eigen::Index i = 0; i < k; ++i) {
        share[b * k + i] = ratio / (1 + ratio * lambda_(b, i));
        volume += std::log1p(ratio * lambda_(b, i));
      }
    }
    Eigen::MatrixXd normal = -gram(share.cwiseSqrt().asDiagonal() * seen_);
    normal.diagonal().head(fitted_).array() += 1.0;
    normal(fitted_, fitted_) += squares_;
    const Eigen::LLT<Eigen::MatrixXd> llt(normal.topLeftCorner(fitted_, fitted_));
    const Eigen::VectorXd cross = normal.topRightCorner(fitted_, 1);
    double squares = normal(fitted_, fitted_);
    double fitted_volume = 0.0;
    if (fitted_ > 0) {
      squares -= cross.dot(llt.solve(cross));
      fitted_volume = 2 * llt.matrixLLT().diagonal().array().log().sum();
    }
    squares = std::max(squares, 1e-12 * squares_);
    return {
        -0.5 * freedom_ * std::log(squares / squares_) - 0.5 * volume - 0.5 * fitted_volume,
        std::sqrt(squares / freedom_)};
  }
  [[nodiscard]] double mean_lambda() const { return lambda_.mean(); }

 private:
  double freedom_;
  double squares_ = 0.0;
  Eigen::Index fitted_ = 0;
  Eigen::MatrixXd lambda_;  // blocks x k, of D B
  Eigen::MatrixXd seen_;    // B'D of each block x (fitted basis, residual)
};

/// Where a function falls below `level`, between `inside` (above it) and `outside`.
template <typename Function>
double crossing(double inside, double outside, double level, Function&& value) {
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (value(middle) > level ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace

bool may_be_shared(const LeftOver& left, const ScatterColumns& columns) {
  // Score of the ratio at 0 over its standard deviation.
  constexpr double kWorthALook = 1.5;
  const Eigen::VectorXd e = left.root.cwiseProduct(left.residual_mm);
  const double variance = (e.squaredNorm() + left.u.squaredNorm()) / left.freedom;
  if (!(variance > 0)) return false;
  double score = 0.0;
  double information = 0.0;
  for (std::size_t b = 0; b < columns.blocks(); ++b) {
    const Eigen::Index first = columns.first_row[b];
    const Eigen::Index rows = columns.first_row[b + 1] - first;
    const Eigen::MatrixXd B =
        left.root.segment(first, rows).asDiagonal() * columns.columns.middleRows(first, rows);
    score +=
        (B.transpose() * e.segment(first, rows)).squaredNorm() / variance - B.squaredNorm();
    information += (B.transpose() * B).squaredNorm();
  }
  return score > kWorthALook * std::sqrt(2 * information);
}

std::optional<ScatterSize> scatter_size(
    const LeftOver& left, const ScatterColumns& columns, const ScatterQuestion& asked) {
  const ResidualLikelihood likelihood(left, columns);
  if (!(likelihood.mean_lambda() > 0)) return std::nullopt;
  // The search comes back to some ratios.
  std::vector<std::pair<double, ResidualLikelihood::At>> known;
  const auto at = [&](double log_ratio) {
    const auto found =
        std::ranges::find(known, log_ratio, [](const auto& each) { return each.first; });
    if (found != known.end()) return found->second;
    return known.emplace_back(log_ratio, likelihood.at(std::exp(log_ratio))).second;
  };
  const auto value = [&](double log_ratio) { return at(log_ratio).value; };
  // In logarithms: from a tenth of what is clearly visible up as long as it rises, or near what
  // a similar fit had.
  constexpr double kGrid = 1.2;
  constexpr int kMostSteps = 16;
  double best = std::log(asked.near > 0 ? asked.near : 0.02 / likelihood.mean_lambda());
  double most = value(best);
  if (!(asked.near > 0)) {
    const double low = best;
    int falls = 0;
    for (int i = 1; i < kMostSteps && falls < 3; ++i) {
      const double here = value(low + kGrid * i);
      falls = here > most ? 0 : falls + 1;
      if (here <= most) continue;
      best = low + kGrid * i;
      most = here;
    }
  }
  // Parabolas around it, each a third as wide as the one before.
  constexpr double kFinest = 0.1;
  for (double wide = kGrid; wide > kFinest; wide /= 3) {
    const double before = value(best - wide);
    const double here = value(best);
    const double after = value(best + wide);
    const double curvature = before - 2 * here + after;
    double step = after > before ? wide : -wide;
    if (curvature < 0)
      step = std::clamp(0.5 * wide * (before - after) / curvature, -wide, wide);
    best += step;
  }
  most = value(best);
  if (!(most > 0)) return std::nullopt;
  const auto sd = [&](double log_ratio) {
    return std::exp(0.5 * log_ratio) * at(log_ratio).s_mm;
  };
  ScatterSize size{std::exp(best), most, sd(best), 0.0, 0.0};
  if (!asked.with_interval) return size;
  constexpr double kHalfChi2_95 = 1.92;
  constexpr double kFar = 12.0;
  const double level = most - kHalfChi2_95;
  // Along the ridge of the best s for each ratio; s itself is known to 1 / sqrt(2 freedom).
  const double of_s = kHalfChi2_95 / left.freedom;
  const auto wider = [&](double bound) {
    const double ridge = std::log(bound / size.sd);
    return size.sd * std::exp(std::copysign(std::sqrt(ridge * ridge + of_s), ridge));
  };
  size.low = wider(sd(crossing(best, best - kFar, level, value)));
  size.high = wider(sd(crossing(best, best + kFar, level, value)));
  return size;
}

}  // namespace sixdial::diagnosis
