// The five-bar for as many cases at a time as the vector unit is wide, equations (1)-(7), (13):
// eight robots at one sample (swarm_kernels.cpp) or one robot at eight samples
// (position_kernel.cpp). Compiled once for each vector unit; include it after highway.h.
// geometry/robots/five_bar.h is the reference that tests hold it against.
#if defined(SIXDIAL_FIVE_BAR_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIXDIAL_FIVE_BAR_LANES_INL_H_
#undef SIXDIAL_FIVE_BAR_LANES_INL_H_
#else
#define SIXDIAL_FIVE_BAR_LANES_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "calibration/lanes.h"
#include "geometry/robots/five_bar.h"

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

/// The parameters of the lanes in the form the forward kinematics needs.
struct LaneRobot {
  V ca, sa;              // frame B in W
  V c1, s1, c2, s2;      // offsets
  V l11, l12, l21, l22;  // links
  V half_d, x0, y0;
  V g, four_la2;  // l12^2 - l22^2, 4 l12^2
  V least;        // 16 sigma^2 at kSingularSine
  M usable;
};

template <class Get>
HWY_INLINE HWY_ATTR LaneRobot robot_of(D d, const Get& get) {
  LaneRobot r;
  r.l11 = get(geometry::kL11);
  r.l12 = get(geometry::kL12);
  r.l21 = get(geometry::kL21);
  r.l22 = get(geometry::kL22);
  const V base = get(geometry::kD);
  r.half_d = hn::Mul(base, hn::Set(d, 0.5));
  r.x0 = get(geometry::kX0);
  r.y0 = get(geometry::kY0);
  const V alpha = get(geometry::kAlpha);
  const V t1 = get(geometry::kOffset1);
  const V t2 = get(geometry::kOffset2);
  r.ca = hn::CallCos(d, alpha);
  r.sa = hn::CallSin(d, alpha);
  r.c1 = hn::CallCos(d, t1);
  r.s1 = hn::CallSin(d, t1);
  r.c2 = hn::CallCos(d, t2);
  r.s2 = hn::CallSin(d, t2);
  r.g = hn::Mul(hn::Sub(r.l12, r.l22), hn::Add(r.l12, r.l22));
  const V la2 = hn::Mul(r.l12, r.l12);
  r.four_la2 = hn::Mul(hn::Set(d, 4.0), la2);
  const V product = hn::Mul(r.l12, r.l22);
  // 2 sigma >= kSingularSine l12 l22, as geometry::forward refuses
  r.least = hn::Mul(
      hn::Set(d, 4 * geometry::kSingularSine * geometry::kSingularSine),
      hn::Mul(product, product));
  const V zero = hn::Zero(d);
  // The trigonometric functions hold for angles of ordinary size only.
  const V turn = hn::Set(d, 1e4);
  const M angles = hn::And(
      hn::And(hn::Lt(hn::Abs(alpha), turn), hn::Lt(hn::Abs(t1), turn)),
      hn::Lt(hn::Abs(t2), turn));
  r.usable = hn::And(
      hn::And(
          hn::And(hn::Gt(r.l11, zero), hn::Gt(r.l12, zero)),
          hn::And(hn::Gt(r.l21, zero), hn::Gt(r.l22, zero))),
      angles);
  return r;
}

struct ToolLanes {
  V ux, uy, wx, wy;      // O3 -> E and O4 -> E in B
  V a1c, a1s, a2c, a2s;  // cos and sin of theta + offset
  V x, y;                // E in W, without x0, y0
};

/// c1 .. s2: cosine and sine of the encoder angles.
HWY_INLINE HWY_ATTR ToolLanes
tool_of(D d, const LaneRobot& r, V c1, V s1, V c2, V s2, V beta, M& reached) {
  ToolLanes t;
  t.a1c = hn::NegMulAdd(r.s1, s1, hn::Mul(r.c1, c1));
  t.a1s = hn::MulAdd(r.c1, s1, hn::Mul(r.s1, c1));
  t.a2c = hn::NegMulAdd(r.s2, s2, hn::Mul(r.c2, c2));
  t.a2s = hn::MulAdd(r.c2, s2, hn::Mul(r.s2, c2));
  const V x3 = hn::MulSub(r.l11, t.a1c, r.half_d);  // (4)
  const V y3 = hn::Mul(r.l11, t.a1s);
  const V dx = hn::Sub(hn::MulAdd(r.l21, t.a2c, r.half_d), x3);  // (5)
  const V dy = hn::MulSub(r.l21, t.a2s, y3);
  const V D2 = hn::MulAdd(dx, dx, hn::Mul(dy, dy));  // (6)
  const V q = hn::Add(D2, r.g);
  const V w = hn::NegMulAdd(q, q, hn::Mul(r.four_la2, D2));  // 16 sigma^2 (7)
  reached = hn::And(reached, hn::Ge(w, r.least));            // false for NaN too
  const V half_inverse = hn::Div(hn::Set(d, 0.5), D2);
  const V k2 = hn::Mul(beta, hn::Mul(hn::Sqrt(hn::Max(w, hn::Zero(d))), half_inverse));
  const V k1 = hn::MulAdd(r.g, half_inverse, hn::Set(d, 0.5));
  t.ux = hn::NegMulAdd(k2, dy, hn::Mul(k1, dx));  // (3)
  t.uy = hn::MulAdd(k2, dx, hn::Mul(k1, dy));
  t.wx = hn::Sub(t.ux, dx);
  t.wy = hn::Sub(t.uy, dy);
  const V xe = hn::Add(x3, t.ux);
  const V ye = hn::Add(y3, t.uy);
  t.x = hn::NegMulAdd(r.sa, ye, hn::Mul(r.ca, xe));  // (1)
  t.y = hn::MulAdd(r.sa, xe, hn::Mul(r.ca, ye));
  return t;
}

/// Equation (13): put(parameter, dx, dy) for each of the ten.
template <class Put>
HWY_INLINE HWY_ATTR void jacobian_of(
    D d, const LaneRobot& r, const ToolLanes& t, const Put& put) {
  // u'(dE - dO3) = l12 dl12, w'(dE - dO4) = l22 dl22, turned into W: dE = A p + B q
  const V inverse = hn::Div(hn::Set(d, 1.0), hn::NegMulAdd(t.uy, t.wx, hn::Mul(t.ux, t.wy)));
  const V ax = hn::Mul(hn::MulAdd(r.ca, t.wy, hn::Mul(r.sa, t.wx)), inverse);
  const V ay = hn::Mul(hn::NegMulAdd(r.ca, t.wx, hn::Mul(r.sa, t.wy)), inverse);
  const V bx = hn::Neg(hn::Mul(hn::MulAdd(r.ca, t.uy, hn::Mul(r.sa, t.ux)), inverse));
  const V by = hn::Mul(hn::NegMulAdd(r.sa, t.uy, hn::Mul(r.ca, t.ux)), inverse);
  const V turn1 = hn::MulAdd(t.ux, t.a1c, hn::Mul(t.uy, t.a1s));
  put(geometry::kL11, hn::Mul(ax, turn1), hn::Mul(ay, turn1));
  put(geometry::kL12, hn::Mul(ax, r.l12), hn::Mul(ay, r.l12));
  const V q2 = hn::MulAdd(t.wx, t.a2c, hn::Mul(t.wy, t.a2s));
  put(geometry::kL21, hn::Mul(bx, q2), hn::Mul(by, q2));
  put(geometry::kL22, hn::Mul(bx, r.l22), hn::Mul(by, r.l22));
  const V half = hn::Set(d, 0.5);
  put(geometry::kD, hn::Mul(half, hn::NegMulAdd(ax, t.ux, hn::Mul(bx, t.wx))),
      hn::Mul(half, hn::NegMulAdd(ay, t.ux, hn::Mul(by, t.wx))));
  const V one = hn::Set(d, 1.0);
  const V zero = hn::Zero(d);
  put(geometry::kX0, one, zero);
  put(geometry::kY0, zero, one);
  put(geometry::kAlpha, hn::Neg(t.y), t.x);
  const V p8 = hn::Mul(r.l11, hn::NegMulAdd(t.ux, t.a1s, hn::Mul(t.uy, t.a1c)));
  put(geometry::kOffset1, hn::Mul(ax, p8), hn::Mul(ay, p8));
  const V q9 = hn::Mul(r.l21, hn::NegMulAdd(t.wx, t.a2s, hn::Mul(t.wy, t.a2c)));
  put(geometry::kOffset2, hn::Mul(bx, q9), hn::Mul(by, q9));
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // SIXDIAL_FIVE_BAR_LANES_INL_H_
