// A true delta robot, with carriages on towers or with arms, under an instrument that measures
// its platform (a tracker, or draw wires from anchors), with what is secretly wrong with it,
// and whole measured sessions from it. Its platform is found here once more, by steps towards
// the point that is a rod away from each carriage or knee. Millimetre, radian, second, degC.
//
//   encoders -> true joint values -> carriages or knees -> platform -> where it stands ->
//   instrument
//
// Example:
//   DeltaWorld world = drawn_delta(7);
//   world.effects = {make_delta_effect(world, "passive_clearance", "elbows", 0.1)};
//   write_delta_bundle("monday", measure_delta(world, 100, 50), world);
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::mock_devices {

/// Tower or leg 0 to 2 each.
struct DeltaSizes {
  double radius_mm = 0.0;  // of the towers or motors, less that of the platform
  std::array<double, 3> angle_rad{}, rod_mm{};
  std::array<double, 3> arm_mm{};  // of a delta with arms
  std::array<double, 3> zero{};    // of the encoder [mm of a carriage, rad of an arm]
};

struct DeltaEffect {
  std::string cause;  // "joint_backlash"
  std::string where;  // "joint2", "elbows", "instrument", "links", "frame"
  double amplitude = 0.0;
};

struct DeltaWorld {
  bool has_arms = false;                   // else carriages on towers
  DeltaSizes nominal;                      // what the rig file says
  DeltaSizes actual;                       // what it is
  Eigen::Vector3d base_mm{0, 0, 0};        // where it stands
  Eigen::Vector3d base_turn_rad{0, 0, 0};  // rotation vector
  /// Of draw wires, in W; empty: a tracker gives x, y, z, and no file knows where it stands.
  std::vector<Eigen::Vector3d> anchors_mm;
  double low = 0.0, high = 1.0;  // joints move between these
  double reach_mm = 100.0;       // the platform stays so near to the middle
  double noise_mm = 0.02;        // of a coordinate, of a wire's length
  double warm_up_c = 4.0;        // over the session
  std::vector<DeltaEffect> effects;
  std::uint64_t seed = 1;
};

/// Kind, sizes, errors and instrument from a seed.
[[nodiscard]] DeltaWorld drawn_delta(std::uint64_t seed);

/// One thing that can be wrong with a delta.
struct DeltaCause {
  std::string_view id;
  /// Range of the amplitude for drawing, log-uniform, of a joint that slides; of one that
  /// turns.
  double least_mm, most_mm;    // 0: there is none where joints slide
  double least_rad, most_rad;  // of a cause that is no joint's the same as in mm
  std::string_view amplitude;  // what it is, with its unit
};
[[nodiscard]] std::span<const DeltaCause> delta_causes();
/// Where a cause can be at this delta; none: it cannot have it.
[[nodiscard]] std::vector<std::string> places_at_delta(
    const DeltaWorld& world, std::string_view cause);
/// Throws std::invalid_argument for an unknown cause or place.
[[nodiscard]] DeltaEffect make_delta_effect(
    const DeltaWorld& world, std::string_view cause, std::string_view where, double amplitude);
/// Cause, place and amplitude from a seed.
[[nodiscard]] DeltaEffect draw_delta_effect(const DeltaWorld& world, std::uint64_t seed);

/// Where the platform is in its base's frame [mm] at these true joint values; empty: the rods
/// cannot meet below.
[[nodiscard]] std::optional<Eigen::Vector3d> platform_of(
    const DeltaSizes& sizes, bool has_arms, const Eigen::Vector3d& q);

struct DeltaRow {
  std::string set = "G1";
  int point = 0;
  double time_s = 0.0, temperature_c = 20.0;
  Eigen::Vector3d q{0, 0, 0};  // by the encoders [mm or rad]
  Eigen::VectorXd reading;     // x, y, z, or the length of each wire [mm]
};
/// Random poses, one after the other, the first `g1` of them G1, the others G2.
[[nodiscard]] std::vector<DeltaRow> measure_delta(const DeltaWorld& world, int g1, int g2);

/// session.csv and rig.toml of the nominal delta. Under wires the file has it stand where a
/// tape measure would: some millimetres off.
void write_delta_bundle(
    const std::filesystem::path& folder, const std::vector<DeltaRow>& rows,
    const DeltaWorld& world);

}  // namespace sixdial::mock_devices
