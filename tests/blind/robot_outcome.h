// What a blind challenge on a robot in space draws and how its verdict is judged, whatever the
// robot.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "studies/diagnosis_result.h"

namespace sixdial::blind {

struct RobotOutcome {
  std::string robot;               // "5 joints", "arms, wires"
  std::vector<std::string> truth;  // "joint_backlash@joint3"
  /// What the weakest of them does to the readings that geometry cannot imitate, over the
  /// noise.
  double strength = 0.0;
  std::string said;
  bool detected = false, named = false, in_tie = false, wrong = false;
  double seconds = 0.0;
};

/// `causes`: how many are hidden, 0 to 2. `low`, `high`: range of the strength; amplitudes are
/// set for it (log-uniform). A cause that geometry takes over whole is drawn anew.
struct RobotChallenge {
  int causes = 1;
  double low = 0.3, high = 5.0;
  int samples = 225;
};

/// Holds what was found against outcome.truth.
void judge(const studies::DiagnosisResult& result, RobotOutcome& outcome);

/// A folder of this process that goes when it is done with.
class ChallengeFolder {
 public:
  ChallengeFolder(const std::string& name, std::uint64_t seed);
  ~ChallengeFolder();
  ChallengeFolder(const ChallengeFolder&) = delete;
  ChallengeFolder& operator=(const ChallengeFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace sixdial::blind
