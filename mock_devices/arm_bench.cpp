#include "mock_devices/arm_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kAnchors = 6;
constexpr double kCold_c = 20.0;
constexpr double kWarmUp_s = 1500.0;
constexpr double kEncoderStep_rad = 2.0 * std::numbers::pi / 4194304.0;  // 22 bit
constexpr double kCycle_s = 0.004;
constexpr double kReadings_hz = 20.0;  // new values of a wire
constexpr double kQuantum_mm = 0.01;
constexpr double kTravel_mm = 6000.0;
constexpr double kBeyond_rad = 0.2;  // of the range that the file says
constexpr std::size_t kKeptMoves = 64;

std::string wire_name(std::size_t wire) { return fmt::format("K{}", wire + 1); }

double reach_mm(const ArmWorld& world) {
  double reach = world.tool_nominal_mm.norm();
  for (const DhRow& row : world.nominal) reach += std::hypot(row.a_mm, row.d_mm);
  return reach;
}

}  // namespace

ArmSetting drawn_setting(ArmWorld world) {
  const Random random(world.seed, Stream::kRobot, 1);
  ArmSetting setting;
  const double away = 1.3 * reach_mm(world);
  for (int k = 0; k < kAnchors; ++k) {
    // All around, low and high in turn.
    const auto counter = static_cast<std::uint64_t>(10 * k);
    const double angle =
        2.0 * std::numbers::pi * k / kAnchors + random.uniform(counter, -0.3, 0.3);
    const double height =
        (k % 2 == 0 ? -0.6 : 0.8) * away * random.uniform(counter + 1, 0.8, 1.2);
    const Vector3d way(away * std::cos(angle), away * std::sin(angle), height);
    setting.anchors_mm.emplace_back((world.base_mm + way).array().round());
  }
  setting.world = std::move(world);
  return setting;
}

/// The gauge box's view of the wires.
class ArmBench::Wires final : public Panel {
 public:
  explicit Wires(ArmBench& bench) : bench_(bench) {}
  [[nodiscard]] std::size_t dial_count() const override {
    return bench_.setting_.anchors_mm.size();
  }
  [[nodiscard]] ShownDial show(std::size_t dial) override {
    ShownDial shown;
    shown.value = bench_.shown_mm(dial);
    shown.in_contact = true;
    return shown;
  }
  [[nodiscard]] std::optional<FaultOrder> take(std::size_t, Fault) override {
    return std::nullopt;
  }
  void set_inch(std::size_t, bool) override {}
  void set_hold(std::size_t, bool) override {}
  [[nodiscard]] std::uint16_t scan() override {
    return static_cast<std::uint16_t>(
        static_cast<std::int64_t>(std::max(0.0, bench_.seconds_()) * kReadings_hz));
  }

 private:
  ArmBench& bench_;
};

ArmBench::ArmBench(ArmSetting setting, std::function<double()> seconds)
    : setting_(std::move(setting)), seconds_(std::move(seconds)) {
  const VectorXd home = VectorXd::Zero(static_cast<Index>(setting_.world.nominal.size()));
  legs_.push_back({Move(home, home, 0.0, setting_.motion, 1.0), home});
}

std::unique_ptr<Panel> ArmBench::panel(std::string) { return std::make_unique<Wires>(*this); }

std::vector<std::string> ArmBench::dial_ids() const {
  std::vector<std::string> ids;
  for (std::size_t k = 0; k < setting_.anchors_mm.size(); ++k) ids.push_back(wire_name(k));
  return ids;
}

RobotCalls ArmBench::robot_port() {
  return {
      .report = [this] { return robot(); },
      .start = [this](const VectorXd& q_rad, int percent) { start_move(q_rad, percent); },
      .stop = [this] { stop(); },
      .joints = setting_.world.nominal.size(),
      .follow = [this](const VectorXd& q_rad, double seconds) { follow(q_rad, seconds); }};
}

const ArmBench::Leg& ArmBench::leg_at(double time_s) const {
  for (auto leg = legs_.rbegin(); leg != legs_.rend(); ++leg) {
    if (leg->move.start_s() <= time_s) return *leg;
  }
  return legs_.front();
}

double ArmBench::temperature_c(double time_s) const {
  return kCold_c + setting_.world.warm_up_c * (1.0 - std::exp(-time_s / kWarmUp_s));
}

Vector3d ArmBench::tool(double time_s) const {
  const Leg& leg = leg_at(time_s);
  ArmRow row;
  row.time_s = time_s;
  row.temperature_c = temperature_c(time_s);
  row.q_rad = leg.move.at(time_s);
  return seen_tool(setting_.world, row, leg.approach, std::max(0, moves_ - 1), setting_.rows);
}

bool ArmBench::start_move(const VectorXd& q_rad, int speed_percent) {
  const std::lock_guard lock(mutex_);
  const VectorXd target =
      (q_rad / kEncoderStep_rad).array().round().matrix() * kEncoderStep_rad;
  const double share = std::clamp(speed_percent, 1, 100) / 100.0;
  return set_off(target, setting_.motion, share, false, seconds_());
}

bool ArmBench::follow(const VectorXd& q_rad, double seconds) {
  const std::lock_guard lock(mutex_);
  const double time_s = seconds_();
  const VectorXd here = leg_at(time_s).move.at(time_s);
  if (q_rad.size() != here.size()) return false;
  const bool goes_on = time_s < legs_.back().move.end_s();
  return set_off(q_rad, limits_of_move(here, q_rad, seconds), 1.0, goes_on, time_s);
}

bool ArmBench::set_off(
    const VectorXd& target, const MotionLimits& limits, double share, bool goes_on,
    double time_s) {
  const VectorXd here = leg_at(time_s).move.at(time_s);
  const double most = setting_.world.range_rad + kBeyond_rad;
  legs_.back().move.cut(time_s);
  if (target.size() != here.size() || !(target.cwiseAbs().maxCoeff() <= most)) {
    fault_ = RobotFault::kOutOfReach;
    return false;
  }
  VectorXd approach = legs_.back().approach;
  for (Index j = 0; j < target.size(); ++j) {
    const double way = target[j] - here[j];
    if (std::abs(way) > kEncoderStep_rad / 2) approach[j] = way > 0 ? 1.0 : -1.0;
  }
  legs_.push_back({Move(here, target, time_s, limits, share), std::move(approach)});
  if (legs_.size() > kKeptMoves) legs_.pop_front();
  if (!goes_on) ++moves_;
  fault_ = RobotFault::kNone;
  return true;
}

void ArmBench::stop() {
  const std::lock_guard lock(mutex_);
  const double time_s = seconds_();
  if (time_s >= legs_.back().move.end_s()) return;
  legs_.back().move.cut(time_s);
  fault_ = RobotFault::kStopped;
}

RobotReport ArmBench::robot() const {
  const std::lock_guard lock(mutex_);
  const double time_s = seconds_();
  RobotReport report;
  report.fault = fault_;
  report.state = fault_ != RobotFault::kNone          ? MotionState::kFault
                 : time_s < legs_.back().move.end_s() ? MotionState::kMoving
                 : moves_ > 0                         ? MotionState::kInPosition
                                                      : MotionState::kIdle;
  report.q_rad = leg_at(time_s).move.at(time_s);
  report.moves_started = static_cast<std::uint16_t>(moves_);
  report.temperature_c = temperature_c(time_s);
  report.cycles = static_cast<std::uint16_t>(static_cast<std::int64_t>(time_s / kCycle_s));
  return report;
}

double ArmBench::true_length_mm(std::size_t wire) const {
  const std::lock_guard lock(mutex_);
  return (tool(seconds_()) - setting_.anchors_mm.at(wire)).norm();
}

// A wire's encoder gives a new value at each of its own ticks.
double ArmBench::shown_mm(std::size_t wire) const {
  const std::lock_guard lock(mutex_);
  const double tick = std::floor(std::max(0.0, seconds_()) * kReadings_hz);
  const double length = (tool(tick / kReadings_hz) - setting_.anchors_mm.at(wire)).norm();
  const Random noise(setting_.world.seed, Stream::kNoise, static_cast<std::uint32_t>(wire + 1));
  const double shown =
      length + setting_.world.noise_mm * noise.normal(static_cast<std::uint64_t>(tick));
  return std::round(shown / kQuantum_mm) * kQuantum_mm;
}

std::string ArmBench::rig_text(
    const std::string& robot_connection, const std::string& dial_connection) const {
  const ArmWorld& world = setting_.world;
  // Where the arm stands, by tape and level.
  const Random tape(world.seed, Stream::kRobot, 2);
  std::string base;
  for (int axis = 0; axis < 3; ++axis) {
    const auto counter = static_cast<std::uint64_t>(2 * axis);
    base += fmt::format(
        "base_{}_mm = {:.0f}\nbase_r{}_deg = {:.1f}\n", "xyz"[axis],
        world.base_mm[axis] + 3.0 * tape.normal(counter), "xyz"[axis],
        (world.base_turn_rad[axis] + 5e-3 * tape.normal(counter + 1)) * 180.0 /
            std::numbers::pi);
  }
  std::string text =
      "# A mock arm under draw wires. Lengths in mm, angles in degrees.\nname = \"mock "
      "arm\"\n\n" +
      arm_robot_text(
          world, base + fmt::format("connection = \"{}\"\n", robot_connection),
          world.range_rad) +
      fmt::format("\n[instrument]\nkind = \"position\"\nsd_mm = {:.4f}\n", world.noise_mm);
  for (std::size_t k = 0; k < setting_.anchors_mm.size(); ++k) {
    const Vector3d& at = setting_.anchors_mm[k];
    text += fmt::format(
        "\n[[anchor]]\nname = \"{}\"\nat_mm = [{}, {}, {}]\n", wire_name(k), at.x(), at.y(),
        at.z());
  }
  text += fmt::format(
      "\n[dials]\ntravel_mm = {}\nresolution_mm = {}\naccuracy_mm = {:.4f}\n"
      "repeatability_mm = {:.4f}\nconnection = \"{}\"\n",
      kTravel_mm, kQuantum_mm, 3 * world.noise_mm, std::max(world.noise_mm, kQuantum_mm / 3),
      dial_connection);
  for (std::size_t k = 0; k < setting_.anchors_mm.size(); ++k) {
    text += fmt::format("\n[[dial]]\nid = \"{}\"\n", wire_name(k));
  }
  return text;
}

}  // namespace sixdial::mock_devices
