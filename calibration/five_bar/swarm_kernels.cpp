#include "calibration/five_bar/swarm_kernels.h"

#include <cmath>

// Highway compiles what lies between its marks once for every vector unit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/five_bar/swarm_kernels.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
#include "calibration/five_bar/lanes-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
constexpr int kN = geometry::kParameterCount;

constexpr int at(int i, int j) {
  return (i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i) * kLanes;
}

HWY_INLINE HWY_ATTR ToolLanes
tool_at(D d, const LaneRobot& r, const SwarmPoint& p, M& reached) {
  return tool_of(
      d, r, hn::Set(d, p.cos1), hn::Set(d, p.sin1), hn::Set(d, p.cos2), hn::Set(d, p.sin2),
      hn::Set(d, p.beta), reached);
}

HWY_ATTR void rmse(const SwarmTable& table, const double* v, double* out) {
  const D d;
  const auto step = hn::Lanes(d);
  for (std::size_t lane = 0; lane < kLanes; lane += step) {
    const LaneRobot r =
        robot_of(d, [&](int i) HWY_ATTR { return hn::LoadU(d, v + i * kLanes + lane); });
    M reached = r.usable;
    V sum = hn::Zero(d);
    for (const SwarmPoint& p : table.points) {
      const ToolLanes t = tool_at(d, r, p, reached);
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
      const LaneRobot r = robot_of(d, [&](int i) HWY_ATTR {
        return hn::Add(hn::Set(d, nominal[i]), hn::Load(d, x + i * kLanes));
      });
      reached = hn::And(reached, r.usable);
      const ToolLanes t = tool_at(d, r, p, reached);
      jacobian_of(d, r, t, [&](int i, V gx, V gy) HWY_ATTR {
        hn::Store(gx, d, G + i * kLanes);
        hn::Store(gy, d, F + i * kLanes);
      });
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
