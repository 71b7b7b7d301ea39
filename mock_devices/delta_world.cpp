#include "mock_devices/delta_world.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "mock_devices/iso_time.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPi = std::numbers::pi;
constexpr double kTwoPi = 2 * kPi;
constexpr double kBetweenRows_s = 12.0;
constexpr double kCold_c = 20.0;
constexpr int kWires = 5;

constexpr std::array kCauses{
    DeltaCause{"joint_backlash", 0.01, 0.3, 5e-5, 1e-3, "width [mm, rad]"},
    DeltaCause{"joint_eccentricity", 0, 0, 1e-4, 2e-3, "amplitude [rad]"},
    DeltaCause{"joint_second_harmonic", 0, 0, 5e-5, 1e-3, "amplitude [rad]"},
    DeltaCause{"joint_gain", 1e-4, 2e-3, 1e-4, 2e-3, "gain [1]"},
    DeltaCause{"joint_curve", 0.01, 0.2, 5e-5, 5e-4, "rms [mm, rad]"},
    DeltaCause{"step", 0.01, 0.3, 5e-5, 1e-3, "jump of a joint [mm, rad]"},
    DeltaCause{"passive_clearance", 0.01, 0.3, 0.01, 0.3, "lag [mm]"},
    DeltaCause{"instrument_drift", 0.02, 0.5, 0.02, 0.5, "speed [mm/h]"},
    DeltaCause{"instrument_step", 0.02, 0.5, 0.02, 0.5, "shift [mm]"},
    DeltaCause{"instrument_scale", 1e-4, 2e-3, 1e-4, 2e-3, "scale [1]"},
    DeltaCause{"frame_skew", 1e-4, 2e-3, 1e-4, 2e-3, "skew [rad]"},
    DeltaCause{"link_thermal_growth", 5e-6, 1e-4, 5e-6, 1e-4, "coefficient [1/K]"}};

/// Index of "joint3"; -1: none.
int joint_at(std::string_view where) {
  return where.starts_with("joint") ? where.back() - '1' : -1;
}

Matrix3d turn_of(const Vector3d& w) {
  const double angle = w.norm();
  if (!(angle > 0.0)) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

Vector3d any_direction(const Random& random, std::uint64_t counter) {
  return Vector3d(
             random.normal(counter), random.normal(counter + 1), random.normal(counter + 2))
      .normalized();
}

/// The ends of the rods that the motors move.
std::array<Vector3d, 3> driven_ends(const DeltaSizes& is, bool has_arms, const Vector3d& q) {
  std::array<Vector3d, 3> ends;
  for (std::size_t i = 0; i < 3; ++i) {
    const double stands = q[static_cast<Eigen::Index>(i)] + is.zero[i];
    const double out = is.radius_mm + (has_arms ? is.arm_mm[i] * std::cos(stands) : 0.0);
    const double up = has_arms ? -is.arm_mm[i] * std::sin(stands) : stands;
    ends[i] = {out * std::cos(is.angle_rad[i]), out * std::sin(is.angle_rad[i]), up};
  }
  return ends;
}

/// The delta at work, row by row.
class Delta {
 public:
  Delta(const DeltaWorld& world, int rows)
      : world_(world), random_(world.seed, Stream::kHide), rows_(rows) {}

  /// Where the tool is in W as the instrument's own faults have it; `from`: where the nominal
  /// platform was before, `to`: where it is.
  [[nodiscard]] std::optional<Vector3d> seen(
      const DeltaRow& row, const Vector3d& approach, int index, const Vector3d& from,
      const Vector3d& to) const {
    Vector3d q = row.q;
    for (const DeltaEffect& each : world_.effects) move(each, approach, row.q, index, q);
    DeltaSizes sizes = world_.actual;
    double growth = 1.0;
    for (const DeltaEffect& each : world_.effects) {
      if (each.cause != "link_thermal_growth") continue;
      growth += each.amplitude * (row.temperature_c - kCold_c);
    }
    grow(growth, sizes, q);
    auto platform = platform_of(sizes, world_.has_arms, q);
    if (!platform) return std::nullopt;
    for (const DeltaEffect& each : world_.effects) {
      const Vector3d way = to - from;
      if (each.cause != "passive_clearance" || !(way.norm() > 0.0)) continue;
      *platform -= each.amplitude * way.normalized();  // it lags behind
    }
    Vector3d p = world_.base_mm + turn_of(world_.base_turn_rad) * *platform;
    for (const DeltaEffect& each : world_.effects) look(each, row, index, p);
    return p;
  }

 private:
  /// All of one metal: towers and screws too.
  void grow(double times, DeltaSizes& sizes, Vector3d& q) const {
    sizes.radius_mm *= times;
    for (std::size_t i = 0; i < 3; ++i) {
      sizes.rod_mm[i] *= times;
      sizes.arm_mm[i] *= times;
      if (world_.has_arms) continue;
      const auto k = static_cast<Eigen::Index>(i);
      q[k] = times * (q[k] + sizes.zero[i]) - sizes.zero[i];
    }
  }

  /// What is wrong with a joint, by what its encoder says.
  void move(
      const DeltaEffect& each, const Vector3d& approach, const Vector3d& read, int index,
      Vector3d& q) const {
    const Eigen::Index j = joint_at(each.where);
    if (j < 0) return;
    const double at = read[j];
    const double phase = random_.uniform(10 + static_cast<std::uint64_t>(j), 0.0, kTwoPi);
    if (each.cause == "joint_backlash") q[j] -= approach[j] * each.amplitude / 2;
    if (each.cause == "joint_eccentricity") q[j] += each.amplitude * std::sin(at + phase);
    if (each.cause == "joint_second_harmonic") {
      q[j] += each.amplitude * std::sin(2 * at + phase);
    }
    if (each.cause == "joint_gain") q[j] += each.amplitude * at;
    if (each.cause == "joint_curve") q[j] += each.amplitude * curve(static_cast<int>(j), at);
    if (each.cause == "step" && index >= when() * rows_) q[j] += each.amplitude;
  }

  /// Share of the session after which something jumps.
  [[nodiscard]] double when() const { return random_.uniform(320, 0.3, 0.7); }

  /// Waves of a joint's own value, the shorter the smaller; rms 1 over many of them. Of a joint
  /// that turns three to twenty-four a turn, of one that slides one to eight over its travel.
  [[nodiscard]] double curve(int joint, double at) const {
    const int first = world_.has_arms ? 3 : 1;
    const int last = world_.has_arms ? 24 : 8;
    const double turns = world_.has_arms ? at : kTwoPi * at / (world_.high - world_.low);
    double sum = 0.0;
    double squares = 0.0;
    for (int k = first; k <= last; ++k) {
      const auto counter = static_cast<std::uint64_t>(1000 + 100 * joint + 2 * k);
      const double size = random_.normal(counter) / k;
      sum += size * std::sin(k * turns + random_.uniform(counter + 1, 0.0, kTwoPi));
      squares += size * size / 2;
    }
    return sum / std::sqrt(squares);
  }

  /// What is wrong with the instrument or its frame.
  void look(const DeltaEffect& each, const DeltaRow& row, int index, Vector3d& p) const {
    constexpr double kTurnPerShift = 2e-4;  // rad for each mm
    const Vector3d way = any_direction(random_, 300);
    const Vector3d axis = any_direction(random_, 310);
    if (each.cause == "instrument_drift") {
      const double moved = each.amplitude * row.time_s / 3600.0;
      p += moved * way + kTurnPerShift * moved * axis.cross(p);
    }
    if (each.cause == "instrument_step" && index >= when() * rows_) p += each.amplitude * way;
    if (each.cause == "instrument_scale") p *= 1.0 + each.amplitude;
    if (each.cause == "frame_skew") {
      p += each.amplitude * Vector3d(way.x() * p.y() + way.y() * p.z(), way.z() * p.z(), 0.0);
    }
  }

  const DeltaWorld& world_;
  Random random_;
  int rows_;
};

/// Joint values at which the nominal platform is in its work, and the place.
std::optional<std::pair<Vector3d, Vector3d>> drawn_pose(
    const DeltaWorld& world, const Random& plan, std::uint64_t first) {
  constexpr std::uint64_t kTries = 300;
  for (std::uint64_t attempt = 0; attempt < kTries; ++attempt) {
    Vector3d q;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const auto counter = first + 3 * attempt + static_cast<std::uint64_t>(j);
      q[j] = plan.uniform(counter, world.low, world.high);
    }
    const auto at = platform_of(world.nominal, world.has_arms, q);
    if (at && at->head<2>().norm() <= world.reach_mm) return std::pair{q, *at};
  }
  return std::nullopt;
}

/// [robot] of rig.toml: the nominal sizes, and under wires where it is thought to stand.
std::string robot_text(const DeltaWorld& world) {
  constexpr double kDegPerRad = 180.0 / kPi;
  std::string text = fmt::format(
      "[robot]\nmodel = \"{}\"\nworking_mode = \"{}\"\nassembly = 1\nradius_mm = {:.6f}\n",
      world.has_arms ? "rotary_delta" : "linear_delta", world.has_arms ? "out" : "below",
      world.nominal.radius_mm);
  const auto each = [&](const char* name, const std::array<double, 3>& values, double times) {
    for (std::size_t i = 0; i < 3; ++i) {
      const bool angle = times != 1.0;
      text += fmt::format(
          "{}_{}_{} = {:.9f}\n", name, "abc"[i], angle ? "deg" : "mm", times * values[i]);
    }
  };
  each("angle", world.nominal.angle_rad, kDegPerRad);
  each("rod", world.nominal.rod_mm, 1.0);
  if (world.has_arms) {
    each("arm", world.nominal.arm_mm, 1.0);
    each("zero", world.nominal.zero, kDegPerRad);
  } else {
    each("stop", world.nominal.zero, 1.0);
  }
  if (world.anchors_mm.empty()) return text;
  const Random random(world.seed, Stream::kRobot, 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    text += fmt::format(
        "base_{0}_mm = {1:.3f}\nbase_r{0}_deg = {2:.6f}\n", "xyz"[axis],
        world.base_mm[k] + 2.0 * random.normal(axis),
        kDegPerRad * (world.base_turn_rad[k] + 2e-3 * random.normal(10 + axis)));
  }
  return text;
}

std::string instrument_text(const DeltaWorld& world) {
  if (world.anchors_mm.empty()) {
    return fmt::format(
        "\n[instrument]\nkind = \"position\"\ndimensions = 3\nsd_mm = {:.6f}\n",
        world.noise_mm);
  }
  std::string text = fmt::format(
      "\n[instrument]\nkind = \"distance\"\ndimensions = 3\nsd_mm = {:.6f}\n", world.noise_mm);
  for (std::size_t k = 0; k < world.anchors_mm.size(); ++k) {
    const Vector3d& at = world.anchors_mm[k];
    text += fmt::format(
        "\n[[anchor]]\nname = \"K{}\"\nat_mm = [{:.3f}, {:.3f}, {:.3f}]\n", k + 1, at.x(),
        at.y(), at.z());
  }
  return text;
}

}  // namespace

std::optional<Vector3d> platform_of(const DeltaSizes& sizes, bool has_arms, const Vector3d& q) {
  const auto ends = driven_ends(sizes, has_arms, q);
  const Vector3d middle = (ends[0] + ends[1] + ends[2]) / 3.0;
  Vector3d p = middle - Vector3d(0, 0, 0.9 * sizes.rod_mm[0]);
  constexpr int kSteps = 50;
  constexpr double kThere_mm2 = 1e-9;
  for (int step = 0; step < kSteps; ++step) {
    Matrix3d J;
    Vector3d missing;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      J.row(row) = 2.0 * (p - ends[i]).transpose();
      missing[row] = sizes.rod_mm[i] * sizes.rod_mm[i] - (p - ends[i]).squaredNorm();
    }
    const bool below = p.z() < middle.z() - 0.2 * sizes.rod_mm[0];
    if (missing.cwiseAbs().maxCoeff() < kThere_mm2) {
      return below ? std::optional(p) : std::nullopt;
    }
    p += J.fullPivLu().solve(missing);
    if (!p.allFinite()) return std::nullopt;
  }
  return std::nullopt;
}

DeltaWorld drawn_delta(std::uint64_t seed) {
  const Random random(seed, Stream::kRobot);
  std::uint64_t next = 0;
  const auto any = [&](double low, double high) { return random.uniform(next++, low, high); };
  const auto off = [&](double sd) { return sd * random.normal(next++); };
  DeltaWorld world;
  world.seed = seed;
  world.has_arms = any(0, 1) < 0.5;
  const double scale = any(0.7, 2.0);
  DeltaSizes& is = world.nominal;
  is.radius_mm = scale * (world.has_arms ? any(60, 100) : any(130, 200));
  const double arm_mm = scale * any(100, 150);
  const double rod_mm = world.has_arms ? arm_mm * any(2.1, 2.7) : is.radius_mm * any(1.9, 2.4);
  const double first_rad = any(0, kTwoPi / 3);
  for (std::size_t i = 0; i < 3; ++i) {
    is.angle_rad[i] = first_rad + static_cast<double>(i) * kTwoPi / 3;
    is.rod_mm[i] = rod_mm;
    is.arm_mm[i] = world.has_arms ? arm_mm : 0.0;
  }
  world.actual = is;
  world.actual.radius_mm += off(0.4);
  for (std::size_t i = 0; i < 3; ++i) {
    world.actual.angle_rad[i] += off(2e-3);
    world.actual.rod_mm[i] += off(0.3);
    if (world.has_arms) world.actual.arm_mm[i] += off(0.3);
    world.actual.zero[i] += world.has_arms ? off(4e-3) : off(0.4);
  }
  if (world.has_arms) {
    world.low = any(-0.4, -0.2);
    world.high = any(0.9, 1.2);
  } else {
    world.low = std::sqrt(rod_mm * rod_mm - is.radius_mm * is.radius_mm);
    world.high = world.low + is.radius_mm * any(0.7, 1.0);
  }
  world.reach_mm = (world.has_arms ? 0.9 * arm_mm : 0.6 * is.radius_mm);
  const bool wires = any(0, 1) < 0.35;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    world.base_mm[axis] = wires ? any(-200, 200) : any(-2000, 2000);
    world.base_turn_rad[axis] = wires ? any(-0.2, 0.2) : any(-1.5, 1.5);
  }
  for (int k = 0; wires && k < kWires; ++k) {
    // All around, some high and some low.
    const double angle = kTwoPi * k / kWires + any(-0.3, 0.3);
    const double away_mm = scale * any(500, 800);
    const Vector3d way(
        away_mm * std::cos(angle), away_mm * std::sin(angle),
        (k % 2 == 0 ? -1.0 : 1.0) * scale * any(200, 500));
    world.anchors_mm.emplace_back((world.base_mm + way).array().round());
  }
  world.noise_mm = std::exp(any(std::log(0.005), std::log(0.05)));
  return world;
}

std::span<const DeltaCause> delta_causes() { return kCauses; }

std::vector<std::string> places_at_delta(const DeltaWorld& world, std::string_view cause) {
  const auto row = std::ranges::find(kCauses, cause, &DeltaCause::id);
  if (row == kCauses.end() || (!world.has_arms && !(row->most_mm > 0.0))) return {};
  if (cause.starts_with("joint_") || cause == "step") return {"joint1", "joint2", "joint3"};
  if (cause == "passive_clearance") return {"elbows"};
  if (cause == "link_thermal_growth") return {"links"};
  // Wires have neither axes nor one scale.
  const bool wires = !world.anchors_mm.empty();
  if (cause == "frame_skew")
    return wires ? std::vector<std::string>() : std::vector{std::string("frame")};
  if (cause == "instrument_scale" && wires) return {};
  return {"instrument"};
}

DeltaEffect make_delta_effect(
    const DeltaWorld& world, std::string_view cause, std::string_view where, double amplitude) {
  const std::vector<std::string> places = places_at_delta(world, cause);
  if (std::ranges::find(places, where) == places.end()) {
    throw std::invalid_argument(
        fmt::format("this delta has no cause '{}' at '{}'", cause, where));
  }
  return {std::string(cause), std::string(where), amplitude};
}

DeltaEffect draw_delta_effect(const DeltaWorld& world, std::uint64_t seed) {
  const Random random(seed, Stream::kHide, 1);
  const auto pick = [&](std::uint64_t counter, std::size_t count) {
    const double at = random.uniform(counter) * static_cast<double>(count);
    return std::min(count - 1, static_cast<std::size_t>(at));
  };
  std::vector<const DeltaCause*> possible;
  for (const DeltaCause& each : kCauses) {
    if (!places_at_delta(world, each.id).empty()) possible.push_back(&each);
  }
  const DeltaCause& cause = *possible[pick(0, possible.size())];
  const std::vector<std::string> places = places_at_delta(world, cause.id);
  const double least = world.has_arms ? cause.least_rad : cause.least_mm;
  const double most = world.has_arms ? cause.most_rad : cause.most_mm;
  const double size = std::exp(random.uniform(2, std::log(least), std::log(most)));
  return {std::string(cause.id), places[pick(1, places.size())], size};
}

std::vector<DeltaRow> measure_delta(const DeltaWorld& world, int g1, int g2) {
  const Delta delta(world, g1 + g2);
  const Random plan(world.seed, Stream::kField);
  const Random noise(world.seed, Stream::kNoise);
  std::vector<DeltaRow> rows;
  Vector3d q_before = Vector3d::Constant((world.low + world.high) / 2);
  Vector3d at_before = platform_of(world.nominal, world.has_arms, q_before).value();
  for (int i = 0; i < g1 + g2; ++i) {
    DeltaRow row;
    row.set = i < g1 ? "G1" : "G2";
    row.point = i < g1 ? i : i - g1;
    row.time_s = kBetweenRows_s * i;
    row.temperature_c = kCold_c + world.warm_up_c * (1 - std::exp(-row.time_s / 1000.0));
    const auto pose = drawn_pose(world, plan, static_cast<std::uint64_t>(i) * 1000);
    if (!pose) throw std::runtime_error("this delta reaches no place of its work");
    row.q = pose->first;
    const Vector3d approach = (row.q - q_before).array().sign();
    const auto p = delta.seen(row, approach, i, at_before, pose->second);
    if (!p) throw std::runtime_error("the true delta does not reach a pose of the nominal one");
    const auto channels = world.anchors_mm.empty() ? 3 : std::ssize(world.anchors_mm);
    row.reading.resize(channels);
    for (Eigen::Index k = 0; k < row.reading.size(); ++k) {
      const auto counter = static_cast<std::uint64_t>(8 * i + k);
      const double reads = world.anchors_mm.empty()
                               ? (*p)[k]
                               : (*p - world.anchors_mm[static_cast<std::size_t>(k)]).norm();
      row.reading[k] = reads + world.noise_mm * noise.normal(counter);
    }
    q_before = row.q;
    at_before = pose->second;
    rows.push_back(std::move(row));
  }
  return rows;
}

void write_delta_bundle(
    const std::filesystem::path& folder, const std::vector<DeltaRow>& rows,
    const DeltaWorld& world) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "rig.toml") << "name = \"a delta\"\n\n"
                                     << robot_text(world) << instrument_text(world);
  const std::int64_t start = milliseconds_of("2026-03-02T08:30:00.000Z");
  std::ofstream csv(folder / "session.csv");
  csv << "set,point,repeat,time_utc,temperature_c";
  for (int j = 1; j <= 3; ++j) csv << fmt::format(",q{}_{}", j, world.has_arms ? "rad" : "mm");
  if (world.anchors_mm.empty()) csv << ",x_mm,y_mm,z_mm";
  for (std::size_t k = 0; k < world.anchors_mm.size(); ++k) {
    csv << fmt::format(",distance_K{}_mm", k + 1);
  }
  csv << '\n';
  for (const DeltaRow& row : rows) {
    csv << fmt::format(
        "{},{},0,{},{:.2f}", row.set, row.point,
        iso8601(start + std::llround(1000 * row.time_s)), row.temperature_c);
    for (const double q : row.q) csv << fmt::format(",{:.9f}", q);
    for (const double reading : row.reading) csv << fmt::format(",{:.5f}", reading);
    csv << '\n';
  }
}

}  // namespace sixdial::mock_devices
