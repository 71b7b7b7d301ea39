// One blind trial: draws robot, rig, cause, place, size and seed, makes the session with the
// mock rig's generator, diagnoses it without a hint and compares. Used by the tests here and by
// bench/blind_challenge.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/scatter.h"
#include "mock_devices/session_generator.h"
#include "simulation/trial.h"

namespace sixdial::blind {

/// What to draw from. Strength R of an effect: RMS of what it leaves in the noise-free readings
/// after refitting robot and clamp angle, over the noise.
struct Challenge {
  std::string kind = "one";         // none, one, two, three, outside
  double low = 0.15, high = 5.0;    // of each effect's R
  double gross = 0.0;               // share of readings with gross errors
  bool xy_only = false;             // a session of positions
  bool curve = false;               // each dial has an error curve of its own, and hysteresis
  bool drawn_rig = false;           // other links, cuboid, dials, mount, mode, noise, points
  std::string cause{};              // only this one
  mock_devices::Scatter scatter{};  // of each arrival
  /// So many dials, drawn, stand further along their axes or less far, by something in
  /// [shift_low_mm, shift_high_mm].
  int shifted = 0;
  double shift_low_mm = 0.05, shift_high_mm = 2.0;
};

struct Outcome {
  std::uint64_t seed = 0;
  std::vector<std::string> truth;  // "joint_backlash@joint2"
  double least = 0.0;              // R of the weakest
  bool named = false;              // all truths named with certainty, and nothing else
  bool in_tie = false;             // each truth named or in a tied set
  bool detected = false;           // anything
  bool wrong = false;              // something named with certainty that is not there
  bool unknown = false;            // verdict unknown, with the right covariate
  double seconds = 0.0;            // of the diagnosis
  /// Scatter of arrivals that was found: of the tool, root mean square of one coordinate [mm].
  std::optional<diagnosis::ScatterFound> scatter;
  double gross_share = 0.0;               // of the readings
  std::vector<std::string> named_causes;  // certain ones
  std::string said;                       // for people
};

/// A generated session as the methods see it; `noise_free`: without noise, gross and stale
/// readings.
[[nodiscard]] std::vector<simulation::Trial> trials_of(
    const geometry::Rig& rig, const mock_devices::GeneratedSession& session,
    bool noise_free = false, bool xy_only = false);

/// Empty where this seed's draw makes no session of that strength.
[[nodiscard]] std::optional<Outcome> try_blind(const Challenge& challenge, std::uint64_t seed);

}  // namespace sixdial::blind
