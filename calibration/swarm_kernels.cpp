#include "calibration/swarm_kernels.h"

#include <cmath>

// Highway compiles what lies between its marks once for every vector unit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/swarm_kernels.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr int kN = geometry::kParameterCount;

constexpr int at(int i, int j) {
  return (i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i) * kLanes;
}

/// The parameters of the lanes in the form the forward kinematics needs.
struct Robot {
  V ca, sa;              // frame B in W
  V c1, s1, c2, s2;      // offsets
  V l11, l12, l21, l22;  // links
  V half_d, x0, y0;
  V g, four_la2;  // l12^2 - l22^2, 4 l12^2
  V least;        // 16 sigma^2 at kSingularSine
  M usable;
};

template <class Get>
HWY_INLINE HWY_ATTR Robot robot_of(D d, const Get& get) {
  Robot r;
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
      hn::And(hn::Ge(base, zero), angles));
  return r;
}

struct Tool {
  V ux, uy, wx, wy;      // O3 -> E and O4 -> E in B
  V a1c, a1s, a2c, a2s;  // cos and sin of theta + offset
  V x, y;                // E in W, without x0, y0
};

HWY_INLINE HWY_ATTR Tool tool_of(D d, const Robot& r, const SwarmPoint& p, M& reached) {
  Tool t;
  const V c1 = hn::Set(d, p.cos1);
  const V s1 = hn::Set(d, p.sin1);
  const V c2 = hn::Set(d, p.cos2);
  const V s2 = hn::Set(d, p.sin2);
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
  const V k2 =
      hn::Mul(hn::Set(d, p.beta), hn::Mul(hn::Sqrt(hn::Max(w, hn::Zero(d))), half_inverse));
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

HWY_ATTR void rmse(const SwarmTable& table, const double* v, double* out) {
  const D d;
  const auto step = hn::Lanes(d);
  for (std::size_t lane = 0; lane < kLanes; lane += step) {
    const Robot r =
        robot_of(d, [&](int i) HWY_ATTR { return hn::LoadU(d, v + i * kLanes + lane); });
    M reached = r.usable;
    V sum = hn::Zero(d);
    for (const SwarmPoint& p : table.points) {
      const Tool t = tool_of(d, r, p, reached);
      const V ex = hn::Sub(hn::Sub(hn::Set(d, p.x_mm), r.x0), t.x);
      const V ey = hn::Sub(hn::Sub(hn::Set(d, p.y_mm), r.y0), t.y);
      sum = hn::MulAdd(ex, ex, hn::MulAdd(ey, ey, sum));
    }
    const auto n = static_cast<double>(table.points.size());
    const V infinite = hn::Set(d, HUGE_VAL);
    const M finite = hn::And(reached, hn::Lt(sum, infinite));
    hn::StoreU(
        hn::IfThenElse(finite, hn::Sqrt(hn::Div(sum, hn::Set(d, n))), infinite), d, out + lane);
  }
}

/// Equations (20)-(22) for one sample: g, f are the two rows of J; e1, e2 the innovation.
template <class RowG, class RowF>
HWY_INLINE HWY_ATTR void update(
    D d, double* HWY_RESTRICT P, double* HWY_RESTRICT x, const RowG& g, const RowF& f, V r1,
    V r2, V e1, V e2) {
  HWY_ALIGN double a[kN * kLanes];
  HWY_ALIGN double b[kN * kLanes];
  V s11 = r1;
  V s12 = hn::Zero(d);
  V s22 = r2;
#pragma GCC unroll 10
  for (int i = 0; i < kN; ++i) {
    V u = hn::Zero(d);
    V w = hn::Zero(d);
#pragma GCC unroll 10
    for (int j = 0; j < kN; ++j) {
      const V p = hn::Load(d, P + at(i, j));
      u = hn::MulAdd(p, g(j), u);
      w = hn::MulAdd(p, f(j), w);
    }
    hn::Store(u, d, a + i * kLanes);
    hn::Store(w, d, b + i * kLanes);
    s11 = hn::MulAdd(u, g(i), s11);
    s12 = hn::MulAdd(w, g(i), s12);
    s22 = hn::MulAdd(w, f(i), s22);
  }
  const V z = hn::Div(hn::Set(d, 1.0), hn::NegMulAdd(s12, s12, hn::Mul(s11, s22)));
  const V z11 = hn::Mul(s22, z);
  const V z12 = hn::Neg(hn::Mul(s12, z));
  const V z22 = hn::Mul(s11, z);
#pragma GCC unroll 10
  for (int i = 0; i < kN; ++i) {
    const V ai = hn::Load(d, a + i * kLanes);
    const V bi = hn::Load(d, b + i * kLanes);
    const V k1 = hn::MulAdd(ai, z11, hn::Mul(bi, z12));
    const V k2 = hn::MulAdd(ai, z12, hn::Mul(bi, z22));
    double* xi = x + i * kLanes;
    hn::Store(hn::MulAdd(k1, e1, hn::MulAdd(k2, e2, hn::Load(d, xi))), d, xi);
#pragma GCC unroll 10
    for (int j = 0; j <= i; ++j) {
      double* p = P + at(i, j);
      const V lower = hn::NegMulAdd(k1, hn::Load(d, a + j * kLanes), hn::Load(d, p));
      hn::Store(hn::NegMulAdd(k2, hn::Load(d, b + j * kLanes), lower), d, p);
    }
  }
}

HWY_INLINE HWY_ATTR void start(D d, const double* p0, double* P, double* x) {
  for (int i = 0; i < kN; ++i) {
    for (int j = 0; j < i; ++j) hn::Store(hn::Zero(d), d, P + at(i, j));
    hn::Store(hn::Set(d, p0[i]), d, P + at(i, i));
    hn::Store(hn::Zero(d), d, x + i * kLanes);
  }
}

HWY_INLINE HWY_ATTR void predict(D d, const double* noise, double* P) {
#pragma GCC unroll 10
  for (int i = 0; i < kN; ++i) {
    double* p = P + at(i, i);
    hn::Store(hn::Add(hn::Load(d, p), hn::LoadU(d, noise + i * kLanes)), d, p);
  }
}

HWY_ATTR void filter_nominal(
    const SwarmTable& table, const double* p0, const double* noise, double* out) {
  const D d;
  const auto step = hn::Lanes(d);
  HWY_ALIGN double P[55 * kLanes];
  HWY_ALIGN double x[kN * kLanes];
  for (std::size_t lane = 0; lane < kLanes; lane += step) {
    start(d, p0, P, x);
    const V r1 = hn::LoadU(d, noise + 10 * kLanes + lane);
    const V r2 = hn::LoadU(d, noise + 11 * kLanes + lane);
    for (const SwarmTable::Linear& sample : table.linear) {
      predict(d, noise + lane, P);
      const auto g = [&](int j) HWY_ATTR { return hn::Set(d, sample.row[0][j]); };
      const auto f = [&](int j) HWY_ATTR { return hn::Set(d, sample.row[1][j]); };
      V e1 = hn::Set(d, sample.error_mm[0]);
      V e2 = hn::Set(d, sample.error_mm[1]);
#pragma GCC unroll 10
      for (int i = 0; i < kN; ++i) {
        const V xi = hn::Load(d, x + i * kLanes);
        e1 = hn::NegMulAdd(g(i), xi, e1);
        e2 = hn::NegMulAdd(f(i), xi, e2);
      }
      update(d, P, x, g, f, r1, r2, e1, e2);
    }
    for (int i = 0; i < kN; ++i) {
      hn::StoreU(hn::Load(d, x + i * kLanes), d, out + i * kLanes + lane);
    }
  }
}

HWY_ATTR void filter_estimate(
    const SwarmTable& table, const double* p0, const double* noise, double* out) {
  const D d;
  const auto step = hn::Lanes(d);
  HWY_ALIGN double P[55 * kLanes];
  HWY_ALIGN double x[kN * kLanes];
  HWY_ALIGN double G[kN * kLanes];
  HWY_ALIGN double F[kN * kLanes];
  const double* nominal = table.nominal.data();
  for (std::size_t lane = 0; lane < kLanes; lane += step) {
    start(d, p0, P, x);
    const V r1 = hn::LoadU(d, noise + 10 * kLanes + lane);
    const V r2 = hn::LoadU(d, noise + 11 * kLanes + lane);
    M reached = hn::Eq(hn::Zero(d), hn::Zero(d));
    for (const SwarmPoint& p : table.points) {
      predict(d, noise + lane, P);
      const Robot r = robot_of(d, [&](int i) HWY_ATTR {
        return hn::Add(hn::Set(d, nominal[i]), hn::Load(d, x + i * kLanes));
      });
      reached = hn::And(reached, r.usable);
      const Tool t = tool_of(d, r, p, reached);
      // u'(dE - dO3) = l12 dl12, w'(dE - dO4) = l22 dl22, turned into W: dE = A p + B q
      const V inverse =
          hn::Div(hn::Set(d, 1.0), hn::NegMulAdd(t.uy, t.wx, hn::Mul(t.ux, t.wy)));
      const V ax = hn::Mul(hn::MulAdd(r.ca, t.wy, hn::Mul(r.sa, t.wx)), inverse);
      const V ay = hn::Mul(hn::NegMulAdd(r.ca, t.wx, hn::Mul(r.sa, t.wy)), inverse);
      const V bx = hn::Neg(hn::Mul(hn::MulAdd(r.ca, t.uy, hn::Mul(r.sa, t.ux)), inverse));
      const V by = hn::Mul(hn::NegMulAdd(r.sa, t.uy, hn::Mul(r.ca, t.ux)), inverse);
      const auto put = [&](int i, V gx, V gy) HWY_ATTR {
        hn::Store(gx, d, G + i * kLanes);
        hn::Store(gy, d, F + i * kLanes);
      };
      const V p0_ = hn::MulAdd(t.ux, t.a1c, hn::Mul(t.uy, t.a1s));
      put(geometry::kL11, hn::Mul(ax, p0_), hn::Mul(ay, p0_));
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
      const V e1 = hn::Sub(hn::Sub(hn::Set(d, p.x_mm), r.x0), t.x);
      const V e2 = hn::Sub(hn::Sub(hn::Set(d, p.y_mm), r.y0), t.y);
      update(
          d, P, x, [&](int i) HWY_ATTR { return hn::Load(d, G + i * kLanes); },
          [&](int i) HWY_ATTR { return hn::Load(d, F + i * kLanes); }, r1, r2, e1, e2);
    }
    const V broken = hn::Set(d, std::nan(""));
    for (int i = 0; i < kN; ++i) {
      const V xi = hn::Load(d, x + i * kLanes);
      hn::StoreU(hn::IfThenElse(reached, xi, broken), d, out + i * kLanes + lane);
    }
  }
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(rmse);
HWY_EXPORT(filter_nominal);
HWY_EXPORT(filter_estimate);

SwarmTable::SwarmTable(
    const PositionObservations& observations, const geometry::ParameterVector& v)
    : nominal(v) {
  for (int i = 0; i < observations.size(); ++i) {
    const Eigen::Vector2d q = observations.q_rad.col(i);
    const Eigen::Vector2d p = observations.p_WE.col(i);
    const auto assembly = observations.assembly[static_cast<std::size_t>(i)];
    points.push_back(
        {std::cos(q[0]), std::sin(q[0]), std::cos(q[1]), std::sin(q[1]),
         static_cast<double>(static_cast<int>(assembly)), p.x(), p.y()});
    const auto at_nominal = geometry::forward_derivative(v, q, assembly);
    if (!at_nominal) {
      nominal_reaches_all = false;
      continue;
    }
    Linear row;
    for (int axis = 0; axis < 2; ++axis) {
      for (int k = 0; k < geometry::kParameterCount; ++k) {
        row.row[axis][k] = at_nominal->J_v(axis, k);
      }
      row.error_mm[axis] = p[axis] - at_nominal->pose.p_WE[axis];
    }
    linear.push_back(row);
  }
}

void swarm_rmse(const SwarmTable& table, const ParameterLanes& v, Lanes<1>& rmse_mm) {
  HWY_DYNAMIC_DISPATCH(rmse)(table, v.data(), rmse_mm.data());
}

void swarm_filter_nominal(
    const SwarmTable& table, const geometry::ParameterVector& p0, const NoiseLanes& noise,
    ParameterLanes& state) {
  HWY_DYNAMIC_DISPATCH(filter_nominal)(table, p0.data(), noise.data(), state.data());
}

void swarm_filter_estimate(
    const SwarmTable& table, const geometry::ParameterVector& p0, const NoiseLanes& noise,
    ParameterLanes& state) {
  HWY_DYNAMIC_DISPATCH(filter_estimate)(table, p0.data(), noise.data(), state.data());
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
