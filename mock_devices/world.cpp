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

using Eigen::Matrix2d;
using Eigen::Vector2d;
using geometry::kRadPerDeg;
using geometry::ParameterVector;

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kReference_c = 20.0;
constexpr double kMostCurve_mm = 0.006;
constexpr std::size_t kCurveWaves = 4;

Vector2d direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

Vector2d turned(const Vector2d& a, double angle_rad) {
  const Vector2d u = direction(angle_rad);
  return {u.x() * a.x() - u.y() * a.y(), u.y() * a.x() + u.x() * a.y()};
}

/// A hidden effect made ready: numbers by position, place as an index.
struct Ready {
  Cause cause;
  std::size_t place = 0;        // joint or dial
  std::size_t other_place = 0;  // second dial of a pair
  std::string where;
  std::array<double, 4> p{};
  std::size_t table = 0;  // of fields or walks
};

/// What has crept by now: fast at first, and levelling off.
double crept(const Ready& e, double time_s) { return e.p[0] * -std::expm1(-time_s / e.p[1]); }

double number(const HiddenEffect& effect, const char* name, std::optional<double> otherwise) {
  const auto found = effect.parameters.find(name);
  if (found != effect.parameters.end()) return found->second;
  if (otherwise) return *otherwise;
  throw std::invalid_argument(
      fmt::format("{} at {} lacks its parameter '{}'", effect.cause, effect.where, name));
}

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
  Vector2d q_reference = Vector2d::Zero();
  std::vector<Ready> effects;
  bool compliant = false;
  Vector2d compliance_rad_per_nmm = Vector2d::Zero();
  std::optional<SmoothField> warp;
  std::vector<SmoothField> fields;
  std::vector<RandomWalk> walks;
  struct Curve {
    std::array<double, kCurveWaves> weight_mm, phase;
  };
  std::vector<Curve> curves;
  std::vector<double> end_stop_mm;

  [[nodiscard]] std::size_t dial_index(const std::string& id) const {
    if (const auto found = world.rig.find_dial(id)) return *found;
    throw std::invalid_argument(fmt::format("the rig has no dial '{}'", id));
  }
  [[nodiscard]] Ready made_ready(const HiddenEffect& effect);
  [[nodiscard]] Vector2d true_angles(const Moment& moment) const;
  struct Arm {
    Vector2d p_WE;
    double gamma_rad;
  };
  [[nodiscard]] std::optional<Arm> arm(const Vector2d& theta, const Moment& moment) const;
  [[nodiscard]] std::vector<std::optional<Push>> pushes(const Arm& arm) const;
  [[nodiscard]] double curve_mm(std::size_t dial, double displacement_mm) const;
};

Ready WorldModel::Parts::made_ready(const HiddenEffect& effect) {
  using enum Cause;
  const CauseInfo& info = cause_info(effect.cause);
  const std::vector<std::string> places = places_of(info, world.rig);
  if (std::ranges::find(places, effect.where) == places.end()) {
    throw std::invalid_argument(
        fmt::format("{} cannot be at '{}' on this rig", effect.cause, effect.where));
  }
  Ready ready{.cause = info.cause, .where = effect.where};
  if (effect.where == "joint2") ready.place = 1;
  if (info.places == PlaceKind::kDialPair) {
    const std::size_t comma = effect.where.find(',');
    ready.place = dial_index(effect.where.substr(0, comma));
    ready.other_place = dial_index(effect.where.substr(comma + 1));
  } else if (const auto dial = world.rig.find_dial(effect.where)) {
    ready.place = *dial;
  }
  const auto get = [&](const char* name, std::optional<double> otherwise = std::nullopt) {
    return number(effect, name, otherwise);
  };
  const auto seed = [&] { return static_cast<std::uint64_t>(get("seed", 1.0)); };
  switch (info.cause) {
    case kJointEccentricity:
    case kJointSecondHarmonic:
    case kJointFifthHarmonic:
      ready.p = {get("a_rad"), get("b_rad")};
      break;
    case kJointGain:
      ready.p = {
          get("gain"), get("mid_rad", q_reference[static_cast<Eigen::Index>(ready.place)])};
      break;
    case kJointBacklash:
      ready.p = {get("b_rad")};
      break;
    case kJointCompliance:
      compliant = true;
      compliance_rad_per_nmm +=
          Vector2d(1.0 / get("k1_nmm_per_rad"), 1.0 / get("k2_nmm_per_rad"));
      break;
    case kLinkThermalGrowth:
      ready.p = {get("per_k"), get("reference_c", kReference_c)};
      break;
    case kPassiveClearance:
      ready.p = {get("c_mm")};
      break;
    case kBaseDrift:
      ready.p = {get("x_mm_per_h"), get("y_mm_per_h")};
      break;
    case kFrameSkew:
    case kCuboidSquareness:
    case kDialLean:
      ready.p = {get("angle_rad")};
      break;
    case kCuboidSize:
    case kTipRadius:
    case kDialMount:
      ready.p = {get("change_mm")};
      break;
    case kCuboidOffset:
      ready.p = {get("x_mm"), get("y_mm")};
      break;
    case kDialGain:
      ready.p = {get("gain")};
      break;
    case kDialHysteresis:
      ready.p = {get("width_mm")};
      break;
    case kDialCyclic:
      ready.p = {get("amplitude_mm"), get("period_mm"), get("phase_rad", 0.0)};
      break;
    case kDialSwap:
      break;
    case kStep: {
      const bool angle = effect.where.starts_with("joint") || effect.where == "cuboid";
      ready.p = {
          get("from_sample"), get(angle ? "amount_rad" : "amount_mm"),
          get("direction_rad", 0.0)};
      break;
    }
    case kOutliers:
      ready.p = {get("share"), get("size_mm"), get("seed", 1.0)};
      break;
    case kStaleReading:
      ready.p = {get("share"), get("whole_scan", 1.0), get("seed", 1.0)};
      break;
    case kXyField:
      ready.table = fields.size();
      fields.push_back(SmoothField::of_length(get("rms_mm"), get("length_mm"), seed()));
      break;
    case kRandomWalk:
      ready.table = walks.size();
      walks.emplace_back(get("mm_per_sqrt_h"), seed());
      break;
    case kTimeSinusoid:
      ready.p = {
          get("amplitude_mm"), get("period_s"), get("phase_rad", 0.0),
          get("direction_rad", 0.0)};
      break;
    case kCreep:
      if (effect.where.starts_with("l")) {
        ready.place = effect.where == "l11"   ? 0U
                      : effect.where == "l12" ? 1U
                      : effect.where == "l21" ? 2U
                                              : 3U;
      }
      ready.p = {
          get(effect.where.starts_with("l") ? "amount_mm" : "amount_rad"), get("period_s")};
      break;
    case kDialBend:
      ready.p = {get("bend_mm")};
      break;
  }
  return ready;
}

Vector2d WorldModel::Parts::true_angles(const Moment& moment) const {
  using enum Cause;
  Vector2d theta = moment.q_rad;
  for (const Ready& e : effects) {
    const auto joint = static_cast<Eigen::Index>(e.place);
    const double q = joint < 2 ? moment.q_rad[joint] : 0.0;
    switch (e.cause) {
      case kJointEccentricity:
        theta[joint] += e.p[0] * std::sin(q) + e.p[1] * std::cos(q);
        break;
      case kJointSecondHarmonic:
        theta[joint] += e.p[0] * std::sin(2 * q) + e.p[1] * std::cos(2 * q);
        break;
      case kJointFifthHarmonic:
        theta[joint] += e.p[0] * std::sin(5 * q) + e.p[1] * std::cos(5 * q);
        break;
      case kJointGain:
        theta[joint] += e.p[0] * (q - e.p[1]);
        break;
      case kJointBacklash:
        theta[joint] -= e.p[0] / 2 * moment.approach[e.place];
        break;
      case kCreep:
        if (e.where.starts_with("joint")) theta[joint] += crept(e, moment.time_s);
        break;
      case kStep:
        if (e.where.starts_with("joint") && static_cast<double>(moment.sample) >= e.p[0]) {
          theta[joint] += e.p[1];
        }
        break;
      default:
        break;
    }
  }
  return theta;
}

std::optional<WorldModel::Parts::Arm> WorldModel::Parts::arm(
    const Vector2d& theta, const Moment& moment) const {
  using enum Cause;
  ParameterVector v = world.robot.parameters;
  double gamma_step = 0.0;
  for (const Ready& e : effects) {
    const bool stepped = e.cause == kStep && static_cast<double>(moment.sample) >= e.p[0];
    if (e.cause == kLinkThermalGrowth) {
      v.head<4>() *= 1.0 + e.p[0] * (moment.temperature_c - e.p[1]);
    } else if (e.cause == kBaseDrift) {
      v.segment<2>(geometry::kX0) += Vector2d(e.p[0], e.p[1]) * (moment.time_s / 3600.0);
    } else if (e.cause == kCreep && e.where.starts_with("l")) {
      v[static_cast<Eigen::Index>(e.place)] += crept(e, moment.time_s);
    } else if (stepped && e.where == "base") {
      v.segment<2>(geometry::kX0) += e.p[1] * direction(e.p[2]);
    } else if (stepped && e.where == "cuboid") {
      gamma_step += e.p[1];
    }
  }
  const auto pose = geometry::forward(v, theta, moment.assembly);
  if (!pose) return std::nullopt;
  const double clamp = world.robot.clamp_rad + gamma_step;
  Arm arm{pose->p_WE, geometry::cuboid_angle(world.rig, reference_angle_rad, *pose, clamp)};
  const Vector2d p = pose->p_WE;
  for (const Ready& e : effects) {
    switch (e.cause) {
      case kPassiveClearance:
        arm.p_WE += e.p[0] * moment.travel;
        break;
      case kFrameSkew:
        arm.p_WE.x() += std::tan(e.p[0]) * (p.y() - world.rig.cuboid.reference_pose_mm.y());
        break;
      case kXyField:
        arm.p_WE += fields[e.table].at(p);
        break;
      case kRandomWalk:
        arm.p_WE += walks[e.table].at(moment.time_s);
        break;
      case kTimeSinusoid:
        arm.p_WE +=
            e.p[0] * std::sin(kTwoPi * moment.time_s / e.p[1] + e.p[2]) * direction(e.p[3]);
        break;
      default:
        break;
    }
  }
  if (warp) arm.p_WE += warp->at(p);
  return arm;
}

std::vector<std::optional<Push>> WorldModel::Parts::pushes(const Arm& arm) const {
  using enum Cause;
  double side = world.rig.cuboid.side_mm;
  double shear = 0.0;
  double tip_change = 0.0;
  Vector2d centre = arm.p_WE;
  for (const Ready& e : effects) {
    if (e.cause == kCuboidSize) side += e.p[0];
    if (e.cause == kCuboidSquareness) shear += e.p[0];
    if (e.cause == kTipRadius) tip_change += e.p[0];
    if (e.cause == kCuboidOffset) centre += turned(Vector2d(e.p[0], e.p[1]), arm.gamma_rad);
  }
  const CuboidOutline outline(centre, arm.gamma_rad, side, shear);
  std::vector<std::optional<Push>> result;
  result.reserve(world.rig.dials.size());
  for (std::size_t i = 0; i < world.rig.dials.size(); ++i) {
    const geometry::DialGeometry& dial = world.rig.dials[i].geometry;
    Plunger plunger{dial.position_mm, dial.axis, dial.tip_radius_mm + tip_change};
    for (const Ready& e : effects) {
      if (e.place != i) continue;
      if (e.cause == kDialMount) plunger.tip_front_mm += e.p[0] * dial.axis;
      if (e.cause == kDialLean) plunger.axis = turned(plunger.axis, e.p[0]);
    }
    result.push_back(push_of(outline, plunger, dial.travel_mm));
  }
  return result;
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
  parts->q_reference = *q;
  parts->reference_angle_rad = *reference;
  for (const HiddenEffect& effect : world.effects) {
    parts->effects.push_back(parts->made_ready(effect));
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
    // The springs turn the joints by K^-1 J' F; the forces hardly change, so this converges
    // fast.
    constexpr int kRounds = 4;
    constexpr double kStep_rad = 1e-5;
    for (int round = 0; round < kRounds; ++round) {
      Vector2d force_n = Vector2d::Zero();
      for (std::size_t i = 0; i < pushes.size(); ++i) {
        if (!pushes[i]) continue;
        const geometry::Dial& dial = parts_->world.rig.dials[i];
        const double in_mm = std::min(pushes[i]->displacement_mm, dial.geometry.travel_mm);
        force_n += (dial.force_n + dial.spring_n_per_mm * in_mm) * dial.geometry.axis;
      }
      Matrix2d J_q;
      for (int joint = 0; joint < 2; ++joint) {
        const Vector2d step = kStep_rad * Vector2d::Unit(joint);
        const auto ahead = parts_->arm(theta + step, moment);
        const auto behind = parts_->arm(theta - step, moment);
        if (!ahead || !behind) return std::nullopt;
        J_q.col(joint) = (ahead->p_WE - behind->p_WE) / (2 * kStep_rad);
      }
      theta = unloaded + parts_->compliance_rad_per_nmm.cwiseProduct(J_q.transpose() * force_n);
      arm = parts_->arm(theta, moment);
      if (!arm) return std::nullopt;
      pushes = parts_->pushes(*arm);
    }
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
  using enum Cause;
  double value = displacement_mm;
  for (const Ready& e : parts_->effects) {
    if (e.place != dial) continue;
    switch (e.cause) {
      case kDialGain:
        value += e.p[0] * displacement_mm;
        break;
      case kDialBend: {
        constexpr double kMiddle_mm = 16.0;
        value += e.p[0] * std::pow((displacement_mm - kMiddle_mm) / 10.0, 2);
        break;
      }
      case kDialCyclic:
        value += e.p[0] * std::sin(kTwoPi * displacement_mm / e.p[1] + e.p[2]);
        break;
      case kDialHysteresis:
        value += e.p[0] / 2 * direction;
        break;
      case kStep:
        if (parts_->world.rig.dials[dial].id == e.where &&
            static_cast<double>(moment.sample) >= e.p[0]) {
          value += e.p[1];
        }
        break;
      default:
        break;
    }
  }
  if (with_habits) {
    value += parts_->world.dials.hysteresis_mm / 2 * direction;
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
  std::size_t dial = name;
  for (const Ready& e : parts_->effects) {
    if (e.cause != Cause::kDialSwap) continue;
    if (dial == e.place) {
      dial = e.other_place;
    } else if (dial == e.other_place) {
      dial = e.place;
    }
  }
  return dial;
}

double WorldModel::gross_error_mm(std::size_t dial, std::int64_t sample) const {
  double error = 0.0;
  for (const Ready& e : parts_->effects) {
    if (e.cause != Cause::kOutliers) continue;
    const Random random(
        static_cast<std::uint64_t>(e.p[2]), Stream::kOutlier, static_cast<std::uint32_t>(dial));
    const auto counter = static_cast<std::uint64_t>(sample) * 4;
    if (random.uniform(counter) >= e.p[0]) continue;
    const double size = random.uniform(counter + 1, 0.25, 1.0) * e.p[1];
    error += random.uniform(counter + 2) < 0.5 ? -size : size;
  }
  return error;
}

bool WorldModel::is_stale(std::size_t dial, std::int64_t sample) const {
  for (const Ready& e : parts_->effects) {
    if (e.cause != Cause::kStaleReading || sample <= 0) continue;
    const auto place = static_cast<std::uint32_t>(e.p[1] != 0.0 ? 0 : dial + 1);
    const Random random(static_cast<std::uint64_t>(e.p[2]), Stream::kStale, place);
    if (random.uniform(static_cast<std::uint64_t>(sample)) < e.p[0]) return true;
  }
  return false;
}

}  // namespace sixdial::mock_devices
