// The columns of session.csv and which of them a header has.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "session/csv.h"
#include "session/sample_layout.h"

namespace sixdial::session {

enum class SampleColumn {
  kSet,
  kPoint,
  kRepeat,
  kTime,
  kJoint,     // with the joint's index
  kCommand,   // of a joint, with its index: the value that it was told, beside the one read
  kTarget,    // with the axis' index
  kApproach,  // with the joint's index
  kTemperature,
  kChannel,     // with the channel's index: a dial, or a coordinate
  kOther,       // with the index of another channel of the instrument
  kQuaternion,  // 0 to 3: w, x, y, z
  kDeviation,   // of a coordinate, with the axis' index
  kSocket,      // the name of the socket that the tool sits in
  kUnknown,     // kept, not understood
};

/// Columns of dials are "dial_<id>_mm".
inline constexpr std::string_view kDialColumn = "dial_";
/// "q1_command_rad" stands beside "q1_rad".
inline constexpr std::string_view kCommandSuffix = "_command";
/// Channels of sockets have no column of their own: the column `socket` names one.
inline constexpr std::string_view kSocketChannel = "socket_";

struct HeaderColumn {
  SampleColumn column = SampleColumn::kUnknown;
  std::size_t index = 0;  // into the layout's list of joints, axes or channels
  std::string name;
  double per_unit = 1.0;  // what stands in the file = the value * this
};

/// What each column of a header is. Adds a mistake for a dial that the rig does not have, for a
/// column that appears twice and for required ones that are missing.
[[nodiscard]] std::vector<HeaderColumn> read_header(
    const CsvRow& header, const SampleLayout& layout, std::vector<Mistake>& mistakes);

/// The columns in the spec's order for sessions measured here.
[[nodiscard]] std::vector<HeaderColumn> spec_columns(
    const SampleLayout& layout, bool with_dials, bool with_position,
    bool with_commands = false);

}  // namespace sixdial::session
