// The rig as the data see it: what each quantity that the rig file knows only to within
// something (or claims exactly, and should not) becomes in a fit (spec 8).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

struct RigSeen {
  std::string name, unit;  // of simulation::RigQuantity
  double off = 0.0;        // from what the file says, in the unit
  double sd = 0.0;         // standard deviation of that
  double known_sd = 0.0;   // what was known before: stated, or what a workshop knows
  bool stated = false;
  /// Off by more than it was known to: |off| / known_sd.
  [[nodiscard]] double ratio() const;
};

/// One entry for each of readings.rig_quantities(), in their order.
[[nodiscard]] std::vector<RigSeen> rig_as_seen(const Readings& readings, const JointFit& fit);

/// The entry that is off by most of what was known of it; null: none.
[[nodiscard]] const RigSeen* worst_of(const std::vector<RigSeen>& rig);

}  // namespace sixdial::diagnosis
