// What each dial should show at a pose by the nominal robot, and whether what it does show can
// be true: far off, at rest where it should touch, unchanged although the robot moved, swapped.
// The nominal robot misses by millimetres, so only gross contradictions count.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/reading.h"
#include "geometry/rig.h"

namespace sixdial::acquisition {

struct ExpectedDial {
  /// mm; negative: that far from touching. Empty: cannot be said (free cuboid, near an edge).
  std::optional<double> displacement_mm;
  /// The tip clearly misses the face.
  bool off_face = false;
};

class Plausibility {
 public:
  /// `limit_mm`: how far a true reading may be from the nominal robot's.
  Plausibility(const geometry::Rig& rig, double limit_mm);

  /// What each dial should read by the nominal parameters with clamp angle 0; `assembly` empty:
  /// the rig's. Empty expectations where the pose cannot be computed, and of any instrument but
  /// the cuboid's.
  [[nodiscard]] std::vector<ExpectedDial> expected_at(
      const Eigen::VectorXd& q,
      std::optional<geometry::Assembly> assembly = std::nullopt) const;

  /// Lowers the quality of readings that contradict `expected` ("implausible", "no contact"
  /// where one is expected). Values stay.
  void judge(std::span<Reading> readings, std::span<const ExpectedDial> expected) const;

  /// "frozen": to the last digit what it was at another pose, where it should have changed by
  /// more than kFrozenChange_mm.
  static void judge_frozen(
      std::span<Reading> readings, std::span<const ExpectedDial> expected,
      std::span<const Reading> before, std::span<const ExpectedDial> expected_before);

 private:
  geometry::Rig rig_;
  std::optional<double> reference_angle_rad_;
  double limit_mm_;
};

inline constexpr double kFrozenChange_mm = 0.5;

}  // namespace sixdial::acquisition
