// Blind challenges on robot arms: a drawn arm under a drawn instrument, what is wrong with it
// hidden, the session written as files, read back and diagnosed as a user would.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sixdial::blind {

struct ArmOutcome {
  int joints = 0;
  std::vector<std::string> truth;  // "joint_backlash@joint3"
  /// What the weakest of them does to the positions that geometry cannot imitate, over the
  /// noise.
  double strength = 0.0;
  std::string said;
  bool detected = false, named = false, in_tie = false, wrong = false;
  double seconds = 0.0;
};

/// `causes`: how many are hidden, 0 to 2. `low`, `high`: range of the strength; amplitudes are
/// set for it (log-uniform). A cause that geometry takes over whole is drawn anew.
struct ArmChallenge {
  int causes = 1;
  double low = 0.3, high = 5.0;
  int samples = 225;
};
[[nodiscard]] ArmOutcome challenge_arm(const ArmChallenge& of, std::uint64_t seed);

}  // namespace sixdial::blind
