// One session of a rig as they are (mock_devices/workshop.h), diagnosed without a hint: what
// was named that is not there, whether the strong cause was found, where commands by the
// extended model take the true robot, and how many intervals hold the truth. Used by the tests
// here and by bench/blind_challenge --workshop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mock_devices/workshop.h"
#include "tests/blind/coverage.h"

namespace sixdial::blind {

struct WorkshopCase {
  bool misplaced = true;         // dials stand elsewhere than the file says
  bool deviations = true;        // the file says how well it knows
  bool strong = true;            // a cause that leaves at least as much as the noise
  double low = 1.0, high = 5.0;  // of its strength R
};

struct WorkshopOutcome {
  std::uint64_t seed = 0;
  std::string strong;          // "joint_backlash@joint2"; empty: none
  bool wrong = false;          // a certain name that is not there
  bool found = false;          // the strong cause is named, or in a set
  bool rig_geometry = false;   // the rig is found to be not as its file claims
  double kinematics_mm = 0.0;  // error of commands, best rigid alignment, mean of the targets
  double extended_mm = 0.0;
  Share parameters;  // 95 % intervals of the robot's parameters
  double seconds = 0.0;
  std::string said;
};

/// The file states how well its geometry is known: as well as it was placed.
void state_deviations(geometry::Rig& file, const mock_devices::Misplaced& by);

/// Empty where this seed's draw makes no session of that case.
[[nodiscard]] std::optional<WorkshopOutcome> try_workshop(
    const WorkshopCase& of, std::uint64_t seed);

}  // namespace sixdial::blind
