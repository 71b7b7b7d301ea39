// What a column's name speaks of, by a table of words: "Achse1", "A1", "axis 1", "J1" and
// "joint_1" are the first joint, "px" and "meas_x" a place, "Zeitpunkt" a time.
//
//   role_of("J3 (deg)").what;    // NameRole::What::kJoint
//   role_of("J3 (deg)").number;  // 3
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::session {

struct NameRole {
  enum class What {
    kNothing,  // no word that is known
    kOther,    // known, and nothing that a session holds: a speed, a deviation
    kJoint,
    kPlace,       // x, y, z
    kTurn,        // rx, ry, rz
    kQuaternion,  // qw, qx, qy, qz
    kTime,
    kTemperature,
  };
  What what = What::kNothing;
  std::string key{};            // of a place, a turn, a quaternion: "x", "rx", "qw"
  std::optional<int> number{};  // of a joint, as the name has it
  std::string stem{};           // of a joint: the name's words without the number
  /// The word says joint (not "A1", which a program may call an input, too).
  bool certain = false;
  bool commanded = false;  // not where the robot stood, but where it was told to go
  int rank = 0;            // of several of one key the highest is most likely what was measured
};

/// `name` may have its unit in it.
[[nodiscard]] NameRole role_of(std::string_view name);

/// A quaternion that is named as a turn: "pose.orientation.w" is the letter "w" of "pose
/// orientation". Empty: the name speaks of no turn, or of no letter or several.
struct TurnLetter {
  std::string stem;    // the other words
  std::string letter;  // w, x, y or z
};
[[nodiscard]] std::optional<TurnLetter> turn_letter_of(std::string_view name);

/// Whether every word of it is a number, a letter from x on, or one that says what a column is
/// of: "meas", "TCP", "0". If so, brackets with this text hold no unit: "x (TCP)".
[[nodiscard]] bool are_words_of_names(std::string_view text);

/// Words of a name in lower case: "ActJoint1_pos" -> "act", "joint", "1", "pos".
[[nodiscard]] std::vector<std::string> words_of(std::string_view name);

}  // namespace sixdial::session
