#include "mock_devices/world.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "geometry/units.h"
#include "mock_devices/random.h"
#include "mock_devices/smooth_field.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;
using geometry::kRadPerDeg;
using geometry::ParameterVector;

constexpr double kMostCurve_mm = 0.006;
constexpr std::size_t kCurveWaves = 4;

/// A row of the causes with its place and numbers on this rig.
struct Hidden {
  const CauseRow* row;
  ReadyEffect effect;
};

}  // namespace

TrueRobot drawn_robot(const geometry::Rig& rig, std::uint64_t seed) {
  const Random random(seed, Stream::kRobot);
  TrueRobot robot{rig.robot.nominal, 0.0};
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    double spread = 0.6;
    if (i == geometry::kX0 || i == geometry::kY0) spread = 1.0;
    if (i == geometry::kAlpha) spread = 0.3 * kRadPerDeg;
    if (i == geometry::kOffset1 || i == geometry::kOffset2) spread = 1.0 * kRadPerDeg;
    // A coaxial robot (d = 0) stays one.
    if (i == geometry::kD && rig.robot.nominal[i] == 0.0) continue;
    robot.parameters[i] += random.uniform(static_cast<std::uint64_t>(i), -spread, spread);
  }
  robot.clamp_rad = Random(seed, Stream::kClamp).uniform(0, -kRadPerDeg, kRadPerDeg);
  return robot;
}

struct WorldModel::Parts {
  World world;
  double reference_angle_rad = 0.0;
  std::vector<Hidden> effects;
  bool compliant = false;
  Vector2d compliance_rad_per_nmm = Vector2d::Zero();
  std::optional<SmoothField> warp;
  struct Curve {
    std::array<double, kCurveWaves> weight_mm, phase;
  };
  std::vector<Curve> curves;
  std::vector<double> end_stop_mm;

  [[nodiscard]] Vector2d true_angles(const Moment& moment) const;
  struct Arm {
    Vector2d p_WE;
    double gamma_rad;
  };
  [[nodiscard]] std::optional<Arm> arm(const Vector2d& theta, const Moment& moment) const;
  [[nodiscard]] std::vector<std::optional<Push>> pushes(const Arm& arm) const;
  [[nodiscard]] double curve_mm(std::size_t dial, double displacement_mm) const;
  [[nodiscard]] double spring_energy_Nmm(const Arm& arm) const;
  [[nodiscard]] std::optional<Vector2d> torque_Nmm(
      const Vector2d& theta, const Moment& moment) const;
};

Vector2d WorldModel::Parts::true_angles(const Moment& moment) const {
  Vector2d theta = moment.q_rad;
  for (const auto& [row, effect] : effects) {
    if (row->turn_joints) row->turn_joints(effect, moment, moment.q_rad, theta);
  }
  return theta;
}

std::optional<WorldModel::Parts::Arm> WorldModel::Parts::arm(
    const Vector2d& theta, const Moment& moment) const {
  ArmChange changed{world.robot.parameters, 0.0};
  for (const auto& [row, effect] : effects) {
    if (row->change_arm) row->change_arm(effect, moment, changed);
  }
  const auto pose = geometry::forward(changed.v, theta, moment.assembly);
  if (!pose) return std::nullopt;
  const double clamp = world.robot.clamp_rad + changed.clamp_rad;
  Arm arm{pose->p_WE, geometry::cuboid_angle(world.rig, reference_angle_rad, *pose, clamp)};
  const Vector2d p = pose->p_WE;
  for (const auto& [row, effect] : effects) {
    if (row->shift_tool) row->shift_tool(effect, moment, world.rig, p, arm.p_WE);
  }
  if (warp) arm.p_WE += warp->at(p);
  arm.p_WE += moment.scatter_mm;
  return arm;
}

std::vector<std::optional<Push>> WorldModel::Parts::pushes(const Arm& arm) const {
  CuboidChange it{world.rig.cuboid.side_mm, 0.0, 0.0, arm.p_WE};
  for (const auto& [row, effect] : effects) {
    if (row->change_cuboid) row->change_cuboid(effect, arm.gamma_rad, it);
  }
  const CuboidOutline outline(it.centre_mm, arm.gamma_rad, it.side_mm, it.shear_rad);
  std::vector<std::optional<Push>> result;
  result.reserve(world.rig.dials.size());
  for (std::size_t i = 0; i < world.rig.dials.size(); ++i) {
    const geometry::DialGeometry& dial = world.rig.dials[i].geometry;
    Plunger plunger{dial.position_mm, dial.axis, dial.tip_radius_mm + it.tip_radius_mm};
    for (const auto& [row, effect] : effects) {
      if (!row->change_plunger || effect.dial != static_cast<int>(i)) continue;
      row->change_plunger(effect, dial, plunger);
    }
    result.push_back(push_of(outline, plunger, dial.travel_mm));
  }
  return result;
}

/// What the plungers' springs have stored: force_n at first touch, more as they go in.
double WorldModel::Parts::spring_energy_Nmm(const Arm& arm) const {
  double energy = 0.0;
  const auto pushed = pushes(arm);
  for (std::size_t i = 0; i < pushed.size(); ++i) {
    if (!pushed[i]) continue;
    const geometry::Dial& dial = world.rig.dials[i];
    const double in_mm = std::min(pushed[i]->displacement_mm, dial.geometry.travel_mm);
    energy += dial.force_n * in_mm + dial.spring_n_per_mm * in_mm * in_mm / 2;
  }
  return energy;
}

/// Of the springs on the joints: they give back by -dU/dtheta what is pushed into them.
std::optional<Vector2d> WorldModel::Parts::torque_Nmm(
    const Vector2d& theta, const Moment& moment) const {
  constexpr double kStep_rad = 1e-5;
  Vector2d torque;
  for (int joint = 0; joint < 2; ++joint) {
    const Vector2d step = kStep_rad * Vector2d::Unit(joint);
    const auto ahead = arm(theta + step, moment);
    const auto behind = arm(theta - step, moment);
    if (!ahead || !behind) return std::nullopt;
    torque[joint] = (spring_energy_Nmm(*behind) - spring_energy_Nmm(*ahead)) / (2 * kStep_rad);
  }
  return torque;
}

double WorldModel::Parts::curve_mm(std::size_t dial, double displacement_mm) const {
  const Curve& curve = curves[dial];
  const double turn = kTwoPi * displacement_mm / world.rig.dials[dial].geometry.travel_mm;
  double sum = 0.0;
  for (std::size_t m = 0; m < kCurveWaves; ++m) {
    sum += curve.weight_mm[m] * std::sin(static_cast<double>(m + 1) * turn + curve.phase[m]);
  }
  return sum;
}

WorldModel::WorldModel(const World& world) {
  auto parts = std::make_unique<Parts>();
  parts->world = world;
  const DialHabits& habits = world.dials;
  if (!(habits.noise_sd_mm >= 0.0) || !(habits.quantum_mm >= 0.0) ||
      !(habits.hysteresis_mm >= 0.0) || !(habits.curve_mm >= 0.0) ||
      habits.curve_mm > kMostCurve_mm) {
    throw std::invalid_argument(
        "dial habits: no figure may be negative, and the error curve at most 0.006 mm");
  }
  const geometry::Robot& robot = world.rig.robot;
  const auto q =
      geometry::inverse(robot.nominal, world.rig.cuboid.reference_pose_mm, robot.working_mode);
  const auto reference = geometry::reference_link_angle(world.rig);
  if (!q || !reference) {
    throw std::invalid_argument(fmt::format(
        "the nominal robot cannot take the cuboid's reference pose ({}, {}): {}",
        world.rig.cuboid.reference_pose_mm.x(), world.rig.cuboid.reference_pose_mm.y(),
        geometry::describe(q ? reference.error() : q.error())));
  }
  parts->reference_angle_rad = *reference;
  for (const HiddenEffect& effect : world.effects) {
    const CauseRow& row = cause_row(effect.cause);
    parts->effects.push_back({&row, made_ready(effect, world.rig, *q)});
    if (!row.compliance) continue;
    parts->compliant = true;
    parts->compliance_rad_per_nmm += row.compliance(parts->effects.back().effect);
  }
  if (world.warp.amplitude_mm != 0.0) {
    parts->warp = SmoothField::of_wavelength(
        world.warp.amplitude_mm, world.warp.wavelength_mm, world.seed);
  }
  for (std::size_t i = 0; i < world.rig.dials.size(); ++i) {
    const Random curve(world.seed, Stream::kCurve, static_cast<std::uint32_t>(i));
    Parts::Curve made{};
    double total = 0.0;
    for (std::size_t m = 0; m < kCurveWaves; ++m) {
      made.weight_mm[m] = curve.uniform(2 * m) / static_cast<double>(m + 1);
      made.phase[m] = curve.uniform(2 * m + 1, 0.0, kTwoPi);
      total += made.weight_mm[m];
    }
    for (double& weight : made.weight_mm) weight *= habits.curve_mm / total;
    parts->curves.push_back(made);
    parts->end_stop_mm.push_back(
        Random(world.seed, Stream::kEndStop, static_cast<std::uint32_t>(i))
            .uniform(0, -0.02, 0.02));
  }
  parts_ = std::move(parts);
}

WorldModel::~WorldModel() = default;
WorldModel::WorldModel(WorldModel&&) noexcept = default;
WorldModel& WorldModel::operator=(WorldModel&&) noexcept = default;

const World& WorldModel::world() const { return parts_->world; }

double WorldModel::temperature_c(double time_s) const {
  const WarmUp& warm_up = parts_->world.warm_up;
  return warm_up.start_c - warm_up.rise_c * std::expm1(-std::max(0.0, time_s) / warm_up.tau_s);
}

std::optional<TruePose> WorldModel::pose(const Moment& moment) const {
  const Vector2d unloaded = parts_->true_angles(moment);
  Vector2d theta = unloaded;
  auto arm = parts_->arm(theta, moment);
  if (!arm) return std::nullopt;
  auto pushes = parts_->pushes(*arm);
  if (parts_->compliant) {
    // The joints yield until the springs of the plungers and of the joints balance; the forces
    // hardly change on the way, so this converges fast.
    constexpr int kRounds = 4;
    for (int round = 0; round < kRounds; ++round) {
      const auto torque = parts_->torque_Nmm(theta, moment);
      if (!torque) return std::nullopt;
      theta = unloaded + parts_->compliance_rad_per_nmm.cwiseProduct(*torque);
      arm = parts_->arm(theta, moment);
      if (!arm) return std::nullopt;
    }
    pushes = parts_->pushes(*arm);
  }
  return TruePose{arm->p_WE, arm->gamma_rad, theta, std::move(pushes)};
}

std::optional<Vector2d> WorldModel::tool(const Moment& moment) const {
  const auto arm = parts_->arm(parts_->true_angles(moment), moment);
  if (!arm) return std::nullopt;
  return arm->p_WE;
}

double WorldModel::shown_mm(
    std::size_t dial, double displacement_mm, int direction, const Moment& moment,
    bool with_habits) const {
  double value = displacement_mm;
  for (const auto& [row, effect] : parts_->effects) {
    if (!row->error_mm || effect.dial != static_cast<int>(dial)) continue;
    value += row->error_mm(effect, moment, displacement_mm, direction);
  }
  if (with_habits) {
    value -= parts_->world.dials.hysteresis_mm / 2 * direction;  // it lags
    value += parts_->curve_mm(dial, displacement_mm);
  }
  return value;
}

double WorldModel::noise_mm(std::size_t dial, std::uint64_t counter) const {
  if (parts_->world.dials.noise_sd_mm == 0.0) return 0.0;
  const Random random(parts_->world.seed, Stream::kNoise, static_cast<std::uint32_t>(dial));
  return parts_->world.dials.noise_sd_mm * random.normal(counter);
}

double WorldModel::quantised_mm(double value_mm) const {
  const double quantum = parts_->world.dials.quantum_mm;
  return quantum > 0.0 ? std::round(value_mm / quantum) * quantum : value_mm;
}

double WorldModel::end_stop_mm(std::size_t dial) const {
  return quantised_mm(parts_->end_stop_mm[dial]);
}

std::size_t WorldModel::wired_to(std::size_t name) const {
  int dial = static_cast<int>(name);
  for (const auto& [row, effect] : parts_->effects) {
    if (!row->swaps_cables) continue;
    if (dial == effect.dial) {
      dial = effect.other_dial;
    } else if (dial == effect.other_dial) {
      dial = effect.dial;
    }
  }
  return static_cast<std::size_t>(dial);
}

double WorldModel::gross_error_mm(std::size_t dial, std::int64_t sample) const {
  double error_mm = 0.0;
  for (const auto& [row, effect] : parts_->effects) {
    if (row->gross_mm) error_mm += row->gross_mm(effect, dial, sample);
  }
  return error_mm;
}

bool WorldModel::is_stale(std::size_t dial, std::int64_t sample) const {
  return std::ranges::any_of(parts_->effects, [&](const Hidden& hidden) {
    return hidden.row->is_stale && hidden.row->is_stale(hidden.effect, dial, sample);
  });
}

}  // namespace sixdial::mock_devices
