#include "calibration/column_products.h"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/column_products.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;

/// A tile of I x J products over rows [0, n) of columns that begin at a and b.
template <std::size_t I, std::size_t J>
HWY_INLINE HWY_ATTR void tile(
    std::size_t n, const double* a, std::size_t lda, const double* b, std::size_t ldb,
    double* out, std::size_t ldo) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  V sum[I][J];
  for (std::size_t i = 0; i < I; ++i) {
    for (std::size_t j = 0; j < J; ++j) sum[i][j] = hn::Zero(d);
  }
  std::size_t row = 0;
  for (; row + lanes <= n; row += lanes) {
    V left[I];
    for (std::size_t i = 0; i < I; ++i) left[i] = hn::LoadU(d, a + i * lda + row);
    for (std::size_t j = 0; j < J; ++j) {
      const V right = hn::LoadU(d, b + j * ldb + row);
      for (std::size_t i = 0; i < I; ++i) {
        sum[i][j] = hn::MulAdd(left[i], right, sum[i][j]);
      }
    }
  }
  for (std::size_t i = 0; i < I; ++i) {
    for (std::size_t j = 0; j < J; ++j) {
      double total = hn::GetLane(hn::SumOfLanes(d, sum[i][j]));
      for (std::size_t k = row; k < n; ++k) total += a[i * lda + k] * b[j * ldb + k];
      out[i + j * ldo] += total;
    }
  }
}

/// out += A'B, columns [from, to) of it. `half`: A is B, and only what lies on or below the
/// diagonal is wanted.
HWY_ATTR void products(
    std::size_t n, const double* A, std::size_t p, const double* B, std::size_t from,
    std::size_t to, double* out, bool half) {
  constexpr std::size_t kTile = 4;
  constexpr std::size_t kRows = 512;  // a tile's columns stay in the first cache
  for (std::size_t row = 0; row < n; row += kRows) {
    const std::size_t rows = std::min(kRows, n - row);
    for (std::size_t j = from; j < to; j += kTile) {
      const std::size_t begin = half ? j / kTile * kTile : 0;
      for (std::size_t i = begin; i < p; i += kTile) {
        const double* a = A + i * n + row;
        const double* b = B + j * n + row;
        double* here = out + i + j * p;
        if (i + kTile <= p && j + kTile <= to) {
          tile<4, 4>(rows, a, n, b, n, here, p);
          continue;
        }
        for (std::size_t k = 0; k < std::min(kTile, p - i); ++k) {
          for (std::size_t l = 0; l < std::min(kTile, to - j); ++l) {
            tile<1, 1>(rows, a + k * n, n, b + l * n, n, here + k + l * p, p);
          }
        }
      }
    }
  }
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "calibration/crew.h"

namespace sixdial::calibration {

HWY_EXPORT(products);

namespace {

std::size_t count(Eigen::Index number) { return static_cast<std::size_t>(number); }

/// A'B into `out`, large ones by the threads of this work's crew, some columns each.
void share(
    const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& out, bool half) {
  constexpr Eigen::Index kColumns = 16;  // a multiple of a tile's
  constexpr double kWorthSharing = 4e6;  // products: a quarter of a millisecond
  const bool large =
      static_cast<double>(A.rows()) * static_cast<double>(out.size()) > kWorthSharing;
  const Eigen::Index step = large ? kColumns : std::max<Eigen::Index>(1, B.cols());
  in_parallel(static_cast<int>((B.cols() + step - 1) / step), [&](int k) {
    const Eigen::Index from = k * step;
    const Eigen::Index to = std::min(from + step, B.cols());
    HWY_DYNAMIC_DISPATCH(products)
    (count(A.rows()), A.data(), count(A.cols()), B.data(), count(from), count(to), out.data(),
     half);
  });
}

}  // namespace

Eigen::MatrixXd column_products(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  share(A, B, result, false);
  return result;
}

Eigen::MatrixXd column_products(const Eigen::MatrixXd& A) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(A.cols(), A.cols());
  share(A, A, result, true);
  result.triangularView<Eigen::StrictlyUpper>() = result.transpose();
  return result;
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
