// A true robot arm under a position-measuring instrument (laser tracker, camera, CMM), with
// what is secretly wrong with it, and whole measured sessions from it. Its kinematics is worked
// out here once more, from Denavit's and Hartenberg's four steps a joint. Millimetre, radian,
// second, degree Celsius.
//
//   encoders -> true joint values -> links -> where the arm stands -> instrument
//
// Example:
//   ArmWorld world = drawn_arm(7);
//   world.effects = {make_arm_effect(world, "joint_backlash", "joint3", 4e-4)};
//   write_arm_bundle("monday", measure_arm(world, 200, 100), world);
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::mock_devices {

/// Rz(q + theta) Tz(d) Tx(a) Rx(alpha).
struct DhRow {
  double a_mm = 0.0, alpha_rad = 0.0, d_mm = 0.0, theta_rad = 0.0;
};

struct ArmEffect {
  std::string cause;  // "joint_backlash"
  std::string where;  // "joint2", "joint4,joint5", "instrument", "links", "frame"
  double amplitude = 0.0;
};

struct ArmWorld {
  std::vector<DhRow> nominal;  // what the rig file says
  std::vector<DhRow> actual;   // what it is
  Eigen::Vector3d tool_nominal_mm{0, 0, 0}, tool_mm{0, 0, 0};
  Eigen::Vector3d base_mm{0, 0, 0};        // where it stands; no file knows
  Eigen::Vector3d base_turn_rad{0, 0, 0};  // rotation vector
  double range_rad = 2.0;                  // joints move between plus and minus this
  double noise_mm = 0.02;                  // of one coordinate
  double warm_up_c = 4.0;                  // over the session
  double stop_scatter_rad = 0.0;  // of each joint: it stops so far from where it was told
  double read_scatter_rad = 0.0;  // its encoder's value is off by so much
  bool writes_commands = false;   // the session has what was commanded, too
  std::vector<ArmEffect> effects;
  std::uint64_t seed = 1;
};

/// An arm of four to seven joints, lengths and errors from a seed; `joints` 0: so many as the
/// seed says.
[[nodiscard]] ArmWorld drawn_arm(std::uint64_t seed, int joints = 0);

/// One thing that can be wrong with an arm.
struct ArmCause {
  std::string_view id;
  double least, most;          // range of the amplitude for drawing, log-uniform
  std::string_view amplitude;  // what it is, with its unit
};
[[nodiscard]] std::span<const ArmCause> arm_causes();
/// Where a cause can be at this arm.
[[nodiscard]] std::vector<std::string> places_at_arm(
    const ArmWorld& world, std::string_view cause);
/// Throws std::invalid_argument for an unknown cause or place.
[[nodiscard]] ArmEffect make_arm_effect(
    const ArmWorld& world, std::string_view cause, std::string_view where, double amplitude);
/// Cause, place and amplitude from a seed.
[[nodiscard]] ArmEffect draw_arm_effect(const ArmWorld& world, std::uint64_t seed);

struct ArmRow {
  std::string set = "G1";
  int point = 0;
  double time_s = 0.0, temperature_c = 20.0;
  Eigen::VectorXd q_rad;  // by the encoders
  Eigen::VectorXd q_command_rad;
  Eigen::Vector3d p_mm{0, 0, 0};
};
/// Where an instrument sees the tool [mm], without its noise: `approach` is the side from which
/// each joint came (-1, 0, 1), `index` the row's number of `rows`.
[[nodiscard]] Eigen::Vector3d seen_tool(
    const ArmWorld& world, const ArmRow& row, const Eigen::VectorXd& approach, int index,
    int rows);
/// Random poses, one after the other, the first `g1` of them G1, the others G2.
[[nodiscard]] std::vector<ArmRow> measure_arm(const ArmWorld& world, int g1, int g2);

/// [robot] and [[joint]] of rig.toml, as the file says the arm is; `more` are further lines of
/// [robot], each joint goes between plus and minus `range_rad`.
[[nodiscard]] std::string arm_robot_text(
    const ArmWorld& world, const std::string& more = "",
    std::optional<double> range_rad = std::nullopt);

/// Where its measured point is while the encoders read `q_rad`, at 20 degC, the instrument
/// aside; no joint comes from either side.
[[nodiscard]] Eigen::Vector3d tool_of_arm(const ArmWorld& world, const Eigen::VectorXd& q_rad);

/// session.csv and rig.toml of the nominal arm.
void write_arm_bundle(
    const std::filesystem::path& folder, const std::vector<ArmRow>& rows,
    const ArmWorld& world);

}  // namespace sixdial::mock_devices
