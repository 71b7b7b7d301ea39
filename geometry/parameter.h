// One number that a robot or an instrument has and that a calibration may change: its name, the
// units it is computed and shown in, and how large a change of it is plausible. Robots and
// instruments hold theirs as a list; a vector of values has the same order.
#pragma once

#include <string>

namespace sixdial::geometry {

/// What a rig file may give for it.
enum class FileRange { kAny, kNotNegative, kPositive };

struct ParameterInfo {
  std::string name;             // "l11", as printed
  std::string rig_key;          // "l11_mm", its key in rig.toml; empty: not in that file
  std::string shown_unit;       // "mm" or "deg", as printed and as in rig.toml
  double shown_per_unit = 1.0;  // shown value = stored value * this
  std::string unit = "mm";      // as stored: "mm" or "rad"
  /// A plausible change [unit]; those of different units move the tool about as far.
  double change = 1.0;
  FileRange range = FileRange::kAny;
  bool grows = false;     // a length of a link: it grows with temperature
  bool stands = false;    // where the robot stands
  bool optional = false;  // a rig file may leave it out: the robot's usual value holds
  /// Standard deviation before any sample, by manufacture and mounting [unit]; 0: as is usual
  /// for a number of its unit.
  double known_to = 0.0;
  std::string meaning{};  // "proximal link of leg 1"
  std::string plainly{};  // the same for who stands at the rig: "motor link, leg 1"
};

}  // namespace sixdial::geometry
