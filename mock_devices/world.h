// The true rig, which nobody in the project may look at except through the cables: the robot as
// it really is, the dials as they really stand, and whatever is secretly wrong with them.
//
//   encoder angles -> true angles -> links -> tool -> cuboid -> plungers -> what a dial would
//   show
//
// Pure functions of a moment: no clock, no state. `live_rig.h` adds time, `session_generator.h`
// makes whole sessions. Millimetre, radian, second, degree Celsius, newton.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/rig.h"
#include "mock_devices/cuboid_outline.h"
#include "mock_devices/hidden_effect.h"

namespace sixdial::mock_devices {

/// The true ten parameters and the clamp angle of the cuboid.
struct TrueRobot {
  geometry::ParameterVector parameters = geometry::table_2_robot();
  double clamp_rad = 0.0;
};
/// Around nominal: lengths +-0.6 mm, x0, y0 +-1 mm, alpha +-0.3 deg, offsets and clamp +-1 deg.
[[nodiscard]] TrueRobot drawn_robot(const geometry::Rig& rig, std::uint64_t seed);

/// How good the dials are; all of it can be switched off.
struct DialHabits {
  double noise_sd_mm = 0.002;
  double quantum_mm = 0.001;     // 0: no quantisation
  double hysteresis_mm = 0.001;  // difference of readings from the two directions
  double curve_mm = 0.002;       // bound of each dial's own smooth error, at most 0.006
};
/// Neither noise nor quantisation nor error.
inline constexpr DialHabits kIdealDials{0.0, 0.0, 0.0, 0.0};

/// Temperature start + rise (1 - exp(-t / tau)): a few degrees over the first hour.
struct WarmUp {
  double start_c = 20.0;
  double rise_c = 3.0;
  double tau_s = 1500.0;
};

/// Smooth non-kinematic error of the tool's position: what ANFIS is there for.
struct Warp {
  double amplitude_mm = 0.0;  // rms of each coordinate
  double wavelength_mm = 40.0;
};

/// What differs by chance from one arrival to the next: standard deviations.
struct Scatter {
  double tool_mm = 0.0;     // of the tool, in x and in y: the robot's repeatability
  double joints_rad = 0.0;  // of each joint, against what its encoder says
};

struct World {
  geometry::Rig rig = geometry::default_rig();
  TrueRobot robot;
  std::vector<HiddenEffect> effects;
  DialHabits dials;
  WarmUp warm_up;
  Warp warp;
  Scatter scatter;
  std::uint64_t seed = 1;
};

/// What the rig's behaviour depends on at an instant.
struct Moment {
  double time_s = 0.0;  // since the rig was switched on
  double temperature_c = 20.0;
  std::int64_t sample = 0;            // moves made so far, or row of a session
  Eigen::Vector2d q_rad{0, 0};        // by the encoders
  std::array<int, 2> approach{0, 0};  // sign of each joint's last move
  Eigen::Vector2d travel{0, 0};       // unit vector of the tool's last move, or zero
  Eigen::Vector2d scatter_mm{0, 0};   // by which the tool missed its place this time
  geometry::Assembly assembly = geometry::Assembly::kLeft;
};

struct TruePose {
  Eigen::Vector2d p_WE;                     // tool
  double gamma_rad;                         // of the cuboid
  Eigen::Vector2d theta_rad;                // true joint angles before the robot's own offsets
  std::vector<std::optional<Push>> pushes;  // by dial of the rig; not clamped to the travel
};

class WorldModel {
 public:
  /// Throws std::invalid_argument if an effect or a number makes no sense on this rig.
  explicit WorldModel(const World& world);
  ~WorldModel();
  WorldModel(WorldModel&&) noexcept;
  WorldModel& operator=(WorldModel&&) noexcept;

  [[nodiscard]] const World& world() const;
  [[nodiscard]] std::size_t dial_count() const { return world().rig.dials.size(); }
  [[nodiscard]] double temperature_c(double time_s) const;

  /// Empty where the true links cannot close.
  [[nodiscard]] std::optional<TruePose> pose(const Moment& moment) const;
  /// Tool alone: no dials, no compliance.
  [[nodiscard]] std::optional<Eigen::Vector2d> tool(const Moment& moment) const;

  /// What dial `dial` shows for a displacement, by the direction (-1, 0, 1) of its plunger's
  /// last move: scale, cyclic error, steps and hysteresis, the habits' hysteresis and curve.
  /// Without noise and quantisation. `with_habits` false leaves out the habits' part.
  [[nodiscard]] double shown_mm(
      std::size_t dial, double displacement_mm, int direction, const Moment& moment,
      bool with_habits = true) const;
  /// Gaussian noise of a dial; `counter` numbers its readings.
  [[nodiscard]] double noise_mm(std::size_t dial, std::uint64_t counter) const;
  [[nodiscard]] double quantised_mm(double value_mm) const;
  /// What a dial shows when nothing touches it: near 0, constant, its own.
  [[nodiscard]] double end_stop_mm(std::size_t dial) const;

  /// The dial whose reading arrives under the name of dial `name` (swapped cables).
  [[nodiscard]] std::size_t wired_to(std::size_t name) const;
  /// Gross error of one reading of a sample, 0 for most.
  [[nodiscard]] double gross_error_mm(std::size_t dial, std::int64_t sample) const;
  /// The sample's reading of this dial is the one before, handed over again.
  [[nodiscard]] bool is_stale(std::size_t dial, std::int64_t sample) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace sixdial::mock_devices
