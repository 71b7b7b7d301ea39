#include "acquisition/robots/exec_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "acquisition/fault.h"
#include "geometry/units.h"

namespace sixdial::acquisition {
namespace {

constexpr std::string_view kSpeed = "speed_percent";
constexpr std::string_view kTemperature = "temperature_c";
constexpr std::array<std::string_view, 9> kShellSigns{"|", "||", "&", "&&",  ";",
                                                      ">", ">>", "<", "2>&1"};

/// A joint's value under one of its names, in one of its units.
struct NamedValue {
  std::size_t joint = 0;
  double per_unit = 1.0;  // rad or mm of one of it
};

/// "q1_deg", "q1_rad", "elbow_deg": the joint's own name, or q and its number.
std::optional<NamedValue> named(std::string_view name, std::span<const RobotJoint> joints) {
  const std::size_t line = name.rfind('_');
  if (line == std::string_view::npos) return std::nullopt;
  const std::string_view unit = name.substr(line + 1);
  const std::string_view joint = name.substr(0, line);
  // Its own name first: another joint may be called q1.
  auto found = std::ranges::find(joints, joint, &RobotJoint::name);
  for (std::size_t j = 0; found == joints.end() && j < joints.size(); ++j) {
    if (joint == fmt::format("q{}", j + 1)) found = joints.begin() + static_cast<long>(j);
  }
  if (found == joints.end()) return std::nullopt;
  const auto j = static_cast<std::size_t>(found - joints.begin());
  if (found->turns && unit == "deg") return NamedValue{j, geometry::kRadPerDeg};
  if (found->turns ? unit == "rad" : unit == "mm") return NamedValue{j, 1.0};
  return std::nullopt;
}

/// "{q1_deg} {q2_deg}", as a command would say them.
std::string usual_names(std::span<const RobotJoint> joints) {
  std::vector<std::string> names;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    names.push_back(fmt::format("{{q{}_{}}}", j + 1, joints[j].turns ? "deg" : "mm"));
  }
  return fmt::format("{}", fmt::join(names, " "));
}

tl::expected<std::vector<std::string>, std::string> cut(std::string_view command) {
  std::vector<std::string> words;
  std::string word;
  bool in_word = false;
  char quotation = '\0';
  for (const char c : command) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) {
      return tl::unexpected(std::string("it has a control character in it"));
    }
    if (quotation != '\0') {
      if (c == quotation) {
        quotation = '\0';
      } else {
        word += c;
      }
    } else if (c == '"' || c == '\'') {
      quotation = c;
      in_word = true;
    } else if (c == ' ') {
      if (in_word) words.push_back(std::exchange(word, {}));
      in_word = false;
    } else {
      word += c;
      in_word = true;
    }
  }
  if (quotation != '\0') {
    return tl::unexpected(fmt::format("the quotation mark {} is never closed", quotation));
  }
  if (in_word) words.push_back(word);
  return words;
}

/// Calls `each(name)` for every {name} of a word, and puts what it gives in its place; empty if
/// a brace is never closed.
template <typename Each>
std::optional<std::string> replaced(std::string_view word, Each each) {
  std::string result;
  while (!word.empty()) {
    const std::size_t open = word.find('{');
    result += word.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t close = word.find('}', open);
    if (close == std::string_view::npos) return std::nullopt;
    result += each(word.substr(open + 1, close - open - 1));
    word.remove_prefix(close + 1);
  }
  return result;
}

std::string_view trimmed(std::string_view line) {
  while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
  while (!line.empty() && (line.back() == ' ' || line.back() == '\t' || line.back() == '\r')) {
    line.remove_suffix(1);
  }
  return line;
}

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

}  // namespace

tl::expected<std::vector<std::string>, std::string> exec_words(
    std::string_view command, std::span<const RobotJoint> joints) {
  const std::string example = fmt::format("exec:/home/me/move.sh {}", usual_names(joints));
  auto words = cut(command);
  if (!words) return words;
  if (words->empty()) return tl::unexpected("no program is named; write " + example);
  if (words->front().find_first_of("{}") != std::string::npos) {
    return tl::unexpected("the program's own name has no {name} in it; write " + example);
  }
  std::vector<bool> said(joints.size(), false);
  std::string unknown;
  for (const std::string& word : *words) {
    if (std::ranges::find(kShellSigns, word) != kShellSigns.end()) {
      return tl::unexpected(fmt::format(
          "'{}' means something to a shell only, and none is used: put the line into a script",
          word));
    }
    const auto whole = replaced(word, [&](std::string_view name) {
      if (name == kSpeed) return "";
      if (const auto value = named(name, joints)) {
        said[value->joint] = true;
      } else if (unknown.empty()) {
        unknown = name;
      }
      return "";
    });
    if (!whole) return tl::unexpected(fmt::format("'{}' has a {{ that is never closed", word));
  }
  if (!unknown.empty()) {
    return tl::unexpected(fmt::format(
        "{{{}}} is no joint of this robot; known are {} and {{{}}}", unknown,
        usual_names(joints), kSpeed));
  }
  if (const auto silent = std::ranges::find(said, false); silent != said.end()) {
    return tl::unexpected(fmt::format(
        "the command never says joint {}; write {}",
        joints[static_cast<std::size_t>(silent - said.begin())].name, example));
  }
  return words;
}

bool says_speed(std::span<const std::string> words) {
  const std::string mark = fmt::format("{{{}}}", kSpeed);
  return std::ranges::any_of(
      words, [&](const std::string& word) { return word.find(mark) != std::string::npos; });
}

std::vector<std::string> filled_in(
    std::span<const std::string> words, std::span<const RobotJoint> joints,
    const Eigen::VectorXd& q, int speed_percent) {
  std::vector<std::string> result;
  for (const std::string& word : words) {
    const auto text = replaced(word, [&](std::string_view name) {
      if (name == kSpeed) return std::to_string(speed_percent);
      const auto value = named(name, joints);
      if (!value) return std::string();  // exec_words has refused it
      return fmt::format(
          "{:.9f}", q[static_cast<Eigen::Index>(value->joint)] / value->per_unit);
    });
    result.push_back(text.value_or(word));
  }
  return result;
}

tl::expected<ExecAnswer, std::string> parse_exec_output(
    std::string_view output, std::span<const RobotJoint> joints) {
  ExecAnswer answer;
  std::vector<std::optional<double>> values(joints.size());
  while (!output.empty()) {
    const std::size_t end = output.find('\n');
    const std::string_view line = trimmed(output.substr(0, end));
    output = end == std::string_view::npos ? std::string_view() : output.substr(end + 1);
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view name = trimmed(line.substr(0, equals));
    const auto joint = named(name, joints);
    if (!joint && name != kTemperature) continue;
    const auto value = number(trimmed(line.substr(equals + 1)));
    if (!value) {
      return tl::unexpected(fmt::format("it printed {}, which is no number", printable(line)));
    }
    if (!joint) {
      answer.temperature_c = *value;
    } else if (values[joint->joint]) {
      return tl::unexpected(fmt::format("it printed {} twice", name));
    } else {
      values[joint->joint] = *value * joint->per_unit;
    }
  }
  const auto printed =
      std::ranges::count_if(values, [](const auto& v) { return v.has_value(); });
  if (printed == 0) return answer;
  Eigen::VectorXd q(std::ssize(values));
  for (std::size_t j = 0; j < values.size(); ++j) {
    if (!values[j]) {
      return tl::unexpected(fmt::format(
          "it printed {} of {} joints and not {}", printed, joints.size(), joints[j].name));
    }
    q[static_cast<Eigen::Index>(j)] = *values[j];
  }
  answer.q = std::move(q);
  return answer;
}

}  // namespace sixdial::acquisition
