// What a figure can be traced to: serial numbers and certificates of robot, cuboid, dials and
// thermometer, and who measures. Keys of rig.toml that no calculation uses:
//
//   operator = "A. Person"
//   [cuboid]   and [robot], [thermometer] and each [[dial]], one key a line:
//     serial = "Q-12"          certificate = "K 4711"
//     certified = 2026-01-15   due = 2027-01-15
//
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::session {

inline constexpr std::array<const char*, 4> kTraceKeys{
    "serial", "certificate", "certified", "due"};

/// Of one part of the rig; empty: nobody has said.
struct TracedPart {
  std::string what;  // "robot", "cuboid", "thermometer", "dial A"
  std::string serial{};
  std::string certificate{};       // its number
  std::string certified{}, due{};  // dates, 2026-01-15
  /// "serial 12345, certificate K 4711 of 2026-01-15, due 2027-01-15"; empty: nothing is known.
  [[nodiscard]] std::string words() const;
};

struct Traceability {
  std::string operator_name{};
  std::vector<TracedPart> parts{};  // those of which something is known
  [[nodiscard]] const TracedPart* find(std::string_view what) const;
};

/// Of a rig file that parse_rig() takes; nothing where the text is no TOML.
[[nodiscard]] Traceability traceability_of(std::string_view rig_text);

/// "2026-01-15": a day that the calendar has.
[[nodiscard]] bool is_date(std::string_view text);

}  // namespace sixdial::session
