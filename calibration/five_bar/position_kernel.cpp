#include "calibration/five_bar/position_kernel.h"

#include <cmath>

// Highway compiles what lies between its marks once for every vector unit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/five_bar/position_kernel.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "calibration/five_bar/lanes-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {

constexpr int kN = geometry::kParameterCount;
constexpr int kSums = kN * (kN + 1) / 2 + kN + 1;  // lower triangle row by row, J'r, r'r

/// Lane sums, lane by lane: eight partial sums whatever the vector unit, so that every width
/// adds in the same order.
HWY_ATTR bool normal(
    const PositionBlock* HWY_RESTRICT blocks, std::size_t count, const double* HWY_RESTRICT v,
    double* HWY_RESTRICT sums) {
  const D d;
  const auto step = hn::Lanes(d);
  const LaneRobot r = robot_of(d, [&](int i) HWY_ATTR { return hn::Set(d, v[i]); });
  if (!hn::AllTrue(d, r.usable)) return false;
  HWY_ALIGN double total[kSums * kLanes] = {};
  HWY_ALIGN double G[kN * kLanes];
  HWY_ALIGN double F[kN * kLanes];
  M reached = r.usable;
  for (std::size_t b = 0; b < count; ++b) {
    const PositionBlock& p = blocks[b];
    for (std::size_t lane = 0; lane < kLanes; lane += step) {
      const auto load = [&](const double* from) HWY_ATTR { return hn::LoadU(d, from + lane); };
      const ToolLanes t = tool_of(
          d, r, load(p.cos1), load(p.sin1), load(p.cos2), load(p.sin2), load(p.beta), reached);
      const V weight = load(p.weight);
      jacobian_of(d, r, t, [&](int i, V gx, V gy) HWY_ATTR {
        hn::Store(hn::Mul(gx, weight), d, G + i * kLanes);
        hn::Store(hn::Mul(gy, weight), d, F + i * kLanes);
      });
      const V ex = hn::Mul(weight, hn::Sub(hn::Add(t.x, r.x0), load(p.x_mm)));
      const V ey = hn::Mul(weight, hn::Sub(hn::Add(t.y, r.y0), load(p.y_mm)));
      double* sum = total + lane;
      const auto add = [&](V a, V h, V c, V e) HWY_ATTR {
        hn::Store(hn::MulAdd(a, h, hn::MulAdd(c, e, hn::Load(d, sum))), d, sum);
        sum += kLanes;
      };
#pragma GCC unroll 10
      for (int i = 0; i < kN; ++i) {
        const V g = hn::Load(d, G + i * kLanes);
        const V f = hn::Load(d, F + i * kLanes);
#pragma GCC unroll 10
        for (int j = 0; j <= i; ++j) {
          add(g, hn::Load(d, G + j * kLanes), f, hn::Load(d, F + j * kLanes));
        }
      }
#pragma GCC unroll 10
      for (int i = 0; i < kN; ++i) {
        add(ex, hn::Load(d, G + i * kLanes), ey, hn::Load(d, F + i * kLanes));
      }
      add(ex, ex, ey, ey);
    }
  }
  if (!hn::AllTrue(d, reached)) return false;
  for (int k = 0; k < kSums; ++k) {
    const double* t = total + k * kLanes;
    sums[k] = ((t[0] + t[1]) + (t[2] + t[3])) + ((t[4] + t[5]) + (t[6] + t[7]));
  }
  return true;
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(normal);

std::vector<PositionBlock> position_blocks(const PositionObservations& observations) {
  const int n = observations.size();
  std::vector<PositionBlock> blocks(static_cast<std::size_t>((n + kLanes - 1) / kLanes));
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int i = static_cast<int>(b) * kLanes + lane;
      const int from = std::min(i, n - 1);
      const Eigen::Vector2d q = observations.q_rad.col(from);
      PositionBlock& block = blocks[b];
      block.cos1[lane] = std::cos(q[0]);
      block.sin1[lane] = std::sin(q[0]);
      block.cos2[lane] = std::cos(q[1]);
      block.sin2[lane] = std::sin(q[1]);
      block.beta[lane] =
          static_cast<int>(observations.assembly[static_cast<std::size_t>(from)]);
      block.x_mm[lane] = observations.p_WE(0, from);
      block.y_mm[lane] = observations.p_WE(1, from);
      block.weight[lane] = i < n ? 1.0 : 0.0;
    }
  }
  return blocks;
}

bool position_normal(
    const std::vector<PositionBlock>& blocks, const geometry::ParameterVector& v,
    Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr, double& rss_mm2) {
  constexpr int kN = geometry::kParameterCount;
  double sums[kN * (kN + 1) / 2 + kN + 1];
  if (!HWY_DYNAMIC_DISPATCH(normal)(blocks.data(), blocks.size(), v.data(), sums)) {
    return false;
  }
  const double* next = sums;
  for (int i = 0; i < kN; ++i) {
    for (int j = 0; j <= i; ++j) JtJ(i, j) = *next++;
  }
  for (int i = 0; i < kN; ++i) Jtr[i] = *next++;
  rss_mm2 = *next;
  return std::isfinite(rss_mm2);
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
