#include "geometry/robot_kind.h"

#include <algorithm>
#include <deque>
#include <stdexcept>

#include "geometry/robots/five_bar.h"
#include "geometry/robots/linear_delta.h"
#include "geometry/robots/rotary_delta.h"
#include "geometry/robots/serial.h"
#include "geometry/robots/stewart.h"

namespace sixdial::geometry {
namespace {

/// One line for each kind that this program is built with.
std::vector<const RobotKind*>& rows() {
  static std::vector<const RobotKind*> all{
      &five_bar, &serial, &linear_delta, &rotary_delta, &stewart};
  return all;
}

template <typename Named>
std::optional<int> index_of(
    const std::vector<Named>& list, std::string_view name, auto name_of) {
  const auto found = std::ranges::find(list, name, name_of);
  if (found == list.end()) return std::nullopt;
  return static_cast<int>(found - list.begin());
}

std::span<const double> span_of(const Values& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

}  // namespace

std::string_view describe(KinematicTrouble trouble) {
  switch (trouble) {
    case KinematicTrouble::kOutOfReach:
      return "the legs cannot reach this pose";
    case KinematicTrouble::kStretched:
      return "a leg is stretched straight there (singular)";
    case KinematicTrouble::kFolded:
      return "a leg is folded onto itself there (singular)";
    case KinematicTrouble::kCoincidentElbows:
      return "both elbows coincide there, so the tool is not determined";
    case KinematicTrouble::kBadParameters:
      return "a length is not positive or a number is not finite";
    case KinematicTrouble::kNoInverse:
      return "joint values cannot be computed for this kind of robot";
  }
  return "unknown kinematic trouble";
}

Frames::Frames(const RobotModel& robot)
    : X(robot.frames.size()),
      by_q(robot.frames.size(), Twists::Zero(6, robot.joint_count())),
      by_v(robot.frames.size(), Twists::Zero(6, robot.parameter_count())) {}

std::optional<int> RobotModel::find_frame(std::string_view name) const {
  return index_of(frames, name, [](const std::string& each) { return std::string_view(each); });
}

std::optional<int> RobotModel::find_parameter(std::string_view name) const {
  return index_of(
      parameters, name, [](const ParameterInfo& each) { return std::string_view(each.name); });
}

std::string_view RobotModel::mode_name(WorkingMode mode) const {
  const auto found = std::ranges::find(modes, mode.number, &BranchInfo::number);
  return found == modes.end() ? std::string_view{} : std::string_view(found->name);
}

std::optional<WorkingMode> RobotModel::find_mode(std::string_view name) const {
  const auto found = std::ranges::find(modes, name, &BranchInfo::name);
  if (found == modes.end()) return std::nullopt;
  return WorkingMode(found->number);
}

Reached RobotModel::forward(
    const Values& v, const Values& q, Assembly assembly, std::span<Pose<double>> X) const {
  return kind->forward(*this, span_of(v), span_of(q), assembly, X);
}

Reached RobotModel::forward_derivative(
    const Values& v, const Values& q, Assembly assembly, Frames& at) const {
  return kind->forward_derivative(*this, span_of(v), span_of(q), assembly, at);
}

std::span<const RobotKind* const> robot_kinds() { return rows(); }

const RobotKind* find_robot_kind(std::string_view name) {
  const auto found = std::ranges::find(rows(), name, &RobotKind::name);
  return found == rows().end() ? nullptr : *found;
}

const RobotKind& add_robot_kind(RobotKind kind) {
  static std::deque<RobotKind> added;  // a deque: its elements stay where they are
  const std::string name(kind.name);
  if (name.empty() || kind.in_words.empty()) {
    throw std::invalid_argument("a robot kind needs a name, also in words");
  }
  if (find_robot_kind(name) != nullptr) {
    throw std::invalid_argument("there is a robot kind '" + name + "' already");
  }
  if (!kind.example || !kind.forward || !kind.forward_derivative) {
    throw std::invalid_argument(
        "robot kind '" + name + "' lacks example, forward or forward_derivative");
  }
  added.push_back(kind);
  rows().push_back(&added.back());
  return added.back();
}

}  // namespace sixdial::geometry
