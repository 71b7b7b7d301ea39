#include "mock_devices/served_controller.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "mock_devices/gcode_cable.h"
#include "mock_devices/klipper_api.h"
#include "mock_devices/linuxcnc_remote.h"
#include "mock_devices/machine_socket.h"

namespace sixdial::mock_devices {
namespace {

constexpr std::string_view kAxes = "XYZABCUVW";
constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kTravel_deg = 360.0;  // of each axis, to either side

enum class Cable { kGcode, kKlipperSocket, kLinuxCnc };

struct Kind {
  std::string_view name;
  Cable cable;
  GcodeFirmware firmware;
  std::size_t most_axes;
};
constexpr std::array kKinds{
    Kind{"grbl", Cable::kGcode, GcodeFirmware::kGrbl, 9},
    Kind{"marlin", Cable::kGcode, GcodeFirmware::kMarlin, 9},
    Kind{"klipper", Cable::kGcode, GcodeFirmware::kKlipper, 9},
    Kind{"klipper-socket", Cable::kKlipperSocket, GcodeFirmware::kKlipper, 3},
    Kind{"linuxcnc", Cable::kLinuxCnc, GcodeFirmware::kGrbl, 6}};
constexpr std::array<std::string_view, kKinds.size()> kNames{
    kKinds[0].name, kKinds[1].name, kKinds[2].name, kKinds[3].name, kKinds[4].name};

const Kind& kind_of(const std::string& name, std::size_t joints) {
  const auto found = std::ranges::find(kKinds, std::string_view(name), &Kind::name);
  if (found == kKinds.end()) {
    throw std::invalid_argument(fmt::format(
        "there is no mock controller '{}'; there are modbus, {}", name,
        fmt::join(kNames, ", ")));
  }
  if (joints > found->most_axes) {
    throw std::invalid_argument(fmt::format(
        "{} moves {} axes at most, and this robot has {} joints", name, found->most_axes,
        joints));
  }
  return *found;
}

/// Where a machine's axes are at its own time.
using Axes = std::function<std::vector<double>(double time_s)>;

/// A machine whose axes the joints follow: whatever its clients tell it, the joints know before
/// it answers.
class Followed final : public SocketMachine {
 public:
  Followed(SocketMachine& machine, Axes axes, RobotCalls robot)
      : machine_(machine), axes_(std::move(axes)), robot_(std::move(robot)) {
    end_ = ends_at(0.0);  // as it was switched on
  }

  void connected(int client, double time_s) override { machine_.connected(client, time_s); }
  void receive(int client, std::string_view bytes, double time_s) override {
    machine_.receive(client, bytes, time_s);
    follow(time_s);
  }
  std::string due(int client, double time_s) override {
    std::string said = machine_.due(client, time_s);
    follow(time_s);
    return said;
  }
  [[nodiscard]] bool hangs_up(int client) const override { return machine_.hangs_up(client); }
  void gone(int client) override { machine_.gone(client); }

 private:
  void follow(double now_s) {
    std::vector<double> end = ends_at(now_s);
    if (end == end_) return;
    const double left_s = time_left(now_s);
    end_ = std::move(end);
    const Eigen::Map<const Eigen::VectorXd> axes_deg(end_.data(), std::ssize(end_));
    robot_.follow(axes_deg / kDegPerRad, left_s);
  }
  [[nodiscard]] std::vector<double> ends_at(double now_s) const {
    constexpr double kAtLast_s = 1e9;
    std::vector<double> end = axes_(now_s + kAtLast_s);
    end.resize(robot_.joints, 0.0);
    return end;
  }

  /// Until the axes stand where they will, to a millisecond.
  [[nodiscard]] double time_left(double now_s) const {
    constexpr double kMost_s = 1e6;
    const std::vector<double> last = axes_(now_s + 1e9);
    double high = 1e-3;
    while (high < kMost_s && axes_(now_s + high) != last) high *= 2.0;
    double low = 0.0;
    while (high - low > 1e-3) {
      const double middle = (low + high) / 2.0;
      (axes_(now_s + middle) == last ? high : low) = middle;
    }
    return high;
  }

  SocketMachine& machine_;
  const Axes axes_;
  RobotCalls robot_;
  std::vector<double> end_;  // where the axes stand at last, as it was last seen
};

std::filesystem::path own_socket() {
  return std::filesystem::temp_directory_path() /
         fmt::format("sixdial-mock-klippy-{}.sock", ::getpid());
}

}  // namespace

class ServedController::Served {
 public:
  Served(Bench& bench, const ServedControllerOptions& options)
      : robot_(bench.robot_port()),
        kind_(kind_of(options.name, robot_.joints)),
        options_(options) {
    const Eigen::VectorXd q_rad = robot_.report().q_rad;
    for (const double each : q_rad) stands_deg_.push_back(kDegPerRad * each);
    switch (kind_.cable) {
      case Cable::kGcode:
        serve_gcode();
        break;
      case Cable::kKlipperSocket:
        serve_klipper();
        break;
      case Cable::kLinuxCnc:
        serve_linuxcnc();
        break;
    }
  }

  [[nodiscard]] std::string connection() const {
    switch (kind_.cable) {
      case Cable::kGcode:
        return fmt::format("gcode-tcp:{}:{}?dialect={}", options_.address, port(), kind_.name);
      case Cable::kKlipperSocket:
        return "klipper:" + options_.link.string();
      case Cable::kLinuxCnc:
        return fmt::format("linuxcnc:{}:{}", options_.address, port());
    }
    return "";
  }
  [[nodiscard]] std::string serial_connection() const {
    if (!gcode_ || options_.link.empty()) return "";
    return fmt::format("gcode-serial:{}?dialect={}", options_.link.string(), kind_.name);
  }
  [[nodiscard]] std::uint16_t port() const {
    return kind_.cable == Cable::kKlipperSocket ? std::uint16_t{0} : socket_->port();
  }

 private:
  void serve_gcode() {
    gcode_.emplace(GcodeMachine{
        .firmware = kind_.firmware,
        .axes = std::string(kAxes.substr(0, robot_.joints)),
        .low = -kTravel_deg,
        .high = kTravel_deg,
        .begins_at = stands_deg_});
    serve_socket(*gcode_, {.pty_link = options_.link}, [this](double time_s) {
      return gcode_->machine().position(time_s);
    });
  }
  void serve_klipper() {
    if (options_.link.empty()) options_.link = own_socket();
    options_.link = std::filesystem::absolute(options_.link);
    KlipperMachine machine{.low = -kTravel_deg, .high = kTravel_deg};
    for (std::size_t i = 0; i < stands_deg_.size(); ++i) {
      machine.begins_at[i] = stands_deg_[i];
    }
    klipper_.emplace(std::move(machine));
    serve_socket(*klipper_, {.unix_socket = options_.link}, [this](double time_s) {
      return klipper_->position(time_s);
    });
  }
  void serve_linuxcnc() {
    linuxcnc_.emplace(
        LinuxCncMachine{.low = -kTravel_deg, .high = kTravel_deg, .begins_at = stands_deg_});
    serve_socket(*linuxcnc_, {}, [this](double time_s) { return linuxcnc_->position(time_s); });
  }
  /// `cables`: where besides the address.
  void serve_socket(SocketMachine& machine, MachineSocketOptions cables, Axes axes) {
    cables.address = options_.address;
    cables.port = options_.port;
    cables.speed = options_.speed;
    followed_.emplace(machine, std::move(axes), robot_);
    socket_.emplace(*followed_, cables);
  }

  RobotCalls robot_;
  const Kind& kind_;
  ServedControllerOptions options_;
  std::vector<double> stands_deg_;
  // A machine, its cable, and who looks at it: taken apart the other way round.
  std::optional<GcodeCable> gcode_;
  std::optional<KlipperApi> klipper_;
  std::optional<LinuxCncRemote> linuxcnc_;
  std::optional<Followed> followed_;
  std::optional<MachineSocket> socket_;
};

std::span<const std::string_view> served_controllers() { return kNames; }

ServedController::ServedController(Bench& bench, const ServedControllerOptions& options)
    : served_(std::make_unique<Served>(bench, options)) {}
ServedController::~ServedController() = default;
std::string ServedController::connection() const { return served_->connection(); }
std::string ServedController::serial_connection() const { return served_->serial_connection(); }
std::uint16_t ServedController::port() const { return served_->port(); }

}  // namespace sixdial::mock_devices
