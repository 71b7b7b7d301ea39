// What the stated limits are worth: a session without any effect says which size it would have
// detected, or named rightly. An effect of exactly that size is hidden where the same robot is
// measured at the same points again, with other noise.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::blind {

struct AtLimit {
  std::string cause;  // "joint_backlash"
  std::string where;
  bool of_name = false;  // at the limit of naming; else of detection
  bool detected = false;
  bool named = false;  // rightly, alone and for certain
  bool tied = false;   // in a set that has the right name
  bool wrong = false;  // something else for certain
};

enum class RigFile {
  kExact,       // dials stand where it says
  kDeviations,  // they stand elsewhere by as much as it states, each with an error curve
};

/// One place of each cause that this session's limits say can be seen, at both limits. Rig,
/// points, noise and temperature as in the blind challenge. `only`: this cause; empty: all.
[[nodiscard]] std::vector<AtLimit> try_limits(
    std::uint64_t seed, RigFile file = RigFile::kExact, std::string_view only = {});

}  // namespace sixdial::blind
