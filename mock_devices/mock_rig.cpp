#include "mock_devices/mock_rig.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "mock_devices/iso_time.h"

namespace sixdial::mock_devices {
namespace {

double checked_speed(double speed) {
  if (!(speed > 0.0) || !std::isfinite(speed)) {
    throw std::invalid_argument(fmt::format("clock speed {} is not positive", speed));
  }
  return speed;
}

}  // namespace

MockRig::MockRig(MockRigOptions options)
    : options_(std::move(options)),
      clock_(checked_speed(options_.clock_speed), milliseconds_of(options_.start_time)),
      bench_(options_.world, options_.habits, [this] { return clock_.seconds(); }) {}

MockRig::~MockRig() { stop(); }

void MockRig::start() {
  if (wire_) return;
  const bool registers = options_.robot_controller.empty();
  if (!registers) {
    served_ = std::make_unique<ServedController>(
        bench_, ServedControllerOptions{
                    .name = options_.robot_controller,
                    .address = options_.address,
                    .port = options_.robot_port,
                    .link = options_.robot_link,
                    .speed = options_.clock_speed});
  }
  wire_ = std::make_unique<Wire>(
      bench_, WireOptions{
                  .address = options_.address,
                  .dial_port = options_.dial_port,
                  .robot_port = registers ? options_.robot_port : std::uint16_t{0},
                  .pty_directory = options_.pty_directory,
                  .dialects = options_.dialects,
                  .rtu_baud = options_.rtu_baud,
                  .speed = options_.clock_speed});
}

void MockRig::stop() {
  served_.reset();
  wire_.reset();
}

MockPorts MockRig::ports() const {
  if (!wire_) throw std::logic_error("the mock rig is not started, it has no ports");
  return {wire_->dial_port(), served_ ? served_->port() : wire_->robot_port(), wire_->serial()};
}

std::string MockRig::robot_connection() const {
  if (served_) return served_->connection();
  return fmt::format("modbus-tcp://{}:{}?unit=1", options_.address, ports().robot);
}
std::string MockRig::robot_serial_connection() const {
  return served_ ? served_->serial_connection() : "";
}

geometry::Rig MockRig::connected_rig(const std::string& kind) const {
  const MockPorts open = ports();
  geometry::Rig rig = options_.world.rig;
  rig.robot.connection = robot_connection();
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    std::string& connection = rig.dials[i].connection;
    if (kind == kTcpConnection) {
      connection = fmt::format("modbus-tcp://{}:{}?unit=1", options_.address, open.dials);
      continue;
    }
    const Dialect* dialect = find_dialect(kind);
    const bool shared = dialect != nullptr && dialect->shared;
    const auto port = open.serial.find(shared ? kind : kind + "_" + rig.dials[i].id);
    if (dialect == nullptr || port == open.serial.end()) {
      throw std::invalid_argument(fmt::format("the mock rig does not serve '{}'", kind));
    }
    const std::string path = port->second.string();
    if (dialect == &kModbusRtu) {
      connection = fmt::format(
          "modbus-rtu:{}?baud={}&parity={}&unit=1", path, options_.rtu_baud,
          dialect->line.parity);
    } else if (shared) {
      connection = fmt::format("serial:{}?dialect={}&channel={}", path, kind, i + 1);
    } else {
      connection = fmt::format("serial:{}?dialect={}", path, kind);
    }
  }
  return rig;
}

void MockRig::order_fault(const std::string& dial_id, const FaultOrder& order) {
  const auto dial = bench_.dial_index(dial_id);
  if (!dial) throw std::invalid_argument(fmt::format("the rig has no dial '{}'", dial_id));
  bench_.order_fault(*dial, order);
  if (wire_) wire_->wake();
}

void MockRig::clear_faults() { bench_.clear_faults(); }

}  // namespace sixdial::mock_devices
