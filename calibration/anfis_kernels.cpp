#include "calibration/anfis_kernels.h"

#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/anfis_kernels.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kSamplePad>;
using V = hn::Vec<D>;
// Memberships below this make no difference and must not divide by zero.
constexpr double kLeastMembership = 1e-300;

HWY_INLINE HWY_ATTR std::ptrdiff_t lanes(D d) {
  return static_cast<std::ptrdiff_t>(hn::Lanes(d));
}

HWY_ATTR void memberships(
    MembershipKind kind, int functions, int padded, const double* x, const double* centre,
    const double* width, const double* slope, const MembershipArrays& out) {
  const D d;
  const V one = hn::Set(d, 1.0);
  const V least = hn::Set(d, kLeastMembership);
  for (std::ptrdiff_t a = 0; a < padded; a += lanes(d)) {
    const V xa = hn::LoadU(d, x + a);
    V sum = least;
    for (int k = 0; k < functions; ++k) {
      const std::ptrdiff_t at = k * static_cast<std::ptrdiff_t>(padded) + a;
      const V inverse = hn::Set(d, 1.0 / width[k]);
      const V z = hn::Mul(hn::Sub(xa, hn::Set(d, centre[k])), inverse);
      V mu;
      if (kind == MembershipKind::kGaussian) {
        const V z2 = hn::Mul(z, z);
        mu = hn::CallExp(d, hn::Neg(hn::Min(z2, hn::Set(d, 600.0))));
        const V twice = hn::Mul(hn::Add(z, z), inverse);
        hn::StoreU(twice, d, out.by_centre + at);
        hn::StoreU(hn::Mul(twice, z), d, out.by_width + at);
      } else {
        const V b2 = hn::Set(d, 2.0 * slope[k]);
        const V size = hn::Max(hn::Abs(z), hn::Set(d, 1e-30));
        const V log_size = hn::CallLog(d, size);
        const V power = hn::Min(hn::Mul(b2, log_size), hn::Set(d, 600.0));
        mu = hn::Div(one, hn::Add(one, hn::CallExp(d, power)));
        const V rest = hn::Sub(one, mu);
        const V by_width = hn::Mul(hn::Mul(b2, rest), inverse);
        hn::StoreU(hn::Div(by_width, hn::CopySign(size, z)), d, out.by_centre + at);
        hn::StoreU(by_width, d, out.by_width + at);
        hn::StoreU(hn::Mul(hn::Mul(hn::Set(d, -2.0), log_size), rest), d, out.by_slope + at);
      }
      hn::StoreU(mu, d, out.nu + at);
      sum = hn::Add(sum, mu);
    }
    const V scale = hn::Div(one, sum);
    for (int k = 0; k < functions; ++k) {
      double* nu = out.nu + k * static_cast<std::ptrdiff_t>(padded) + a;
      hn::StoreU(hn::Mul(hn::LoadU(d, nu), scale), d, nu);
    }
  }
}

HWY_ATTR void gram_dual(
    int inputs, int functions, int padded, const double* x, const double* nu, double* K) {
  const D d;
  const std::ptrdiff_t n = padded;
  for (std::ptrdiff_t b = 0; b < n; ++b) {
    for (std::ptrdiff_t a = b / kSamplePad * kSamplePad; a < n; a += lanes(d)) {
      V product = hn::Zero(d);
      for (int c = 0; c <= inputs; ++c) {
        product = hn::MulAdd(hn::LoadU(d, x + c * n + a), hn::Set(d, x[c * n + b]), product);
      }
      for (int i = 0; i < inputs; ++i) {
        V sum = hn::Zero(d);
        for (int k = 0; k < functions; ++k) {
          const double* at = nu + (i * functions + k) * n;
          sum = hn::MulAdd(hn::LoadU(d, at + a), hn::Set(d, at[b]), sum);
        }
        product = hn::Mul(product, sum);
      }
      hn::StoreU(product, d, K + b * n + a);
    }
  }
}

HWY_ATTR void gram_columns(int columns, int padded, const double* A, int ld, double* G) {
  const D d;
  const std::ptrdiff_t n = padded;
  for (int j = 0; j < columns; ++j) {
    const double* aj = A + j * n;
    int i = j;
    for (; i + 4 <= columns; i += 4) {
      V s0 = hn::Zero(d);
      V s1 = s0;
      V s2 = s0;
      V s3 = s0;
      const double* ai = A + i * n;
      for (std::ptrdiff_t a = 0; a < n; a += lanes(d)) {
        const V v = hn::LoadU(d, aj + a);
        s0 = hn::MulAdd(v, hn::LoadU(d, ai + a), s0);
        s1 = hn::MulAdd(v, hn::LoadU(d, ai + n + a), s1);
        s2 = hn::MulAdd(v, hn::LoadU(d, ai + 2 * n + a), s2);
        s3 = hn::MulAdd(v, hn::LoadU(d, ai + 3 * n + a), s3);
      }
      double* g = G + static_cast<std::ptrdiff_t>(j) * ld + i;
      g[0] = hn::GetLane(hn::SumOfLanes(d, s0));
      g[1] = hn::GetLane(hn::SumOfLanes(d, s1));
      g[2] = hn::GetLane(hn::SumOfLanes(d, s2));
      g[3] = hn::GetLane(hn::SumOfLanes(d, s3));
    }
    for (; i < columns; ++i) {
      V s = hn::Zero(d);
      for (std::ptrdiff_t a = 0; a < n; a += lanes(d)) {
        s = hn::MulAdd(hn::LoadU(d, aj + a), hn::LoadU(d, A + i * n + a), s);
      }
      G[static_cast<std::ptrdiff_t>(j) * ld + i] = hn::GetLane(hn::SumOfLanes(d, s));
    }
  }
}

/// Takes the first `done` columns of L off N vectors of rows, from `row` on, of C columns from
/// number j on.
template <std::size_t C, std::size_t N>
HWY_INLINE HWY_ATTR void take_off(
    double* K, std::size_t ld, std::size_t done, std::size_t j, std::size_t row) {
  const D d;
  const std::size_t step = hn::Lanes(d);
  V s[C][N];
  for (std::size_t c = 0; c < C; ++c) {
    const double* column = K + (j + c) * ld + row;
    for (std::size_t v = 0; v < N; ++v) s[c][v] = hn::LoadU(d, column + v * step);
  }
  for (std::size_t k = 0; k < done; ++k) {
    const double* left = K + k * ld;
    V own[N];
    for (std::size_t v = 0; v < N; ++v) own[v] = hn::LoadU(d, left + row + v * step);
    for (std::size_t c = 0; c < C; ++c) {
      const V factor = hn::Set(d, left[j + c]);
      for (std::size_t v = 0; v < N; ++v) s[c][v] = hn::NegMulAdd(factor, own[v], s[c][v]);
    }
  }
  for (std::size_t c = 0; c < C; ++c) {
    double* column = K + (j + c) * ld + row;
    for (std::size_t v = 0; v < N; ++v) hn::StoreU(s[c][v], d, column + v * step);
  }
}

/// K becomes its Cholesky factor. False if it is not positive definite. Rows go in stretches of
/// four vectors, four columns at a time, which reads L a quarter as often; the last few one by
/// one.
HWY_ATTR bool factorise(std::size_t n, std::size_t ld, double* K) {
  constexpr std::size_t kPanel = 4;
  const D d;
  const std::size_t step = hn::Lanes(d);
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t top = j / kSamplePad * kSamplePad;
    const std::size_t last = top + (ld - top) / (4 * step) * (4 * step);
    const std::size_t first = j / kPanel * kPanel;
    const bool whole = first + kPanel <= n;
    if (whole && j == first) {
      for (std::size_t row = top; row < last; row += 2 * step) {
        take_off<kPanel, 2>(K, ld, first, first, row);
      }
    }
    double* column = K + j * ld;
    for (std::size_t k = whole ? first : 0; k < j; ++k) {
      const double* left = K + k * ld;
      const V factor = hn::Set(d, left[j]);
      for (std::size_t row = top; row < last; row += step) {
        const V rest = hn::LoadU(d, column + row);
        hn::StoreU(hn::NegMulAdd(factor, hn::LoadU(d, left + row), rest), d, column + row);
      }
    }
    for (std::size_t row = last; row < ld; row += step) {
      V even = hn::LoadU(d, column + row);
      V odd = hn::Zero(d);
      std::size_t k = 0;
      for (; k + 2 <= j; k += 2) {
        const double* left = K + k * ld;
        even = hn::NegMulAdd(hn::Set(d, left[j]), hn::LoadU(d, left + row), even);
        odd = hn::NegMulAdd(hn::Set(d, left[ld + j]), hn::LoadU(d, left + ld + row), odd);
      }
      if (k < j) {
        const double* left = K + k * ld;
        even = hn::NegMulAdd(hn::Set(d, left[j]), hn::LoadU(d, left + row), even);
      }
      hn::StoreU(hn::Add(even, odd), d, column + row);
    }
    if (!(column[j] > 0.0)) return false;
    const V scale = hn::Set(d, 1.0 / std::sqrt(column[j]));
    for (std::size_t row = top; row < ld; row += step) {
      hn::StoreU(hn::Mul(hn::LoadU(d, column + row), scale), d, column + row);
    }
    for (std::size_t row = top; row < j; ++row) column[row] = 0.0;
    for (std::size_t row = n; row < ld; ++row) column[row] = 0.0;
  }
  return true;
}

HWY_ATTR bool cholesky(int size, int leading, double* K, double* b) {
  const D d;
  const std::ptrdiff_t n = size;
  const std::ptrdiff_t ld = leading;
  const std::ptrdiff_t step = lanes(d);
  if (!factorise(static_cast<std::size_t>(n), static_cast<std::size_t>(ld), K)) return false;
  for (std::ptrdiff_t j = 0; j < n; ++j) {  // L y = b
    const double* column = K + j * ld;
    const double y = b[j] / column[j];
    const V factor = hn::Set(d, y);
    for (std::ptrdiff_t row = j / kSamplePad * kSamplePad; row < ld; row += step) {
      hn::StoreU(
          hn::NegMulAdd(factor, hn::LoadU(d, column + row), hn::LoadU(d, b + row)), d, b + row);
    }
    b[j] = y;
  }
  for (std::ptrdiff_t row = n; row < ld; ++row) b[row] = 0.0;
  for (std::ptrdiff_t j = n - 1; j >= 0; --j) {  // L' z = y
    const double* column = K + j * ld;
    const double y = b[j];
    b[j] = 0.0;
    V sum = hn::Zero(d);
    for (std::ptrdiff_t row = j / kSamplePad * kSamplePad; row < ld; row += step) {
      sum = hn::MulAdd(hn::LoadU(d, column + row), hn::LoadU(d, b + row), sum);
    }
    b[j] = (y - hn::GetLane(hn::SumOfLanes(d, sum))) / column[j];
  }
  return std::isfinite(b[0]);
}

HWY_ATTR void rules(int inputs, int functions, int padded, const double* nu, double* w) {
  const D d;
  const std::ptrdiff_t n = padded;
  // Rule r = k0 + functions * k1 + ...: start from input 0, multiply in one input at a time.
  for (int k = 0; k < functions; ++k) {
    for (std::ptrdiff_t a = 0; a < n; a += lanes(d)) {
      hn::StoreU(hn::LoadU(d, nu + k * n + a), d, w + k * n + a);
    }
  }
  std::ptrdiff_t size = functions;
  for (int i = 1; i < inputs; ++i) {
    for (int k = functions - 1; k >= 0; --k) {  // block 0 last: it is overwritten in place
      const double* factor = nu + (i * functions + k) * n;
      for (std::ptrdiff_t r = 0; r < size; ++r) {
        for (std::ptrdiff_t a = 0; a < n; a += lanes(d)) {
          hn::StoreU(
              hn::Mul(hn::LoadU(d, w + r * n + a), hn::LoadU(d, factor + a)), d,
              w + (k * size + r) * n + a);
        }
      }
    }
    size *= functions;
  }
}

HWY_ATTR double dot_of_three(int padded, const double* a, const double* b, const double* c) {
  const D d;
  V sum = hn::Zero(d);
  for (std::ptrdiff_t k = 0; k < padded; k += lanes(d)) {
    sum =
        hn::MulAdd(hn::Mul(hn::LoadU(d, a + k), hn::LoadU(d, b + k)), hn::LoadU(d, c + k), sum);
  }
  return hn::GetLane(hn::SumOfLanes(d, sum));
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(memberships);
HWY_EXPORT(gram_dual);
HWY_EXPORT(gram_columns);
HWY_EXPORT(cholesky);
HWY_EXPORT(rules);
HWY_EXPORT(dot_of_three);

void anfis_memberships(
    MembershipKind kind, int functions, int padded, const double* x, const double* centre,
    const double* width, const double* slope, const MembershipArrays& out) {
  HWY_DYNAMIC_DISPATCH(memberships)(kind, functions, padded, x, centre, width, slope, out);
}
void anfis_gram_dual(
    int inputs, int functions, int padded, const double* x, const double* nu, double* K) {
  HWY_DYNAMIC_DISPATCH(gram_dual)(inputs, functions, padded, x, nu, K);
}
void gram_primal(int columns, int padded, const double* A, int ld, double* G) {
  HWY_DYNAMIC_DISPATCH(gram_columns)(columns, padded, A, ld, G);
}
bool cholesky_solve(int n, int ld, double* K, double* b) {
  return HWY_DYNAMIC_DISPATCH(cholesky)(n, ld, K, b);
}
void anfis_rules(int inputs, int functions, int padded, const double* nu, double* w) {
  HWY_DYNAMIC_DISPATCH(rules)(inputs, functions, padded, nu, w);
}
double dot3(int padded, const double* a, const double* b, const double* c) {
  return HWY_DYNAMIC_DISPATCH(dot_of_three)(padded, a, b, c);
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
