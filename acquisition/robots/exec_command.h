// The command of `exec:` in a rig file, and what it prints. Pure.
//
//   exec:/home/me/move.sh {q1_deg} {q2_deg} --speed {speed_percent}
//
// Words are separated by blanks, one with blanks in it stands in "..." or '...'. No shell reads
// them: what a joint is called, or what a file says, is never run.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "acquisition/robot.h"

namespace sixdial::acquisition {

/// The words of the command. The error says what is wrong: an open quotation, a sign that only
/// a shell knows, a {name} that is no joint's, a joint that is never said.
[[nodiscard]] tl::expected<std::vector<std::string>, std::string> exec_words(
    std::string_view command, std::span<const RobotJoint> joints);

/// The command knows the speed: {speed_percent}.
[[nodiscard]] bool says_speed(std::span<const std::string> words);

/// The words with values for the {names}. q as in RobotState.
[[nodiscard]] std::vector<std::string> filled_in(
    std::span<const std::string> words, std::span<const RobotJoint> joints,
    const Eigen::VectorXd& q, int speed_percent);

struct ExecAnswer {
  std::optional<Eigen::VectorXd> q;  // as it printed them, of every joint; empty: of none
  std::optional<double> temperature_c;
};
/// Lines "q1_deg=12.5" (or _rad, _mm) and "temperature_c=21.3"; other lines may say anything.
/// The error: a value that is no number, the same joint twice, some joints and not others.
[[nodiscard]] tl::expected<ExecAnswer, std::string> parse_exec_output(
    std::string_view output, std::span<const RobotJoint> joints);

}  // namespace sixdial::acquisition
