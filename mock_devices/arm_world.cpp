#include "mock_devices/arm_world.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "mock_devices/iso_time.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPi = std::numbers::pi;
constexpr double kTwoPi = 2 * kPi;
constexpr double kBetweenRows_s = 12.0;
constexpr double kCold_c = 20.0;

constexpr std::array kCauses{
    ArmCause{"joint_backlash", 5e-5, 1e-3, "width [rad]"},
    ArmCause{"joint_eccentricity", 1e-4, 2e-3, "amplitude [rad]"},
    ArmCause{"joint_second_harmonic", 5e-5, 1e-3, "amplitude [rad]"},
    ArmCause{"joint_gain", 1e-4, 2e-3, "gain [1]"},
    ArmCause{"joint_curve", 5e-5, 5e-4, "rms [rad]"},
    ArmCause{"joint_coupling", 1e-4, 2e-3, "share [1]"},
    ArmCause{"joint_gravity_compliance", 5e-5, 1e-3, "sag for each metre [rad/m]"},
    ArmCause{"instrument_drift", 0.02, 0.5, "speed [mm/h]"},
    ArmCause{"instrument_step", 0.02, 0.5, "shift [mm]"},
    ArmCause{"instrument_scale", 1e-4, 2e-3, "scale [1]"},
    ArmCause{"frame_skew", 1e-4, 2e-3, "skew [rad]"},
    ArmCause{"link_thermal_growth", 5e-6, 1e-4, "coefficient [1/K]"}};

std::string joint_name(std::size_t j) { return "joint" + std::to_string(j + 1); }

/// Index of "joint3" or of one of "joint3,joint5"; -1: none.
int joint_at(std::string_view where) {
  if (!where.starts_with("joint")) return -1;
  return std::stoi(std::string(where.substr(5))) - 1;
}

Eigen::Isometry3d step(const DhRow& row, double q) {
  return Eigen::AngleAxisd(q + row.theta_rad, Vector3d::UnitZ()) *
         Eigen::Translation3d(0, 0, row.d_mm) * Eigen::Translation3d(row.a_mm, 0, 0) *
         Eigen::AngleAxisd(row.alpha_rad, Vector3d::UnitX());
}

/// Any direction, by the seed and a counter.
Vector3d any_direction(const Random& random, std::uint64_t counter) {
  return Vector3d(
             random.normal(counter), random.normal(counter + 1), random.normal(counter + 2))
      .normalized();
}

/// The arm at one instant.
class Arm {
 public:
  explicit Arm(const ArmWorld& world) : world_(world), random_(world.seed, Stream::kHide) {}

  [[nodiscard]] Vector3d seen(const ArmRow& row, const VectorXd& approach, int index) const {
    VectorXd q = row.q_rad;
    for (const ArmEffect& each : world_.effects) turn(each, approach, row.q_rad, q);
    for (const ArmEffect& each : world_.effects) {
      if (each.cause == "joint_gravity_compliance") sag(each, row.q_rad, q);
    }
    double growth = 1.0;
    for (const ArmEffect& each : world_.effects) {
      if (each.cause == "link_thermal_growth") {
        growth += each.amplitude * (row.temperature_c - kCold_c);
      }
    }
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translate(world_.base_mm);
    const double turned = world_.base_turn_rad.norm();
    if (turned > 0) X.rotate(Eigen::AngleAxisd(turned, world_.base_turn_rad / turned));
    for (std::size_t j = 0; j < world_.actual.size(); ++j) {
      DhRow link = world_.actual[j];
      link.a_mm *= growth;
      link.d_mm *= growth;
      X = X * step(link, q[static_cast<Eigen::Index>(j)]);
    }
    Vector3d p = X * world_.tool_mm;
    for (const ArmEffect& each : world_.effects) look(each, row, index, p);
    return p;
  }

  int steps_ = 1;  // rows of the session

 private:
  /// What is wrong with a joint, by what its encoder says.
  void turn(const ArmEffect& each, const VectorXd& approach, const VectorXd& read, VectorXd& q)
      const {
    const Eigen::Index j = joint_at(each.where);
    if (j < 0) return;
    const double at = read[j];
    const double phase = random_.uniform(10 + static_cast<std::uint64_t>(j), 0.0, kTwoPi);
    if (each.cause == "joint_backlash") q[j] -= approach[j] * each.amplitude / 2;
    if (each.cause == "joint_eccentricity") q[j] += each.amplitude * std::sin(at + phase);
    if (each.cause == "joint_second_harmonic")
      q[j] += each.amplitude * std::sin(2 * at + phase);
    if (each.cause == "joint_gain") q[j] += each.amplitude * at;
    if (each.cause == "joint_curve") q[j] += each.amplitude * curve(static_cast<int>(j), at);
    if (each.cause == "joint_coupling") {
      const std::string_view where = each.where;
      q[j] += each.amplitude * read[joint_at(where.substr(where.find(',') + 1))];
    }
  }

  /// A joint gives by the moment about its axis of the links behind it, each with its mass in
  /// its middle, heavier near the base, and of the tool.
  void sag(const ArmEffect& each, const VectorXd& read, VectorXd& q) const {
    const Eigen::Index joint = joint_at(each.where);
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  // upright on its base
    Vector3d axis = Vector3d::UnitZ();
    Vector3d origin = Vector3d::Zero();
    Vector3d moment = Vector3d::Zero();
    for (std::size_t j = 0; j < world_.actual.size(); ++j) {
      const auto at = static_cast<Eigen::Index>(j);
      if (at == joint) {
        axis = X.rotation().col(2);
        origin = X.translation();
      }
      const Vector3d begin = X.translation();
      X = X * step(world_.actual[j], read[at]);
      const double mass = 1.0 / (1.0 + static_cast<double>(j));
      if (at >= joint) {
        const Vector3d middle = (begin + X.translation()) / 2;
        moment += mass * (middle - origin).cross(Vector3d(0, 0, -1e-3));
      }
    }
    moment += 0.5 * (X * world_.tool_mm - origin).cross(Vector3d(0, 0, -1e-3));
    q[joint] += each.amplitude * moment.dot(axis);
  }

  /// Waves three to twenty-four a turn, the faster the smaller; rms 1.
  [[nodiscard]] double curve(int joint, double at) const {
    constexpr int kFirst = 3;
    constexpr int kLast = 24;
    double sum = 0.0;
    double squares = 0.0;
    for (int k = kFirst; k <= kLast; ++k) {
      const auto counter = static_cast<std::uint64_t>(1000 + 100 * joint + 2 * k);
      const double size = random_.normal(counter) / k;
      sum += size * std::sin(k * at + random_.uniform(counter + 1, 0.0, kTwoPi));
      squares += size * size / 2;
    }
    return sum / std::sqrt(squares);
  }

  /// What is wrong with the instrument or its frame.
  void look(const ArmEffect& each, const ArmRow& row, int index, Vector3d& p) const {
    constexpr double kTurnPerShift = 2e-3;  // rad for each mm
    const Vector3d way = any_direction(random_, 300);
    const Vector3d axis = any_direction(random_, 310);
    if (each.cause == "instrument_drift") {
      const double moved = each.amplitude * row.time_s / 3600.0;
      p += moved * way + kTurnPerShift * moved * axis.cross(p) * 0.1;
    }
    if (each.cause == "instrument_step") {
      const double when = random_.uniform(320, 0.3, 0.7);
      if (index >= when * steps_) p += each.amplitude * way;
    }
    if (each.cause == "instrument_scale") p *= 1.0 + each.amplitude;
    if (each.cause == "frame_skew") {
      p += each.amplitude * Vector3d(way.x() * p.y() + way.y() * p.z(), way.z() * p.z(), 0.0);
    }
  }

  const ArmWorld& world_;
  Random random_;
};

}  // namespace

ArmWorld drawn_arm(std::uint64_t seed, int joints) {
  const Random random(seed, Stream::kRobot);
  ArmWorld world;
  world.seed = seed;
  const int n = joints > 0 ? joints : 4 + static_cast<int>(random.uniform(0) * 4.0);
  const double scale = random.uniform(1, 0.6, 1.6);
  std::uint64_t next = 2;
  const auto any = [&](double low, double high) { return random.uniform(next++, low, high); };
  for (int j = 0; j < n; ++j) {
    DhRow row;
    // Two links of an arm have parallel axes, a wrist's axes meet at right angles.
    const bool parallel = j == 1 || (j == 2 && n > 4 && any(0, 1) < 0.5);
    row.alpha_rad = parallel ? 0.0 : (any(0, 1) < 0.5 ? kPi / 2 : -kPi / 2);
    row.a_mm =
        parallel ? scale * any(250, 600) : (any(0, 1) < 0.4 ? scale * any(20, 120) : 0.0);
    row.d_mm = parallel ? scale * any(-60, 60) : scale * any(60, 320);
    if (j + 1 == n) row.alpha_rad = 0.0;
    world.nominal.push_back(row);
    row.a_mm += 0.5 * random.normal(next++);
    row.d_mm += 0.5 * random.normal(next++);
    row.alpha_rad += 2e-3 * random.normal(next++);
    row.theta_rad += 4e-3 * random.normal(next++);
    world.actual.push_back(row);
  }
  world.tool_nominal_mm = scale * Vector3d(any(20, 80), any(-40, 40), any(40, 120));
  for (int axis = 0; axis < 3; ++axis) {
    world.tool_mm[axis] = world.tool_nominal_mm[axis] + 0.5 * random.normal(next++);
    world.base_mm[axis] = any(-2000, 2000);
    world.base_turn_rad[axis] = any(-1.5, 1.5);
  }
  world.range_rad = any(1.6, 2.8);
  world.noise_mm = std::exp(any(std::log(0.005), std::log(0.05)));
  return world;
}

std::span<const ArmCause> arm_causes() { return kCauses; }

std::vector<std::string> places_at_arm(const ArmWorld& world, std::string_view cause) {
  const std::size_t n = world.nominal.size();
  std::vector<std::string> result;
  if (cause == "joint_coupling") {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        if (i != j) result.push_back(joint_name(i) + "," + joint_name(j));
      }
    }
  } else if (cause.starts_with("joint_")) {
    // The first axis stands upright and carries no weight.
    const bool by_weight = cause == "joint_gravity_compliance";
    for (std::size_t j = by_weight ? 1 : 0; j < n; ++j) result.push_back(joint_name(j));
  } else if (cause.starts_with("instrument_")) {
    result = {"instrument"};
  } else {
    result = {cause == "frame_skew" ? "frame" : "links"};
  }
  return result;
}

ArmEffect make_arm_effect(
    const ArmWorld& world, std::string_view cause, std::string_view where, double amplitude) {
  const bool known = std::ranges::find(kCauses, cause, &ArmCause::id) != kCauses.end();
  const std::vector<std::string> places = places_at_arm(world, cause);
  if (!known || std::ranges::find(places, where) == places.end()) {
    throw std::invalid_argument(fmt::format("an arm has no cause '{}' at '{}'", cause, where));
  }
  return {std::string(cause), std::string(where), amplitude};
}

ArmEffect draw_arm_effect(const ArmWorld& world, std::uint64_t seed) {
  const Random random(seed, Stream::kHide, 1);
  const auto pick = [&](std::uint64_t counter, std::size_t count) {
    const double at = random.uniform(counter) * static_cast<double>(count);
    return std::min(count - 1, static_cast<std::size_t>(at));
  };
  const ArmCause& cause = kCauses[pick(0, kCauses.size())];
  const std::vector<std::string> places = places_at_arm(world, cause.id);
  const double size = std::exp(random.uniform(2, std::log(cause.least), std::log(cause.most)));
  return {std::string(cause.id), places[pick(1, places.size())], size};
}

Vector3d seen_tool(
    const ArmWorld& world, const ArmRow& row, const VectorXd& approach, int index, int rows) {
  Arm arm(world);
  arm.steps_ = rows;
  return arm.seen(row, approach, index);
}

Vector3d tool_of_arm(const ArmWorld& world, const VectorXd& q_rad) {
  ArmRow row;
  row.temperature_c = kCold_c;
  row.q_rad = q_rad;
  return Arm(world).seen(row, VectorXd::Zero(q_rad.size()), 0);
}

std::vector<ArmRow> measure_arm(const ArmWorld& world, int g1, int g2) {
  Arm arm(world);
  arm.steps_ = g1 + g2;
  const Random plan(world.seed, Stream::kField);
  const Random noise(world.seed, Stream::kNoise);
  const Random scatter(world.seed, Stream::kNoise, 1);
  const auto n = static_cast<Eigen::Index>(world.nominal.size());
  std::vector<ArmRow> rows;
  VectorXd before = VectorXd::Zero(n);
  for (int i = 0; i < g1 + g2; ++i) {
    ArmRow row;
    row.set = i < g1 ? "G1" : "G2";
    row.point = i < g1 ? i : i - g1;
    row.time_s = kBetweenRows_s * i;
    row.temperature_c = kCold_c + world.warm_up_c * (1 - std::exp(-row.time_s / 1500.0));
    row.q_rad.resize(n);
    VectorXd approach(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto counter = static_cast<std::uint64_t>(i * n + j);
      row.q_rad[j] = plan.uniform(counter, -world.range_rad, world.range_rad);
      approach[j] = row.q_rad[j] > before[j] ? 1.0 : -1.0;
    }
    row.q_command_rad = row.q_rad;
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto counter = static_cast<std::uint64_t>(2 * (i * n + j));
      row.q_rad[j] += world.stop_scatter_rad * scatter.normal(counter);
    }
    row.p_mm = arm.seen(row, approach, i);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto counter = static_cast<std::uint64_t>(2 * (i * n + j) + 1);
      row.q_rad[j] += world.read_scatter_rad * scatter.normal(counter);
    }
    for (int axis = 0; axis < 3; ++axis) {
      row.p_mm[axis] += world.noise_mm * noise.normal(static_cast<std::uint64_t>(3 * i + axis));
    }
    before = row.q_command_rad;
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string arm_robot_text(
    const ArmWorld& world, const std::string& more, std::optional<double> range_rad) {
  std::string text = fmt::format(
      "[robot]\nmodel = \"serial\"\nconvention = \"dh\"\n"
      "tool_x_mm = {}\ntool_y_mm = {}\ntool_z_mm = {}\n{}",
      world.tool_nominal_mm.x(), world.tool_nominal_mm.y(), world.tool_nominal_mm.z(), more);
  for (const DhRow& row : world.nominal) {
    text += fmt::format(
        "\n[[joint]]\na_mm = {}\nalpha_deg = {}\nd_mm = {}\n", row.a_mm,
        row.alpha_rad * 180.0 / kPi, row.d_mm);
    if (range_rad) {
      const double deg = *range_rad * 180.0 / kPi;
      text += fmt::format("low_deg = {:.1f}\nhigh_deg = {:.1f}\n", -deg, deg);
    }
  }
  return text;
}

void write_arm_bundle(
    const std::filesystem::path& folder, const std::vector<ArmRow>& rows,
    const ArmWorld& world) {
  std::filesystem::create_directories(folder);
  std::ofstream rig(folder / "rig.toml");
  rig << "name = \"an arm\"\n\n" << arm_robot_text(world);
  rig << fmt::format(
      "\n[instrument]\nkind = \"position\"\ndimensions = 3\nsd_mm = {:.6f}\n", world.noise_mm);
  const std::int64_t start = milliseconds_of("2026-03-02T08:30:00.000Z");
  std::ofstream csv(folder / "session.csv");
  csv << "set,point,repeat,time_utc,temperature_c";
  for (std::size_t j = 0; j < world.nominal.size(); ++j) csv << ",q" << j + 1 << "_rad";
  for (std::size_t j = 0; world.writes_commands && j < world.nominal.size(); ++j) {
    csv << ",q" << j + 1 << "_command_rad";
  }
  csv << ",x_mm,y_mm,z_mm\n";
  for (const ArmRow& row : rows) {
    csv << fmt::format(
        "{},{},0,{},{:.2f}", row.set, row.point,
        iso8601(start + std::llround(1000 * row.time_s)), row.temperature_c);
    for (const double q : row.q_rad) csv << fmt::format(",{:.9f}", q);
    if (world.writes_commands) {
      for (const double q : row.q_command_rad) csv << fmt::format(",{:.9f}", q);
    }
    for (const double p : row.p_mm) csv << fmt::format(",{:.5f}", p);
    csv << '\n';
  }
}

}  // namespace sixdial::mock_devices
