// What the planners of the plane (plan_make.cpp) and of space (plan_in_space.cpp) share.
#pragma once

#include <Random123/philox.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "session/csv.h"
#include "session/plan.h"

namespace sixdial::session {

/// Numbers in [0, 1) from Philox 4x32-10 by seed and set: the same on every machine, and others
/// for G1 than for G2.
class Uniform {
 public:
  Uniform(std::uint64_t seed, std::string_view set) {
    key_[0] = static_cast<std::uint32_t>(seed);
    key_[1] = static_cast<std::uint32_t>(seed >> 32U);
    for (const char c : set) {  // FNV-1a
      stream_ = (stream_ ^ static_cast<unsigned char>(c)) * 16777619U;
    }
  }

  double next() {
    const r123::Philox4x32::ctr_type counter{
        {static_cast<std::uint32_t>(count_), static_cast<std::uint32_t>(count_ >> 32U), stream_,
         0U}};
    const auto bits = r123::Philox4x32()(counter, key_);
    ++count_;
    const std::uint64_t both = (std::uint64_t{bits[0]} << 32U) | bits[1];
    return static_cast<double>(both >> 11U) * 0x1.0p-53;
  }

 private:
  r123::Philox4x32::key_type key_{};
  std::uint32_t stream_ = 2166136261U;
  std::uint64_t count_ = 0;
};

// To what a plan file holds, so that writing and reading gives the same plan.
inline constexpr int kTargetDigits = 6;
inline constexpr int kJointDigits = 9;
template <typename Vector>
Vector rounded(Vector v, int digits) {
  for (double& each : v) each = rounded_decimal(each, digits);
  return v;
}

inline PlanRefusal refusal_of(const Position& target, std::string reason, std::string advice) {
  return {-1, target, std::move(reason), std::move(advice)};
}

/// Why these joint values are no good although the robot can take them: an error of one of its
/// lengths would move the tool more than ten times as far, as near a singular pose. Empty: they
/// are.
[[nodiscard]] std::string singular_there(
    const geometry::Rig& rig, const Eigen::VectorXd& q, geometry::Assembly assembly);

}  // namespace sixdial::session
