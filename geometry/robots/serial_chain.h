// How an arm's model keeps its rows, for the sources of the kind `serial` alone: the numbers of
// base, links and tool, each constant or a parameter, and the one function that makes a link's
// pose of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/robots/serial.h"
#include "geometry/rotation.h"

namespace sixdial::geometry::serial_chain {

inline constexpr std::size_t kSlots = 6;

/// Numbers of the base, of one link or of the tool: parameters where `parameter` is not -1.
struct Block {
  std::array<double, kSlots> constant{};
  std::array<int, kSlots> parameter{-1, -1, -1, -1, -1, -1};
};

enum DhSlot : std::size_t { kTheta, kD, kA, kAlpha, kBeta };
enum FrameSlot : std::size_t { kX, kY, kZ, kRx, kRy, kRz };  // base, origins, tool

struct Link {
  SerialRow row;
  std::size_t joint = 0;                               // whose value moves it
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // of an origin, before its correction
  int axis_number = -1;                                // 0..2 where the axis is x, y or z
};

struct Details {
  SerialRobot robot;
  std::vector<Link> links;
  std::vector<Block> blocks;  // base, links, tool
};

[[nodiscard]] inline const Details& details_of(const RobotModel& robot) {
  return *static_cast<const Details*>(robot.details.get());
}

template <typename T>
using Numbers = std::array<T, kSlots>;

template <typename T>
Pose<T> frame_pose(const Numbers<T>& s) {
  return {{s[kX], s[kY], s[kZ]}, turned_by<T>({s[kRx], s[kRy], s[kRz]})};
}

/// Of a Denavit-Hartenberg row. R v means: a shift along the frame's own axis.
template <typename T>
Pose<T> dh_pose(const Link& link, const Numbers<T>& s, const T& q) {
  const bool turns = link.row.kind == JointKind::kRevolute;
  const T theta = turns ? s[kTheta] + q : s[kTheta];
  const T d = turns ? s[kD] : s[kD] + q;
  Pose<T> X;
  X.p.setConstant(T(0.0));
  const auto along = [&](int axis, const T& length) { X.p += X.R.col(axis) * length; };
  if (link.row.form == RowForm::kDh) {
    turn_about<T>(X.R, 2, theta);
    along(2, d);
    along(0, s[kA]);
    turn_about<T>(X.R, 0, s[kAlpha]);
    turn_about<T>(X.R, 1, s[kBeta]);
  } else {
    along(0, s[kA]);
    turn_about<T>(X.R, 0, s[kAlpha]);
    turn_about<T>(X.R, 1, s[kBeta]);
    turn_about<T>(X.R, 2, theta);
    along(2, d);
  }
  return X;
}

template <typename T>
Pose<T> origin_pose(const Link& link, const Numbers<T>& s, const T& q) {
  Pose<T> X;
  X.p << s[kX], s[kY], s[kZ];
  X.R = link.turn.template cast<T>() * turned_by<T>({s[kRx], s[kRy], s[kRz]});
  const Eigen::Matrix<T, 3, 1> axis = link.row.axis.template cast<T>();
  if (link.row.kind == JointKind::kPrismatic) {
    X.p += X.R * axis * q;
  } else if (link.axis_number >= 0) {
    turn_about<T>(X.R, link.axis_number, q);
  } else {
    X.R = (X.R * turned_by<T>(axis * q)).eval();
  }
  return X;
}

/// The link's pose in the frame before it. q: the value of the joint that moves it.
template <typename T>
Pose<T> link_pose(const Link& link, const Numbers<T>& s, const T& joint) {
  const T q = link.row.follows.empty() ? joint : joint * T(link.row.ratio) + T(link.row.offset);
  return link.row.form == RowForm::kOrigin ? origin_pose<T>(link, s, q)
                                           : dh_pose<T>(link, s, q);
}

template <typename T>
Numbers<T> numbers(const Block& block, std::span<const T> v) {
  Numbers<T> result;
  for (std::size_t i = 0; i < kSlots; ++i) {
    const int at = block.parameter[i];
    result[i] = at < 0 ? T(block.constant[i]) : v[static_cast<std::size_t>(at)];
  }
  return result;
}

template <typename T>
Pose<T> behind(const Pose<T>& a, const Pose<T>& b) {
  return {a.p + a.R * b.p, a.R * b.R};
}

/// The whole arm for any number type: what its derivatives are held against.
struct Serial {
  template <typename T>
  static Reached frames(
      const RobotModel& robot, std::span<const T> v, std::span<const T> q, Assembly,
      std::span<Pose<T>> X) {
    const Details& is = details_of(robot);
    Pose<T> at = frame_pose<T>(numbers<T>(is.blocks.front(), v));
    for (std::size_t i = 0; i < is.links.size(); ++i) {
      at = behind<T>(
          at, link_pose<T>(is.links[i], numbers<T>(is.blocks[i + 1], v), q[is.links[i].joint]));
      X[i + 1] = at;
    }
    X[0] = behind<T>(at, frame_pose<T>(numbers<T>(is.blocks.back(), v)));
    return {};
  }
};

/// Keys of [robot] beside those of the parameters.
inline constexpr std::array<std::string_view, 18> kFileKeys{
    "convention", "urdf",      "base",      "tip",         "tool",        "parameters",
    "base_x_mm",  "base_y_mm", "base_z_mm", "base_rx_deg", "base_ry_deg", "base_rz_deg",
    "tool_x_mm",  "tool_y_mm", "tool_z_mm", "tool_rx_deg", "tool_ry_deg", "tool_rz_deg"};

// What a row of a rig file and a joint of a URDF are held to.

/// A name that a column of a session file can have.
[[nodiscard]] inline bool can_name_a_joint(std::string_view name) {
  const auto parts_columns = [](char each) {
    return each == ',' || each == '"' || static_cast<unsigned char>(each) <= ' ';
  };
  return !name.empty() && std::ranges::none_of(name, parts_columns);
}
/// Whether `high` stays above `low` when both are written in another unit and read again.
[[nodiscard]] inline bool is_range(double low, double high) {
  constexpr double kLeast = 1e-9;  // of the larger one, or of 1 [rad or mm]
  return high - low > kLeast * std::max({1.0, std::abs(low), std::abs(high)});
}
/// The unit vector along an axis of any length; nothing where it has no direction.
[[nodiscard]] inline std::optional<Eigen::Vector3d> unit_axis(const Eigen::Vector3d& axis) {
  constexpr double kShortest = 1e-9;
  const double length = axis.stableNorm();
  if (!axis.allFinite() || !(length > kShortest)) return std::nullopt;
  if (std::abs(length - 1.0) <= 1e-12) return axis;  // as it was written
  return axis.stableNormalized();
}

/// What the rows of [[joint]] and the keys of [robot] make of it, and back (serial_file.cpp).
[[nodiscard]] tl::expected<std::shared_ptr<const RobotModel>, RobotFileFault> from_file(
    const RobotFile& file);
[[nodiscard]] RobotFileText to_file(const RobotModel& robot, const Eigen::VectorXd& nominal);

/// Which numbers of the blocks become parameters, by name (serial_parameters.cpp).
void choose_parameters(RobotModel& robot, Details& details);

}  // namespace sixdial::geometry::serial_chain
