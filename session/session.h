// A measurement session in memory: the rig as it was, and every sample with its raw readings.
// Files: session/bundle.h (session.csv + rig.toml), session/rig_file.h; database: db/.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/rig.h"

namespace sixdial::session {

using TimePoint = std::chrono::sys_time<std::chrono::milliseconds>;
/// "2026-03-02T08:30:06.976Z".
[[nodiscard]] std::string to_iso8601(TimePoint time);
[[nodiscard]] std::optional<TimePoint> from_iso8601(std::string_view text);

enum class Quality { kGood, kUncertain, kBad };
/// "good", "uncertain", "bad".
[[nodiscard]] std::string_view to_string(Quality quality);
[[nodiscard]] std::optional<Quality> quality_from(std::string_view text);

/// Coordinates in a plane or in space [mm].
using geometry::Position;

/// The raw reading of one channel within a sample. Without a value: no contact, or none was
/// obtained, and `reason` says which: "no contact", "timeout", ... (session/reason.h).
struct ChannelValue {
  std::optional<double> value{};  // in the channel's unit
  Quality quality = Quality::kGood;
  std::string reason{};
  std::optional<TimePoint> time_utc{};
};

/// Lists are in the order of the rig's SampleLayout (session/sample_layout.h).
struct Sample {
  std::string set;  // "G1", "G2" or another name
  int point = 0;
  int repeat = 0;
  std::optional<TimePoint> time_utc;
  Eigen::VectorXd q;                  // encoder value of each joint [rad, mm]
  std::optional<Position> target_mm;  // in W
  /// Sign of each joint's last move: -1, 0 (unknown), 1. Joints that nothing is said of may be
  /// left out at the end.
  std::vector<std::optional<int>> approach;
  std::optional<double> temperature_c;
  /// The rig's dials first. The coordinates at the end are there where an instrument gave them.
  std::vector<ChannelValue> channels;
  /// Of the instrument, beside dials and coordinates: turns, distances, touches, sockets
  /// (SampleLayout::others). Empty where the rig has none.
  std::vector<std::optional<double>> others{};
  /// Standard deviation of each coordinate, where the file gives it with the reading [mm].
  std::vector<std::optional<double>> position_sd_mm{};
  /// Where the controller was told to go, joint by joint [rad, mm], beside q that was read
  /// back; empty: not recorded.
  Eigen::VectorXd q_command{};
  int line = 0;            // of the file it was read from, 0 if measured here
  std::string source_row;  // that line's text, given back unchanged on export
  /// Kept, but nothing is fitted to it or judged by it (studies/plausibility.h says why).
  bool left_out = false;
};
/// Of joint `joint`; empty: nothing is said of it.
[[nodiscard]] std::optional<int> approach_of(const Sample& sample, std::size_t joint);

/// A row that `--skip-bad-rows` left out.
struct RejectedRow {
  int line = 0;
  std::string text;
  std::string reason;
};

struct Session {
  std::string name;
  geometry::Rig rig;
  std::string rig_text;    // rig.toml as read, given back unchanged on export
  std::string csv_header;  // header line as read; empty if measured here
  std::string line_end = "\n";
  std::string csv_end = "\n";   // what follows the last row: line_end, nothing, or blank lines
  std::vector<Sample> samples;  // as stored; their times may go back if a clock was set
  std::vector<RejectedRow> rejected;
};

/// From the first to the last answer of the sample's channels; empty: fewer than two have a
/// time.
[[nodiscard]] std::optional<double> readings_within_ms(const Sample& sample);

/// The same over a session's samples; empty: no sample knows the times of its readings.
struct ReadingsWithin {
  double median_ms = 0.0;
  double max_ms = 0.0;
};
[[nodiscard]] std::optional<ReadingsWithin> readings_within(const Session& session);

}  // namespace sixdial::session
