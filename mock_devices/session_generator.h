// Whole measured sessions without cables and without waiting: planned poses in, rows out, as a
// careful operator would have got them from the true rig. For tests and the blind challenge.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mock_devices/world.h"

namespace sixdial::mock_devices {

struct PlannedPose {
  std::string set = "G1";
  int point = 0;
  int repeat = 0;
  double time_s = 0.0;          // since the rig was switched on
  Eigen::Vector2d q_rad{0, 0};  // commanded, by the encoders
  std::optional<Eigen::Vector2d> target_mm;
  /// Sign of each joint's last move, made from a little behind the pose; 0, 0: whatever comes
  /// from the pose before. The same angles again are no move: what the last one left stays.
  std::array<int, 2> approach{0, 0};
  std::optional<double> temperature_c;  // else the world's warm-up
  geometry::Assembly assembly = geometry::Assembly::kLeft;
};

using Readings = std::vector<std::optional<double>>;  // by dial of the rig; empty: no contact

struct MeasuredRow {
  PlannedPose planned;                // time, angles, target as planned
  std::array<int, 2> approach{0, 0};  // as it was; 0 unknown (first row)
  double temperature_c = 20.0;
  Readings dial_mm;        // as handed over: noise, quantisation, gross errors, swaps, all
  Readings noise_free_mm;  // hidden effects but no noise, quantisation, gross or stale values
  Readings no_effects_mm;  // the same rig without its hidden effects, noise-free
  bool gross = false;      // some reading has a gross error
  bool stale = false;      // some reading is the one before
};

struct GeneratedSession {
  std::vector<MeasuredRow> rows;
  /// Root mean square of noise_free - no_effects over all readings that both have [mm].
  [[nodiscard]] double effect_rms_mm() const;
};

/// Readings within the face and the travel are kept; the others are empty, as in spec 2.
/// Throws std::invalid_argument naming the pose that the true robot cannot take.
[[nodiscard]] GeneratedSession generate_session(
    const World& world, const std::vector<PlannedPose>& plan);

/// `count` poses uniform over a rectangle, reachable by the nominal robot in the rig's working
/// mode, about 8 s apart, direct moves; the first `count_g1` are G1, the others G2.
[[nodiscard]] std::vector<PlannedPose> random_plan(
    const geometry::Rig& rig, std::uint64_t seed, int count_g1 = 100, int count_g2 = 50,
    const Eigen::Vector2d& low_mm = {16, 30}, const Eigen::Vector2d& high_mm = {40, 66});

/// session.csv of spec 2. `start_time`: "2026-03-02T08:30:00.000Z" is time 0.
[[nodiscard]] std::string session_csv(
    const GeneratedSession& session, const geometry::Rig& rig, const std::string& start_time);
/// rig.toml of spec 2.
[[nodiscard]] std::string rig_toml(const geometry::Rig& rig);
/// What is hidden, as JSON: causes, effects with parameters, true robot, seed.
[[nodiscard]] std::string answer_json(const World& world);
/// Writes session.csv and rig.toml into a folder, which is made if need be.
void write_bundle(
    const std::filesystem::path& folder, const GeneratedSession& session,
    const geometry::Rig& rig, const std::string& start_time);

}  // namespace sixdial::mock_devices
