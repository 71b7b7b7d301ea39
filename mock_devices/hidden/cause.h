// One thing that can secretly be wrong with the true rig: a row that says where it can be, how
// it is drawn, and what it does to the true rig at each stage. Most are the twins of an effect
// in simulation/effects/, worked out here a second time and in another way, so that generator
// and diagnosis do not share their mistakes; the rest are outside of that catalogue on purpose.
//
//   encoder angles -> [turn_joints] -> [change_arm] -> links -> tool -> [shift_tool] ->
//   [change_cuboid], [change_plunger] -> contact -> [error_mm] -> [gross_mm], [is_stale]
//
// A row stands in one of the files of this folder, by the stage it is about, and in
// all_causes.cpp.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/rig.h"
#include "mock_devices/cuboid_outline.h"
#include "mock_devices/random.h"
#include "mock_devices/smooth_field.h"

namespace sixdial::mock_devices {

struct Moment;

/// A hidden effect made ready for one rig: its place as an index, its numbers in the order of
/// the row's `numbers`.
struct ReadyEffect {
  std::string where;
  int joint = -1, dial = -1, other_dial = -1;
  int link = -1;  // of l11, l12, l21, l22
  std::array<double, 4> p{};
  std::shared_ptr<const SmoothField> field;
  std::shared_ptr<const RandomWalk> walk;
};

/// How a number changes when the whole effect is made so many times as large.
enum class Scaling { kNot, kAlike, kInversely };

struct NumberName {
  std::string_view name;  // with its unit: "b_rad"
  Scaling scaling = Scaling::kNot;
  /// Taken if a hidden effect lacks the number; without it, the effect is refused.
  std::optional<double> otherwise = std::nullopt;
  /// "amount": its unit, and so its whole name, depends on the place: "amount_rad" where
  /// something turns, "amount_mm" where something moves.
  bool unit_by_place = false;
};
/// Its name at this place.
[[nodiscard]] std::string name_at(const NumberName& number, std::string_view where);

/// What an effect is made from.
struct Draw {
  double amplitude;
  std::string_view where;
  const Random& random;
  int samples;                          // expected length of the session
  double phase_rad;                     // any angle
  [[nodiscard]] double across() const;  // amplitude cos phase
  [[nodiscard]] double along() const;   // amplitude sin phase
  [[nodiscard]] double seed() const;    // for what is random in itself
};

/// The arm before its tool is worked out.
struct ArmChange {
  geometry::ParameterVector v;
  double clamp_rad = 0.0;
};
/// The cuboid and the tips before they touch.
struct CuboidChange {
  double side_mm, shear_rad, tip_radius_mm;
  Eigen::Vector2d centre_mm;
};

struct CauseRow {
  std::string_view id;  // "joint_backlash"
  std::vector<std::string> (*places)(const geometry::Rig&);
  bool in_catalogue = true;
  bool both_signs = false;
  /// Range of the amplitude for drawing, log-uniform, in the unit of the first parameter.
  double least, most;
  std::string_view amplitude;  // what the amplitude is, with unit
  std::span<const NumberName> numbers = {};
  /// The numbers of an effect of a given amplitude, in the order of `numbers`.
  std::vector<double> (*draw)(const Draw&) = nullptr;
  /// Cables mixed up: there is no half of it.
  bool swaps_cables = false;
  /// Of single readings, not of the rig: what a robust fit passes over.
  bool is_data_fault = false;
  /// Outside of the catalogue: what the readings then depend on, at its place.
  std::string (*covariate)(std::string_view where) = nullptr;

  /// What else is worked out once; `q_reference`: joint angles at the cuboid's reference pose.
  void (*prepare)(ReadyEffect&, const Eigen::Vector2d& q_reference) = nullptr;
  void (*turn_joints)(
      const ReadyEffect&, const Moment&, const Eigen::Vector2d& q_rad,
      Eigen::Vector2d& theta_rad) = nullptr;
  void (*change_arm)(const ReadyEffect&, const Moment&, ArmChange&) = nullptr;
  /// `p_mm`: where the tool would be. Moves `p_WE_mm`.
  void (*shift_tool)(
      const ReadyEffect&, const Moment&, const geometry::Rig&, const Eigen::Vector2d& p_mm,
      Eigen::Vector2d& p_WE_mm) = nullptr;
  void (*change_cuboid)(const ReadyEffect&, double gamma_rad, CuboidChange&) = nullptr;
  void (*change_plunger)(const ReadyEffect&, const geometry::DialGeometry&, Plunger&) = nullptr;
  /// Of its dial, by the direction of the plunger's last move.
  double (*error_mm)(const ReadyEffect&, const Moment&, double displacement_mm, int direction) =
      nullptr;
  double (*gross_mm)(const ReadyEffect&, std::size_t dial, std::int64_t sample) = nullptr;
  bool (*is_stale)(const ReadyEffect&, std::size_t dial, std::int64_t sample) = nullptr;
  /// By how much the joints give under a torque [rad/(N mm)].
  Eigen::Vector2d (*compliance)(const ReadyEffect&) = nullptr;
};

// Helpers of the rows.
inline constexpr double kTwoPi = 2 * std::numbers::pi;
[[nodiscard]] Eigen::Vector2d direction(double angle_rad);
[[nodiscard]] Eigen::Vector2d turned(const Eigen::Vector2d& a, double angle_rad);
[[nodiscard]] std::vector<std::string> each_joint(const geometry::Rig&);
[[nodiscard]] std::vector<std::string> each_dial(const geometry::Rig&);
/// It turns there; elsewhere it moves.
[[nodiscard]] bool turns_at(std::string_view where);
/// The amplitude alone.
[[nodiscard]] std::vector<double> as_large(const Draw&);
/// A vector of that length and any direction.
[[nodiscard]] std::vector<double> in_any_direction(const Draw&);

}  // namespace sixdial::mock_devices
