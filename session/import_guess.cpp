// A first map.toml for somebody's file, with the sign by which each column was recognised.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>

#include "session/csv.h"
#include "session/import.h"
#include "session/toml_write.h"

namespace sixdial::session {
namespace {

std::string lower(std::string text) {
  for (char& letter : text) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  return text;
}

bool has(const std::string& name, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(
      words, [&](std::string_view word) { return name.find(word) != std::string::npos; });
}

/// Last letters of a name behind '.', '_' or a blank: "pose.qw" -> "qw".
std::string last_part(const std::string& name) {
  const std::size_t at = name.find_last_of("._ ");
  return at == std::string::npos ? name : name.substr(at + 1);
}

struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  int numbers = 0, others = 0;
  [[nodiscard]] double most() const { return std::max(std::abs(low), std::abs(high)); }
};

Range range_of(const ImportTable& table, std::size_t column) {
  Range range;
  for (const auto& row : table.rows) {
    const auto number = number_in(row[column], table.decimal);
    if (!number) {
      range.others += row[column].empty() ? 0 : 1;
      continue;
    }
    ++range.numbers;
    range.low = std::min(range.low, *number);
    range.high = std::max(range.high, *number);
  }
  return range;
}

struct Guess {
  std::string to, unit, why;
};

/// A comment of TOML holds no control characters.
std::string in_comment(std::string text) {
  for (char& letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte < 0x20U || byte == 0x7F) letter = '?';
  }
  return text;
}

constexpr double kMostTurns_rad = 7.0;  // a joint beyond it is given in degrees
constexpr double kMostMetres = 20.0;    // a place beyond it is given in millimetres

std::optional<Guess> guess_of(const std::string& raw, const Range& range, int& joints) {
  const std::string name = lower(raw);
  const std::string last = last_part(name);
  if (range.numbers == 0) return std::nullopt;
  if (has(name, {"goal", "target_x", "target_y", "target_z", "std", "sd_", "command"})) {
    return std::nullopt;
  }
  if (has(name, {"temp"})) return Guess{"temperature_c", "", "its name speaks of temperature"};
  if (last == "qw" || last == "qx" || last == "qy" || last == "qz") {
    return Guess{last, "", "its name is a part of a quaternion"};
  }
  if (last == "x" || last == "y" || last == "z") {
    const bool metres = range.most() < kMostMetres;
    return Guess{
        last + "_mm", metres ? "m" : "mm",
        fmt::format(
            "its name ends in {}; values up to {:.4g} are {}", last, range.most(),
            metres ? "metres" : "millimetres")};
  }
  if (last == "rx" || last == "ry" || last == "rz" || last == "roll" || last == "pitch" ||
      last == "yaw") {
    const std::string to = last == "roll"    ? "rx"
                           : last == "pitch" ? "ry"
                           : last == "yaw"   ? "rz"
                                             : last;
    const bool degrees = range.most() > kMostTurns_rad;
    return Guess{
        to + (degrees ? "_deg" : "_rad"), "",
        fmt::format("its name ends in {}; values up to {:.4g}", last, range.most())};
  }
  const bool numbered = !last.empty() && std::isdigit(static_cast<unsigned char>(last[0])) != 0;
  if (has(name, {"joint", "axis", "theta", "angle"}) ||
      (name.size() <= 3 && (name[0] == 'q' || name[0] == 'j')) || (numbered && name != last)) {
    const bool degrees = range.most() > kMostTurns_rad;
    return Guess{
        fmt::format("q{}_rad", ++joints), degrees ? "deg" : "rad",
        fmt::format(
            "its name speaks of a joint; values up to {:.4g} are {}", range.most(),
            degrees ? "degrees" : "radians")};
  }
  return std::nullopt;
}

}  // namespace

std::string guessed_map(const std::string& file, const std::string& rig_file) {
  return guessed_map(NamedText{file, read_file(file)}, rig_file);
}

std::string guessed_map(const NamedText& file, const std::string& rig_file) {
  const ImportTable table = read_table(file.text, file.name, {});
  std::string out = "# Made by `sixdial import --guess` from " + in_comment(file.name) +
                    ": look at every line.\n";
  for (const std::string& note : table.notes) out += "# " + in_comment(note) + "\n";
  out += fmt::format("rig = {}\n", toml_string(rig_file.empty() ? "rig.toml" : rig_file));
  int joints = 0;
  std::set<std::string> given;
  std::string unused;
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    const Range range = range_of(table, k);
    const auto guess = guess_of(table.names[k], range, joints);
    if (!guess || !given.insert(guess->to).second) {
      unused += fmt::format(
          "#   {} ({} numbers{}{})\n", in_comment(table.names[k]), range.numbers,
          range.numbers > 0 ? fmt::format(" from {:.5g} to {:.5g}", range.low, range.high) : "",
          range.others > 0 ? fmt::format(", {} other texts", range.others) : "");
      continue;
    }
    out += fmt::format(
        "\n# {}\n[[column]]\nfrom = {}\nto = {}\n", guess->why, toml_string(table.names[k]),
        toml_string(guess->to));
    if (!guess->unit.empty()) out += fmt::format("unit = {}\n", toml_string(guess->unit));
  }
  if (!unused.empty()) out += "\n# Columns that nothing was guessed for:\n" + unused;
  return out;
}

}  // namespace sixdial::session
