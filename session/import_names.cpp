#include "session/import_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "session/csv.h"
#include "session/import_units.h"

namespace sixdial::session {
namespace {

using What = NameRole::What;
using Words = std::vector<std::string>;

/// Of a joint, in English and in German; what else stands in the name does not matter.
constexpr auto kJointWords = std::to_array<std::string_view>(
    {"joint", "joints", "jnt", "axis", "axes", "ax", "achse", "achsen", "gelenk", "gelenke",
     "gelenkwinkel", "theta", "achswinkel"});
/// The same in short, if only such words stand beside it that say nothing else.
constexpr auto kShortJointWords = std::to_array<std::string_view>(
    {"q", "j", "a", "th", "angle", "winkel", "motor", "encoder", "servo", "m", "d"});
constexpr auto kBesideAJoint = std::to_array<std::string_view>(
    {"pos",      "position", "positions", "act",    "actual",    "ist",    "istwert", "value",
     "values",   "wert",     "val",       "angle",  "angles",    "winkel", "read",    "meas",
     "measured", "enc",      "encoder",   "state",  "states",    "rob",    "robot",   "arm",
     "feedback", "fb",       "joint",     "joints", "drehgeber", "axis",   "motor",   "msr"});
constexpr auto kCommanded = std::to_array<std::string_view>(
    {"command", "commanded", "cmd", "goal", "target", "setpoint", "soll", "sollwert", "desired",
     "des", "ziel", "nominal", "nom", "reference", "ref"});
/// What is no value of a joint or of a place, whatever stands beside it.
constexpr auto kOtherWords = std::to_array<std::string_view>(
    {"std",
     "sd",
     "stdev",
     "sigma",
     "unc",
     "uncertainty",
     "err",
     "error",
     "residual",
     "dev",
     "deviation",
     "abweichung",
     "diff",
     "vel",
     "velocity",
     "speed",
     "geschwindigkeit",
     "acc",
     "accel",
     "acceleration",
     "torque",
     "moment",
     "drehmoment",
     "strom",
     "force",
     "kraft",
     "voltage",
     "current",
     "load",
     "payload",
     "offset",
     "status",
     "flag",
     "count",
     "limit",
     "min",
     "max",
     "variance",
     "rms"});
constexpr auto kTurnWords = std::to_array<std::string_view>(
    {"rot", "rotation", "orientation", "ori", "orient", "rpy", "euler", "rotvec", "drehung",
     "r", "angle", "winkel", "rotvector"});
constexpr auto kTimeWords = std::to_array<std::string_view>(
    {"time", "timestamp", "stamp", "zeit", "zeitpunkt", "zeitstempel", "uhrzeit", "datum",
     "date", "datetime", "utc"});
constexpr auto kTemperatureWords =
    std::to_array<std::string_view>({"temp", "temperature", "temperatur", "tmp"});
constexpr auto kMeasuredWords = std::to_array<std::string_view>(
    {"meas", "measured", "measurement", "mess", "gemessen", "tracker", "leica", "laser",
     "prism", "probe", "cmm", "camera", "smr"});
constexpr auto kOwnWords = std::to_array<std::string_view>(
    {// what a controller works out by itself
     "tcp", "robot", "rob", "flange", "flansch", "fk", "controller"});

constexpr auto kLetters = std::to_array<std::string_view>({"w", "x", "y", "z"});

struct OneWord {
  std::string_view word;
  What what;
  std::string_view key;
};
constexpr std::array kOneWords{
    OneWord{"px", What::kPlace, "x"},       OneWord{"py", What::kPlace, "y"},
    OneWord{"pz", What::kPlace, "z"},       OneWord{"posx", What::kPlace, "x"},
    OneWord{"posy", What::kPlace, "y"},     OneWord{"posz", What::kPlace, "z"},
    OneWord{"rx", What::kTurn, "rx"},       OneWord{"ry", What::kTurn, "ry"},
    OneWord{"rz", What::kTurn, "rz"},       OneWord{"roll", What::kTurn, "rx"},
    OneWord{"pitch", What::kTurn, "ry"},    OneWord{"yaw", What::kTurn, "rz"},
    OneWord{"qw", What::kQuaternion, "qw"}, OneWord{"qx", What::kQuaternion, "qx"},
    OneWord{"qy", What::kQuaternion, "qy"}, OneWord{"qz", What::kQuaternion, "qz"}};

template <class Table>
bool is_one_of(const Table& table, std::string_view word) {
  return std::ranges::find(table, word) != table.end();
}

template <class Table>
bool any_of(const Words& words, const Table& table) {
  return std::ranges::any_of(
      words, [&](const std::string& word) { return is_one_of(table, word); });
}

bool is_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == word.npos;
}

/// The number behind the word, else that before it, else the only one of the name.
std::optional<std::size_t> number_near(const Words& words, std::size_t at) {
  if (at + 1 < words.size() && is_number(words[at + 1])) return at + 1;
  if (at > 0 && is_number(words[at - 1])) return at - 1;
  std::optional<std::size_t> only;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!is_number(words[i])) continue;
    if (only) return std::nullopt;
    only = i;
  }
  return only;
}

std::optional<NameRole> joint_in(const Words& words) {
  const auto place_of = [&](const auto& table) {
    return std::ranges::find_if(
        words, [&](const std::string& word) { return is_one_of(table, word); });
  };
  NameRole role{.what = What::kJoint};
  auto word = place_of(kJointWords);
  role.certain = word != words.end();
  const auto nothing_else = [&](const std::string& each) {
    return is_number(each) || is_one_of(kShortJointWords, each) ||
           is_one_of(kBesideAJoint, each) || is_one_of(kCommanded, each);
  };
  if (!role.certain) {
    word = place_of(kShortJointWords);
    if (word == words.end() || !std::ranges::all_of(words, nothing_else)) return std::nullopt;
  } else if (words.size() == 2 && words[1].size() == 1 && words[1][0] >= 'x') {
    return std::nullopt;  // "axis x" may be a place as well
  }
  const auto at = number_near(words, static_cast<std::size_t>(word - words.begin()));
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (at == i) {
      const auto number = parse_integer(words[i]);
      if (!number || *number > 99) return std::nullopt;
      role.number = number;
    } else {
      role.stem += (role.stem.empty() ? "" : " ") + words[i];
    }
  }
  if (!role.certain && !role.number) return std::nullopt;  // "angle" alone is nobody's
  return role;
}

/// "x" of "meas x", "x tcp": the only word of one letter from x on.
std::optional<NameRole> place_or_turn_in(const Words& words) {
  for (const std::string& word : words) {
    if (const auto* const one = std::ranges::find(kOneWords, word, &OneWord::word);
        one != kOneWords.end()) {
      return NameRole{.what = one->what, .key = std::string(one->key)};
    }
  }
  std::string letter;
  bool second_point = false;
  for (const std::string& word : words) {
    if (is_number(word) && word != "1") second_point = true;
    if (!is_one_of(kLetters, word)) continue;
    if (!letter.empty()) return std::nullopt;
    letter = word;
  }
  if (letter.empty() || second_point) return std::nullopt;
  const bool ends =
      words.front() == letter || words.back() == letter || is_number(words.back());
  if (any_of(words, std::array<std::string_view, 3>{"q", "quat", "quaternion"})) {
    return NameRole{.what = What::kQuaternion, .key = "q" + letter};
  }
  if (letter == "w" || !ends) return std::nullopt;
  if (any_of(words, kTurnWords)) return NameRole{.what = What::kTurn, .key = "r" + letter};
  return NameRole{.what = What::kPlace, .key = letter};
}

}  // namespace

std::vector<std::string> words_of(std::string_view name) {
  enum class Letters { kNone, kLower, kUpper, kDigit };
  Words words;
  std::string word;
  Letters last = Letters::kNone;
  const auto end_word = [&] {
    if (!word.empty()) words.push_back(in_lower_case(std::exchange(word, "")));
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto byte = static_cast<unsigned char>(name[i]);
    const Letters now = std::isdigit(byte) != 0                  ? Letters::kDigit
                        : std::isupper(byte) != 0                ? Letters::kUpper
                        : std::islower(byte) != 0 || byte > 0x7F ? Letters::kLower
                                                                 : Letters::kNone;
    const bool digits_end = (now == Letters::kDigit) != (last == Letters::kDigit);
    if (digits_end || (now == Letters::kUpper && last == Letters::kLower)) end_word();
    if (now == Letters::kNone) {
      end_word();
    } else {
      word += name[i];
    }
    last = now;
  }
  end_word();
  return words;
}

std::optional<TurnLetter> turn_letter_of(std::string_view name) {
  const Words words = words_of(unit_in_name(name).base);
  if (!any_of(words, kTurnWords)) return std::nullopt;
  TurnLetter part;
  for (const std::string& word : words) {
    if (!is_one_of(kLetters, word)) {
      part.stem += (part.stem.empty() ? "" : " ") + word;
    } else if (!std::exchange(part.letter, word).empty()) {
      return std::nullopt;
    }
  }
  if (part.letter.empty()) return std::nullopt;
  return part;
}

bool are_words_of_names(std::string_view text) {
  return std::ranges::all_of(words_of(text), [](const std::string& word) {
    return is_number(word) || is_one_of(kLetters, word) || is_one_of(kJointWords, word) ||
           is_one_of(kBesideAJoint, word) || is_one_of(kCommanded, word) ||
           is_one_of(kMeasuredWords, word) || is_one_of(kOwnWords, word) ||
           is_one_of(kTurnWords, word) || is_one_of(kTimeWords, word) ||
           is_one_of(kTemperatureWords, word) || is_one_of(kOtherWords, word);
  });
}

NameRole role_of(std::string_view name) {
  const NameWithUnit split = unit_in_name(name);
  const Words words = words_of(split.base);
  if (words.empty()) return {};
  NameRole role;
  const auto joint = joint_in(words);
  if (any_of(words, kOtherWords)) {
    role.what = What::kOther;
  } else if (any_of(words, kTemperatureWords)) {
    role.what = joint && joint->number ? What::kOther : What::kTemperature;
  } else if (joint) {
    role = *joint;
  } else if (any_of(words, kTimeWords)) {
    role.what = What::kTime;
  } else if (const auto place = place_or_turn_in(words)) {
    role = *place;
  }
  role.commanded = any_of(words, kCommanded);
  if (any_of(words, kMeasuredWords)) role.rank += 1;
  if (any_of(words, kOwnWords)) role.rank -= 1;
  return role;
}

}  // namespace sixdial::session
