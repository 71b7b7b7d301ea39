#include "acquisition/robots/axis_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "acquisition/connection_text.h"
#include "acquisition/longest_silence.h"
#include "geometry/units.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kWrite{500};  // so long a message may take no bytes [wall]
constexpr double kLargest = 1e6;     // deg, mm

}  // namespace

std::string axis_letters(
    const ConnectionOptions& options, std::span<const RobotJoint> joints,
    std::string_view known) {
  if (joints.size() > known.size()) {
    refuse(
        "there are {} axes ({}), this robot has {} joints", known.size(), known, joints.size());
  }
  const std::string usual(known.substr(0, joints.size()));
  std::string axes = options.text("axes", usual);
  std::erase(axes, ',');
  for (const char letter : axes) {
    if (known.find(letter) == std::string_view::npos) {
      refuse("axes={}: '{}' is none of the axes {}", axes, letter, known);
    }
    if (std::ranges::count(axes, letter) > 1)
      refuse("axes={}: {} is there twice", axes, letter);
  }
  if (axes.size() != joints.size()) {
    refuse("axes={} names {} axes, the robot has {} joints", axes, axes.size(), joints.size());
  }
  return axes;
}

std::string figure_text(double value) {
  std::string text = fmt::format("{:.5f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text == "-0" ? "0" : text;
}

AxisSettings axis_settings(
    const ConnectionOptions& options, std::span<const RobotJoint> joints,
    std::string_view known, std::string place) {
  AxisSettings settings{
      .axes = axis_letters(options, joints, known), .place = std::move(place)};
  settings.feed = options.number("feed", settings.feed);
  settings.arrived = options.number("arrived", settings.arrived);
  if (settings.feed < 0) refuse("feed={} is not above 0", settings.feed);
  if (settings.arrived < 0) refuse("arrived={} is not above 0", settings.arrived);
  settings.timeout = milliseconds(options.whole("timeout_ms", 2000, 100, 60'000));
  return settings;
}

class AxisRobot::Moving {
 public:
  explicit Moving(AxisRobot& robot) : robot_(robot) {
    robot_.stop_asked_ = false;
    robot_.moving_ = true;
  }
  ~Moving() { robot_.moving_ = false; }
  Moving(const Moving&) = delete;
  Moving& operator=(const Moving&) = delete;

 private:
  AxisRobot& robot_;
};

AxisRobot::AxisRobot(
    AxisSettings settings, Open open, Clock& clock, std::span<const RobotJoint> joints)
    : settings_(std::move(settings)),
      joints_(joints.begin(), joints.end()),
      clock_(clock),
      open_(std::move(open)) {}

tl::expected<RobotState, RobotFault> AxisRobot::state(const std::stop_token& stop) {
  const std::lock_guard lock(mutex_);
  return state_now(stop);
}

tl::expected<RobotState, RobotFault> AxisRobot::move_to(
    const Eigen::VectorXd& q, milliseconds timeout, const std::stop_token& stop) {
  const Moving moving(*this);
  const std::lock_guard lock(mutex_);
  if (auto bad = bad_target(q)) return tl::unexpected(*std::move(bad));
  return go_to(commanded(q), timeout, stop);
}

std::optional<RobotFault> AxisRobot::bad_target(const Eigen::VectorXd& q) const {
  const bool good = q.size() == static_cast<Eigen::Index>(joints_.size()) && q.allFinite() &&
                    q.cwiseAbs().maxCoeff() < kLargest;
  if (good) return std::nullopt;
  return RobotFault{
      RobotFaultKind::kUnreachable,
      fmt::format("{} joint values, or one that is no number", q.size())};
}

std::vector<double> AxisRobot::commanded(const Eigen::VectorXd& q) const {
  std::vector<double> values;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double value = q[static_cast<Eigen::Index>(j)];
    values.push_back(
        std::stod(figure_text(joints_[j].turns ? value / geometry::kRadPerDeg : value)));
  }
  return values;
}

RobotState AxisRobot::state_of(std::span<const double> stands, Motion motion) const {
  RobotState state;
  state.q.resize(static_cast<Eigen::Index>(stands.size()));
  for (std::size_t j = 0; j < stands.size(); ++j) {
    state.q[static_cast<Eigen::Index>(j)] =
        joints_[j].turns ? stands[j] * geometry::kRadPerDeg : stands[j];
  }
  state.moves = moves_;
  state.motion = motion == Motion::kInPosition && moves_ == 0 ? Motion::kIdle : motion;
  if (motion == Motion::kFault) state.fault_code = 2;
  return state;
}

AxisRobot::WallTime AxisRobot::ends_by(milliseconds timeout) const {
  return steady_clock::now() +
         clock_.wall_timeout(timeout, std::min(timeout, milliseconds{2000}));
}

std::string AxisRobot::move_words(std::span<const double> values, double feed) const {
  std::string line = "G1";
  for (std::size_t j = 0; j < values.size(); ++j) {
    line += fmt::format(" {}{}", settings_.axes[j], figure_text(values[j]));
  }
  return line + fmt::format(" F{}", figure_text(feed));
}

std::optional<RobotFault> AxisRobot::not_there(
    std::span<const double> stands, std::span<const double> target) const {
  std::string off;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (std::abs(stands[j] - target[j]) <= settings_.arrived) continue;
    off += fmt::format(
        "{}{} ({}) stands at {} and was sent to {}", off.empty() ? "" : ", ", settings_.axes[j],
        joints_[j].name, figure_text(stands[j]), figure_text(target[j]));
  }
  if (off.empty()) return std::nullopt;
  return RobotFault{RobotFaultKind::kUnreachable, off + ": beyond its travel?"};
}

std::unique_lock<std::mutex> AxisRobot::turn_of_halt() {
  std::unique_lock lock(mutex_, std::defer_lock);
  while (!lock.try_lock()) {
    if (moving_) {
      stop_asked_ = true;
      return {};
    }
    std::this_thread::sleep_for(kTurn);
  }
  return lock;
}

RobotFault AxisRobot::link_fault(const Fault& fault) const {
  return {
      RobotFaultKind::kLink,
      fmt::format(
          "robot controller at {}, {}: {}", settings_.place, reason(fault.kind), fault.detail)};
}

AxisRobot::WallTime AxisRobot::answer_by() const {
  return steady_clock::now() + clock_.wall_timeout(settings_.timeout);
}

std::chrono::nanoseconds AxisRobot::longest_wait() const {
  return clock_.wall_timeout(longest_silence(clock_));
}

bool AxisRobot::is_open() {
  const std::lock_guard lock(write_mutex_);
  return channel_ != nullptr;
}

tl::expected<bool, RobotFault> AxisRobot::open_channel() {
  if (is_open()) return false;
  auto opened = open_();
  if (!opened) {
    note_answer(false);
    return tl::unexpected(link_fault(opened.error()));
  }
  const std::lock_guard lock(write_mutex_);
  channel_ = *std::move(opened);
  return true;
}

void AxisRobot::close_channel() {
  const std::lock_guard lock(write_mutex_);
  channel_.reset();
  waits_with_.clear();
}

RobotFault AxisRobot::broken_off(const Fault& fault) {
  note_answer(false);
  RobotFault told = link_fault(fault);
  if (fault.kind == FaultKind::kDisconnected) close_channel();
  lose_step();
  return told;
}

tl::expected<bool, Fault> AxisRobot::write(std::string_view bytes) {
  const std::lock_guard lock(write_mutex_);
  if (!channel_) return false;
  if (const auto written = channel_->write(bytes, kWrite); !written) {
    return tl::unexpected(written.error());
  }
  return true;
}

tl::expected<void, RobotFault> AxisRobot::tell(std::string_view bytes) {
  const auto written = write(bytes);
  if (!written) return tl::unexpected(broken_off(written.error()));
  if (!*written) {
    return tl::unexpected(link_fault({FaultKind::kDisconnected, "the connection is closed"}));
  }
  return {};
}

// Whoever reads from the channel meanwhile sees for himself that it is closed.
tl::expected<bool, RobotFault> AxisRobot::tell_meanwhile(std::string_view bytes) {
  const auto written = write(bytes);
  if (!written) return tl::unexpected(link_fault(written.error()));
  return *written;
}

tl::expected<std::optional<std::string>, RobotFault> AxisRobot::hear(
    WallTime deadline, const std::stop_token& stop) {
  auto text = channel_->read_line(deadline, stop);
  if (text) {
    waits_with_.clear();
    return std::optional(*std::move(text));
  }
  if (stop.stop_requested()) {
    return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
  }
  if (text.error().kind == FaultKind::kTimeout) {
    waits_with_ = text.error().detail;
    return std::optional<std::string>();
  }
  return tl::unexpected(broken_off(text.error()));
}

RobotFault AxisRobot::silent(std::string_view asked) {
  return broken_off(
      {FaultKind::kTimeout,
       fmt::format(
           "{} is not answered ({})", asked, waits_with_.empty() ? "no answer" : waits_with_)});
}

RobotFault AxisRobot::stranger(std::string_view text, std::string_view what_it_should_be) {
  constexpr std::size_t kMostShown = 80;
  return broken_off(
      {FaultKind::kBadFrame,
       fmt::format("{} is no {}", printable(text.substr(0, kMostShown)), what_it_should_be)});
}

tl::expected<std::optional<int>, RobotFault> AxisRobot::speed(const std::stop_token&) {
  return std::optional<int>(percent_);
}

tl::expected<void, RobotFault> AxisRobot::set_speed(int percent, const std::stop_token&) {
  percent_ = std::clamp(percent, 1, 100);
  return {};
}

}  // namespace sixdial::acquisition
