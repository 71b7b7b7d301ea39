#include "geometry/robots/serial.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "geometry/dual.h"
#include "geometry/inverse_by_steps.h"
#include "geometry/robots/serial_chain.h"

namespace sixdial::geometry {
namespace {

using Eigen::Vector3d;
using serial_chain::Block;
using serial_chain::Details;
using serial_chain::details_of;
using serial_chain::kSlots;
using serial_chain::Link;
using serial_chain::Numbers;
using serial_chain::numbers;

bool finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double each) { return std::isfinite(each); });
}

Reached frames_of(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly assembly, std::span<Pose<double>> X) {
  if (!finite(v) || !finite(q)) return tl::unexpected(KinematicTrouble::kBadParameters);
  return serial_chain::Serial::frames<double>(robot, v, q, assembly, X);
}

/// How everything behind a link moves with one of its numbers: a turn about its origin, and a
/// shift, in W.
struct Motion {
  std::size_t first_frame = 0;  // the first link behind it, or the link itself
  int joint = -1;               // by this joint value,
  int parameter = -1;           // or by this parameter
  Vector3d origin_mm, shift, turn;
};

constexpr int kAtOnce = 8;  // numbers of a block and its joint value: seven at most
using Number = Dual<kAtOnce>;

/// The block's numbers as variables, in their order; the joint's value is the one behind them.
Numbers<Number> variables(const Block& block, std::span<const double> v, int& count) {
  Numbers<Number> result;
  const Numbers<double> at = numbers<double>(block, v);
  count = 0;
  for (std::size_t i = 0; i < kSlots; ++i) {
    result[i] = block.parameter[i] < 0 ? Number(at[i]) : Number(at[i], count++);
  }
  return result;
}

/// Adds a motion for each variable of a block, whose pose in the frame `before` is `local`.
/// Returns the pose in W.
Pose<double> take_motions(
    const Pose<double>& before, const Pose<Number>& local, const Block& block, int count,
    const Link* link, std::size_t first_frame, std::vector<Motion>& motions) {
  Pose<double> inner;
  for (int i = 0; i < 3; ++i) {
    inner.p[i] = local.p[i].value;
    for (int j = 0; j < 3; ++j) inner.R(i, j) = local.R(i, j).value;
  }
  const Pose<double> X = serial_chain::behind(before, inner);
  const auto take = [&](int variable, int joint, int parameter) {
    Vector3d shift;
    Vector3d turn = Vector3d::Zero();
    for (int i = 0; i < 3; ++i) shift[i] = local.p[i].d[variable];
    // dR R' = [turn]: three of its elements.
    for (int j = 0; j < 3; ++j) {
      turn[0] += local.R(2, j).d[variable] * inner.R(1, j);
      turn[1] += local.R(0, j).d[variable] * inner.R(2, j);
      turn[2] += local.R(1, j).d[variable] * inner.R(0, j);
    }
    motions.push_back({first_frame, joint, parameter, X.p, before.R * shift, before.R * turn});
  };
  int variable = 0;
  for (std::size_t i = 0; i < kSlots; ++i) {
    if (block.parameter[i] >= 0) take(variable++, -1, block.parameter[i]);
  }
  if (link != nullptr) take(count, static_cast<int>(link->joint), -1);
  return X;
}

/// Each link by dual numbers; the frames behind it are carried along.
Reached frame_derivatives(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly /*assembly*/, Frames& at) {
  if (!finite(v) || !finite(q)) return tl::unexpected(KinematicTrouble::kBadParameters);
  const Details& is = details_of(robot);
  static thread_local std::vector<Motion> motions;
  motions.clear();
  int count = 0;
  const Numbers<Number> base = variables(is.blocks.front(), v, count);
  Pose<double> X = take_motions(
      {}, serial_chain::frame_pose<Number>(base), is.blocks.front(), count, nullptr, 1,
      motions);
  for (std::size_t i = 0; i < is.links.size(); ++i) {
    const Link& link = is.links[i];
    const Numbers<Number> s = variables(is.blocks[i + 1], v, count);
    const auto local = serial_chain::link_pose<Number>(link, s, Number(q[link.joint], count));
    X = take_motions(X, local, is.blocks[i + 1], count, &link, i + 1, motions);
    at.X[i + 1] = X;
  }
  const std::size_t frames = is.links.size() + 1;  // the tool's stands behind them all
  const Numbers<Number> tool = variables(is.blocks.back(), v, count);
  at.X[0] = take_motions(
      X, serial_chain::frame_pose<Number>(tool), is.blocks.back(), count, nullptr, frames,
      motions);
  for (Twists& each : at.by_q) each.setZero();  // several links may follow one joint
  for (const Motion& motion : motions) {
    for (std::size_t k = at.tool_only ? frames : motion.first_frame; k <= frames; ++k) {
      const std::size_t frame = k == frames ? 0 : k;
      Eigen::Matrix<double, 6, 1> twist;
      twist << motion.shift + motion.turn.cross(at.X[frame].p - motion.origin_mm), motion.turn;
      if (motion.parameter >= 0) {
        at.by_v[frame].col(motion.parameter) = twist;
      } else {
        at.by_q[frame].col(motion.joint) += twist;
      }
    }
  }
  return {};
}

tl::expected<Eigen::VectorXd, KinematicTrouble> joints_at(
    const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE,
    WorkingMode /*mode*/, std::span<const double> near) {
  return inverse_by_steps(robot, v, X_WE, near);
}

constexpr double kUsual_rad = 2.0;  // joint values that tests draw where no limit is given
constexpr double kUsual_mm = 100.0;

/// The row whose value this one takes: itself, or the one that it follows.
std::size_t joint_of(RobotModel& robot, const SerialRow& row, const SerialRobot& arm) {
  const std::string& name = row.follows.empty() ? row.name : row.follows;
  const auto found = std::ranges::find(robot.joints, name, &JointInfo::name);
  if (found != robot.joints.end()) {
    return static_cast<std::size_t>(found - robot.joints.begin());
  }
  const auto own = std::ranges::find(arm.rows, name, &SerialRow::name);
  const SerialRow& moved = own == arm.rows.end() ? row : *own;
  const double usual = moved.kind == JointKind::kRevolute ? kUsual_rad : kUsual_mm;
  robot.joints.push_back(
      {name, moved.kind, moved.low.value_or(-usual), moved.high.value_or(usual)});
  return robot.joints.size() - 1;
}

Block frame_block(const Vector3d& at_mm, const Vector3d& turn_rad) {
  return {{at_mm[0], at_mm[1], at_mm[2], turn_rad[0], turn_rad[1], turn_rad[2]}};
}

Block block_of(const SerialRow& row) {
  // The turn of an origin stands in Link::turn: its parameters are a correction.
  if (row.form == RowForm::kOrigin) return frame_block(row.origin_mm, Vector3d::Zero());
  return {{row.theta_rad, row.d_mm, row.a_mm, row.alpha_rad, row.beta_rad, 0.0}};
}

Link link_of(const SerialRow& row, std::size_t joint) {
  Link link{row, joint};
  link.turn = turned_by<double>(row.turn_rad);
  for (int i = 0; i < 3; ++i) {
    if (row.axis[i] == 1.0) link.axis_number = i;
  }
  return link;
}

std::shared_ptr<const RobotModel> example() {
  static const auto model = [] {
    // Universal Robots' UR10 by its maker's Denavit-Hartenberg rows.
    constexpr double kRight_rad = 1.5707963267948966;
    SerialRobot arm;
    const auto row = [&](const char* name, double d, double a, double alpha) {
      SerialRow each{.name = name};
      each.d_mm = d;
      each.a_mm = a;
      each.alpha_rad = alpha;
      arm.rows.push_back(each);
    };
    row("q1", 127.3, 0.0, kRight_rad);
    row("q2", 0.0, -612.0, 0.0);
    row("q3", 0.0, -572.3, 0.0);
    row("q4", 163.941, 0.0, kRight_rad);
    row("q5", 115.7, 0.0, -kRight_rad);
    row("q6", 92.2, 0.0, 0.0);
    arm.tool_mm = {15.0, 25.0, 120.0};
    return serial_model(arm);
  }();
  return model;
}

}  // namespace

std::shared_ptr<const RobotModel> serial_model(const SerialRobot& arm) {
  if (arm.rows.empty()) throw std::invalid_argument("an arm has at least one joint");
  auto details = std::make_shared<Details>();
  details->robot = arm;
  RobotModel robot;
  robot.kind = &serial;
  robot.axes = 3;
  robot.from_other_file = arm.from_other_file;
  details->blocks.push_back(frame_block(arm.base_mm, arm.base_turn_rad));
  robot.frames = {"E"};
  for (const SerialRow& row : arm.rows) {
    details->links.push_back(link_of(row, joint_of(robot, row, arm)));
    if (!row.follows.empty()) robot.joints[details->links.back().joint].geared = true;
    details->blocks.push_back(block_of(row));
    robot.frames.push_back("link" + std::to_string(robot.frames.size()));
  }
  details->blocks.push_back(frame_block(arm.tool_mm, arm.tool_turn_rad));
  robot.assemblies = {{+1, "the one"}};
  robot.modes = {{0, "the one"}};
  serial_chain::choose_parameters(robot, *details);
  robot.details = std::move(details);
  return std::make_shared<const RobotModel>(std::move(robot));
}

SerialRobot serial_robot(const RobotModel& model, const Values& v) {
  const Details& is = details_of(model);
  SerialRobot arm = is.robot;
  const std::span<const double> values(v.data(), static_cast<std::size_t>(v.size()));
  const auto triple = [](const Numbers<double>& s, std::size_t first) {
    return Vector3d(s[first], s[first + 1], s[first + 2]);
  };
  const Numbers<double> base = numbers<double>(is.blocks.front(), values);
  const Numbers<double> tool = numbers<double>(is.blocks.back(), values);
  arm.base_mm = triple(base, serial_chain::kX);
  arm.base_turn_rad = triple(base, serial_chain::kRx);
  arm.tool_mm = triple(tool, serial_chain::kX);
  arm.tool_turn_rad = triple(tool, serial_chain::kRx);
  for (std::size_t i = 0; i < arm.rows.size(); ++i) {
    SerialRow& row = arm.rows[i];
    const Numbers<double> s = numbers<double>(is.blocks[i + 1], values);
    if (row.form != RowForm::kOrigin) {
      row.theta_rad = s[serial_chain::kTheta];
      row.d_mm = s[serial_chain::kD];
      row.a_mm = s[serial_chain::kA];
      row.alpha_rad = s[serial_chain::kAlpha];
      row.beta_rad = s[serial_chain::kBeta];
      continue;
    }
    row.origin_mm = triple(s, serial_chain::kX);
    const Vector3d correction = triple(s, serial_chain::kRx);
    if (correction.isZero(0.0)) continue;
    row.turn_rad = rotation_vector(is.links[i].turn * turned_by<double>(correction));
  }
  return arm;
}

extern constinit const RobotKind serial{
    .name = "serial",
    .in_words = "arm of joints one after the other",
    .example = example,
    .from_file = serial_chain::from_file,
    .file_keys = serial_chain::kFileKeys,
    .to_file = serial_chain::to_file,
    .forward = frames_of,
    .forward_derivative = frame_derivatives,
    .inverse = joints_at,
};

}  // namespace sixdial::geometry
