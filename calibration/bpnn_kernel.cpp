#include "calibration/bpnn_kernel.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/bpnn_kernel.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

HWY_INLINE HWY_ATTR V tanh_of(D d, V z) {
  // 1 - 2 / (exp(2 z) + 1)
  const V twice = hn::Min(hn::Max(hn::Add(z, z), hn::Set(d, -80.0)), hn::Set(d, 80.0));
  const V e = hn::CallExp(d, twice);
  const V one = hn::Set(d, 1.0);
  return hn::Sub(one, hn::Div(hn::Set(d, 2.0), hn::Add(e, one)));
}

HWY_INLINE HWY_ATTR double total(D d, V v) { return hn::GetLane(hn::SumOfLanes(d, v)); }

HWY_ATTR double error(
    int hidden, int padded, const double* x1, const double* x2, const double* yx,
    const double* yy, const double* use, const double* weights, double* gradient,
    double* scratch) {
  const D d;
  const auto step = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  const std::ptrdiff_t n = padded;
  double* ex = scratch;
  double* ey = scratch + n;
  double* activation = scratch + 2 * n;  // hidden x n
  const double* bias = weights + static_cast<std::ptrdiff_t>(hidden) * 5;
  V squares = hn::Zero(d);
  V sum_x = squares;
  V sum_y = squares;
  for (std::ptrdiff_t a = 0; a < n; a += step) {
    const V u = hn::LoadU(d, x1 + a);
    const V v = hn::LoadU(d, x2 + a);
    V ox = hn::Set(d, bias[0]);
    V oy = hn::Set(d, bias[1]);
    for (std::ptrdiff_t h = 0; h < hidden; ++h) {
      const double* w = weights + h * 5;
      const V z =
          hn::MulAdd(hn::Set(d, w[0]), u, hn::MulAdd(hn::Set(d, w[1]), v, hn::Set(d, w[2])));
      const V t = tanh_of(d, z);
      hn::StoreU(t, d, activation + h * n + a);
      ox = hn::MulAdd(hn::Set(d, w[3]), t, ox);
      oy = hn::MulAdd(hn::Set(d, w[4]), t, oy);
    }
    const V used = hn::LoadU(d, use + a);
    const V dx = hn::Mul(hn::Sub(ox, hn::LoadU(d, yx + a)), used);
    const V dy = hn::Mul(hn::Sub(oy, hn::LoadU(d, yy + a)), used);
    hn::StoreU(dx, d, ex + a);
    hn::StoreU(dy, d, ey + a);
    squares = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, squares));
    sum_x = hn::Add(sum_x, dx);
    sum_y = hn::Add(sum_y, dy);
  }
  if (gradient == nullptr) return total(d, squares);
  for (std::ptrdiff_t h = 0; h < hidden; ++h) {
    const double* w = weights + h * 5;
    V g[5] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    const V wx = hn::Set(d, w[3]);
    const V wy = hn::Set(d, w[4]);
    const V one = hn::Set(d, 1.0);
    for (std::ptrdiff_t a = 0; a < n; a += step) {
      const V t = hn::LoadU(d, activation + h * n + a);
      const V dx = hn::LoadU(d, ex + a);
      const V dy = hn::LoadU(d, ey + a);
      const V back = hn::Mul(hn::MulAdd(wx, dx, hn::Mul(wy, dy)), hn::NegMulAdd(t, t, one));
      g[0] = hn::MulAdd(back, hn::LoadU(d, x1 + a), g[0]);
      g[1] = hn::MulAdd(back, hn::LoadU(d, x2 + a), g[1]);
      g[2] = hn::Add(back, g[2]);
      g[3] = hn::MulAdd(t, dx, g[3]);
      g[4] = hn::MulAdd(t, dy, g[4]);
    }
    for (int k = 0; k < 5; ++k) gradient[h * 5 + k] = 2.0 * total(d, g[k]);
  }
  gradient[static_cast<std::ptrdiff_t>(hidden) * 5] = 2.0 * total(d, sum_x);
  gradient[static_cast<std::ptrdiff_t>(hidden) * 5 + 1] = 2.0 * total(d, sum_y);
  return total(d, squares);
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(error);

double bpnn_error(
    int hidden, int padded, const double* x1, const double* x2, const double* yx,
    const double* yy, const double* use, const double* weights, double* gradient,
    double* scratch) {
  return HWY_DYNAMIC_DISPATCH(error)(
      hidden, padded, x1, x2, yx, yy, use, weights, gradient, scratch);
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
