// A measurement session in memory: the rig as it was, and every sample with its raw readings.
// Files: session/bundle.h (session.csv + rig.toml), session/rig_file.h; database: db/.
#pragma once

#include <Eigen/Core>
#include <array>
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

/// One dial's raw reading within a sample. Without a value: no contact, or none was obtained,
/// and `reason` says which ("no contact", "timeout", "disconnected", "parse", "range",
/// "unsettled", "stale", ...).
struct DialValue {
  std::optional<double> value_mm;
  Quality quality = Quality::kGood;
  std::string reason;
  std::optional<TimePoint> time_utc;
};

struct Sample {
  std::string set;  // "G1", "G2" or another name
  int point = 0;
  int repeat = 0;
  std::optional<TimePoint> time_utc;
  Eigen::Vector2d q_rad{0, 0};  // encoder angles theta1, theta2
  std::optional<Eigen::Vector2d> target_mm;
  std::array<std::optional<int>, 2> approach;  // -1, 0, 1
  std::optional<double> temperature_c;
  std::vector<DialValue> dials;                // in the order of rig.dials
  std::optional<Eigen::Vector2d> position_mm;  // x_mm, y_mm of an instrument
  int line = 0;            // of the file it was read from, 0 if measured here
  std::string source_row;  // that line's text, given back unchanged on export
};

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

/// From the first to the last answer of the sample's dials; empty: fewer than two have a time.
[[nodiscard]] std::optional<double> readings_within_ms(const Sample& sample);

/// The same over a session's samples; empty: no sample knows its dials' times.
struct ReadingsWithin {
  double median_ms = 0.0;
  double max_ms = 0.0;
};
[[nodiscard]] std::optional<ReadingsWithin> readings_within(const Session& session);

}  // namespace sixdial::session
