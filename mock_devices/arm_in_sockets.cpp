#include "mock_devices/arm_in_sockets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "geometry/robots/serial.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLength_mm = 0.5;
constexpr double kBetweenAxes_rad = 1e-3;
constexpr double kZero_rad = 5e-3;
constexpr double kSocket_mm = 3.0;

/// d(ball)/d(encoders), by differences.
Eigen::Matrix3Xd slope_at(const ArmWorld& world, const VectorXd& q_rad) {
  constexpr double kStep_rad = 1e-6;
  Eigen::Matrix3Xd slope(3, q_rad.size());
  for (Index j = 0; j < q_rad.size(); ++j) {
    VectorXd more = q_rad;
    VectorXd less = q_rad;
    more[j] += kStep_rad;
    less[j] -= kStep_rad;
    slope.col(j) = (tool_of_arm(world, more) - tool_of_arm(world, less)) / (2 * kStep_rad);
  }
  return slope;
}

/// The joints turn as little as they have to.
VectorXd led_to(const ArmWorld& world, const Vector3d& ball_mm, VectorXd q_rad) {
  constexpr int kSteps = 50;
  constexpr double kThere_mm = 1e-9;
  for (int step = 0; step < kSteps; ++step) {
    const Vector3d missing = ball_mm - tool_of_arm(world, q_rad);
    if (missing.norm() < kThere_mm) return q_rad;
    q_rad += slope_at(world, q_rad).completeOrthogonalDecomposition().solve(missing);
  }
  throw std::invalid_argument(
      fmt::format("the arm cannot put its ball at ({})", fmt::join(ball_mm, ", ")));
}

/// Where the sockets truly are.
std::map<std::string, Vector3d> true_places(
    const ArmWorld& world, const geometry::Rig& rig, std::span<const SocketVisit> visits) {
  ArmWorld nominal = world;
  nominal.actual = nominal.nominal;
  nominal.tool_mm = nominal.tool_nominal_mm;
  nominal.effects.clear();
  const Random random(world.seed, Stream::kField);
  std::map<std::string, Vector3d> places;
  std::uint64_t next = 0;
  for (const geometry::ReferencePoint& socket : rig.instrument.sockets) {
    for (const SocketVisit& visit : visits) {
      if (visit.socket != socket.name || places.contains(socket.name)) continue;
      Vector3d place = tool_of_arm(nominal, visit.q_rad);
      for (double& each : place) each += kSocket_mm * random.normal(next++);
      places[socket.name] = place;
    }
  }
  for (const geometry::SocketDistance& known : rig.instrument.socket_distances) {
    if (!places.contains(known.first) || !places.contains(known.second)) continue;
    const Vector3d from = places[known.first];
    const Vector3d way = (places[known.second] - from).normalized();
    places[known.second] = from + (known.mm + known.sd_mm * random.normal(next++)) * way;
  }
  return places;
}

}  // namespace

ArmWorld arm_of_rig(const geometry::Rig& rig, std::uint64_t seed) {
  if (rig.robot.model->kind != &geometry::serial) {
    throw std::invalid_argument("the rig file's robot is no arm");
  }
  const geometry::SerialRobot arm = geometry::serial_robot(*rig.robot.model, rig.robot.nominal);
  const Random random(seed, Stream::kRobot);
  ArmWorld world;
  world.seed = seed;
  std::uint64_t next = 0;
  for (const geometry::SerialRow& row : arm.rows) {
    if (row.form != geometry::RowForm::kDh || row.kind != geometry::JointKind::kRevolute ||
        row.beta_rad != 0.0 || !row.follows.empty()) {
      throw std::invalid_argument(
          "the simulated arm has turning joints in the convention \"dh\", without beta_deg and "
          "follows");
    }
    DhRow link{row.a_mm, row.alpha_rad, row.d_mm, row.theta_rad};
    world.nominal.push_back(link);
    link.a_mm += kLength_mm * random.normal(next++);
    link.d_mm += kLength_mm * random.normal(next++);
    link.alpha_rad += kBetweenAxes_rad * random.normal(next++);
    link.theta_rad += kZero_rad * random.normal(next++);
    world.actual.push_back(link);
  }
  world.tool_nominal_mm = world.tool_mm = arm.tool_mm;
  for (double& each : world.tool_mm) each += kLength_mm * random.normal(next++);
  world.base_mm = arm.base_mm;
  world.base_turn_rad = arm.base_turn_rad;
  return world;
}

std::vector<VectorXd> seated(
    const ArmWorld& world, const geometry::Rig& rig, std::span<const SocketVisit> visits) {
  const auto places = true_places(world, rig, visits);
  const Random noise(world.seed, Stream::kNoise);
  std::vector<VectorXd> read;
  for (const SocketVisit& visit : visits) {
    const auto place = places.find(visit.socket);
    if (place == places.end()) {
      throw std::invalid_argument(fmt::format("the rig file has no socket '{}'", visit.socket));
    }
    Vector3d ball_mm = place->second;
    for (Index axis = 0; axis < 3; ++axis) {
      ball_mm[axis] += rig.instrument.sd_mm *
                       noise.normal(static_cast<std::uint64_t>(3 * std::ssize(read) + axis));
    }
    read.push_back(led_to(world, ball_mm, visit.q_rad));
  }
  return read;
}

}  // namespace sixdial::mock_devices
