// One session of the mock rig's generator whose truth is known, taken through calibration and
// diagnosis as a user would: how many of the stated 95 % intervals hold the truth, and whether
// a diagnosis names what is not there. Used by the tests here and by bench/coverage.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::blind {

enum class Repeats {
  kNone,
  kAtRest,       // three samples of each pose, one after the other
  kInterleaved,  // three rounds over all poses
};
[[nodiscard]] std::string_view to_string(Repeats repeats);

/// A case's cause: a different one for each session, all in turn.
inline constexpr std::string_view kAnyCause = "any cause";

struct CoverageCase {
  bool dials = false;  // raw readings are fitted; else measured positions
  int points = 100;    // poses of G1; G2 has half as many
  Repeats repeats = Repeats::kNone;
  double noise_times = 1.0;  // true noise over that of the rig file
  double warp_mm = 0.0;      // rms of something smooth that nobody names
  bool diagnosis = false;    // instead of a calibration
  std::string cause{};       // of a diagnosis: hidden in a size that rigs show; empty: none
  /// "positions, 100 points, noise x1".
  [[nodiscard]] std::string name() const;
};

struct Share {
  int inside = 0, of = 0;
  void count(bool is_inside) {
    inside += is_inside ? 1 : 0;
    ++of;
  }
};

struct Covered {
  std::uint64_t seed = 0;
  Share parameters;       // 95 % intervals of the robot's parameters
  Share positions;        // of each coordinate of predicted positions
  Share amplitudes;       // of the hidden cause's sizes, where it is named
  Share gain;             // of what naming gains on held-out points, where something is named
  double width_mm = 0.0;  // median half width of the predicted coordinates
  bool false_cause = false;  // a cause named with certainty that is not there
  /// Nothing is hidden and something was said to be: a cause, alone or tied, something unknown
  /// or exchanged dials.
  bool false_alarm = false;
};

/// Empty where this seed's draw makes no session of that case.
[[nodiscard]] std::optional<Covered> try_coverage(const CoverageCase& of, std::uint64_t seed);

}  // namespace sixdial::blind
