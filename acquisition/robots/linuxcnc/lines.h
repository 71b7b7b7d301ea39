// What LinuxCNC's remote (linuxcncrsh) says: lines of text. Pure.
//
//   hello EMC Sixdial 1.0           HELLO ACK EMCNETSVR 1.1        HELLO NAK
//   set mdi G53 G1 X10 F600         SET MDI ACK                    SET MDI NAK
//   get abs_act_pos                 ABS_ACT_POS 10.000000 0.000000 ...
//
//   parse_linuxcnc("SET MODE NAK")->kind;  // CncLineKind::kNak
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::acquisition {

/// Axes whose positions it tells, in that order.
inline constexpr std::string_view kCncAxes = "XYZABC";

enum class CncLineKind {
  kAck,     // of "hello" or "set": done, or taken
  kNak,     // of "hello", "set", "get": it was not
  kValue,   // of "get"
  kError,   // "error: ..." of newer versions, in the place of a value or an acknowledgement
  kRemark,  // echoes, warnings, more lines of an error
};

struct CncLine {
  CncLineKind kind = CncLineKind::kRemark;
  std::string name{};  // "HELLO", "MDI", "ABS_ACT_POS"; may be empty of a NAK or an error
  std::string rest{};  // of a value, or the words
};

/// One line without its end. Empty: bytes that are no text.
[[nodiscard]] std::optional<CncLine> parse_linuxcnc(std::string_view line);

/// "10.000000 -5.250000": all of `text`, finite and below 1e9. Empty otherwise.
[[nodiscard]] std::optional<std::vector<double>> cnc_figures(std::string_view text);
/// Words of "YES YES NO".
[[nodiscard]] std::vector<std::string> cnc_words(std::string_view text);

/// [deg, mm] in one of "MM", "INCH", "CM", "DEG", "RAD", "GRAD"; empty: another one.
[[nodiscard]] std::optional<double> cnc_unit(std::string_view name);

}  // namespace sixdial::acquisition
