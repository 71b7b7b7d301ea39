#include "geometry/registration.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kDraws = 400;          // of a few points, one draw free of gross ones is needed
constexpr Index kMostScored = 2000;  // points that judge a draw
constexpr int kRounds = 30;
constexpr double kStandsOut = 3.5;  // robust standard deviations
constexpr double kToSigma = 1.4826;
constexpr double kRounding = 1e-12;  // of the points' extent
constexpr double kFlat = 1e-5;       // a spread this much smaller than the largest is none

/// Repeatable draws without any state to carry (splitmix64).
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

MatrixXd chosen(const MatrixXd& of, const std::vector<Index>& columns) {
  return of(Eigen::all, columns);
}

/// Directions in which points spread.
Index rank_of(const MatrixXd& points) {
  const MatrixXd centred = points.colwise() - points.rowwise().mean();
  const VectorXd s = Eigen::JacobiSVD<MatrixXd>(centred * centred.transpose()).singularValues();
  if (!(s[0] > 0.0)) return 0;
  return (s.array() > kFlat * kFlat * s[0]).count();
}

/// Umeyama (1991) over all columns.
Similarity closed_form(const MatrixXd& from, const MatrixXd& to, RegistrationChoice choice) {
  const Index axes = from.rows();
  const VectorXd from_mean = from.rowwise().mean();
  const VectorXd to_mean = to.rowwise().mean();
  const MatrixXd a = from.colwise() - from_mean;
  const MatrixXd b = to.colwise() - to_mean;
  const Eigen::JacobiSVD<MatrixXd> svd(
      b * a.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  VectorXd sign = VectorXd::Ones(axes);
  const double handed = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  if (handed < 0.0 && !choice.may_mirror) sign[axes - 1] = -1.0;
  Similarity X{svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose(), {}, 1.0};
  const double spread = a.squaredNorm();
  if (choice.may_scale && spread > 0.0) X.scale = svd.singularValues().dot(sign) / spread;
  X.t = to_mean - X.scale * (X.R * from_mean);
  return X;
}

double extent_of(const MatrixXd& points) {
  return (points.colwise() - points.rowwise().mean()).colwise().norm().maxCoeff() +
         points.colwise().norm().maxCoeff();
}

/// `count` different points of n, the same for the same draw.
std::vector<Index> drawn(int draw, Index count, Index n) {
  std::vector<Index> result;
  for (std::uint64_t k = 0; std::ssize(result) < count; ++k) {
    const auto of = static_cast<Index>(
        mixed(mixed(static_cast<std::uint64_t>(draw)) + k) % static_cast<std::uint64_t>(n));
    if (std::ranges::find(result, of) == result.end()) result.push_back(of);
  }
  return result;
}

/// Of draws of a few points the one that half of all points agree with best (Rousseeuw 1984).
Similarity agreed(const MatrixXd& from, const MatrixXd& to, RegistrationChoice choice) {
  const Index n = from.cols();
  const Index few = from.rows() + 1;
  Similarity best = closed_form(from, to, choice);
  if (n <= few) return best;
  std::vector<Index> judges;
  const Index every = std::max<Index>(1, n / kMostScored);
  for (Index i = 0; i < n; i += every) judges.push_back(i);
  const MatrixXd from_judge = chosen(from, judges);
  const MatrixXd to_judge = chosen(to, judges);
  const auto miss = [&](const Similarity& X) {
    const VectorXd d = distances(X, from_judge, to_judge);
    return median_of({d.begin(), d.end()});
  };
  double least = miss(best);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<Index> of = drawn(draw, few, n);
    const Similarity X = closed_form(chosen(from, of), chosen(to, of), choice);
    const double here = miss(X);
    if (!(here < least)) continue;
    least = here;
    best = X;
  }
  return best;
}

}  // namespace

Similarity Similarity::identity(Index axes) {
  return {MatrixXd::Identity(axes, axes), VectorXd::Zero(axes), 1.0};
}

Similarity Similarity::inverse() const {
  return {R.transpose(), -(R.transpose() * t) / scale, 1.0 / scale};
}

bool Similarity::mirrored() const { return R.determinant() < 0.0; }

double Similarity::turn_rad() const {
  MatrixXd turn = R;
  if (mirrored()) turn.col(turn.cols() - 1) *= -1.0;
  if (turn.rows() == 2) return std::atan2(turn(1, 0), turn(0, 0));
  // Of a small turn the sine keeps the digits that the cosine loses.
  const MatrixXd skew = turn - turn.transpose();
  return std::atan2(skew.norm() / (2.0 * std::sqrt(2.0)), (turn.trace() - 1.0) / 2.0);
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

VectorXd distances(const Similarity& X, const MatrixXd& from, const MatrixXd& to) {
  return (to - ((X.scale * X.R * from).colwise() + X.t)).colwise().norm().transpose();
}

std::optional<Registration> register_points(
    const MatrixXd& from, const MatrixXd& to, const RegistrationChoice& choice) {
  const Index axes = from.rows();
  const Index n = from.cols();
  if (n < 2 || to.rows() != axes || to.cols() != n) return std::nullopt;
  const Index rank = std::min(rank_of(from), rank_of(to));
  if (rank < axes - 1) return std::nullopt;
  RegistrationChoice allowed = choice;
  allowed.may_mirror = choice.may_mirror && rank == axes;

  Registration found{agreed(from, to, allowed), std::vector<bool>(static_cast<std::size_t>(n))};
  found.mirror_known = rank == axes;
  const double least = kRounding * extent_of(to);
  for (int round = 0; round < kRounds; ++round) {
    const VectorXd d = distances(found.X, from, to);
    found.median = median_of({d.begin(), d.end()});
    // Of distances in several axes the median is larger than that of one axis.
    const double small_n = 1.0 + 5.0 / static_cast<double>(std::max<Index>(n - axes, 1));
    const double limit = std::max(kStandsOut * kToSigma * small_n * found.median, least);
    std::vector<Index> good;
    std::vector<bool> fits(static_cast<std::size_t>(n));
    for (Index i = 0; i < n; ++i) {
      if (d[i] > limit) continue;
      good.push_back(i);
      fits[static_cast<std::size_t>(i)] = true;
    }
    found.rms = std::sqrt(d(good).squaredNorm() / static_cast<double>(good.size()));
    const bool same = fits == found.fits;
    found.fits = std::move(fits);
    if (same || rank_of(chosen(from, good)) < axes - 1) break;
    found.X = closed_form(chosen(from, good), chosen(to, good), allowed);
  }
  return found;
}

}  // namespace sixdial::geometry
