#include "mock_devices/mock_arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "mock_devices/iso_time.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

double checked(double speed) {
  if (!(speed > 0.0) || !std::isfinite(speed)) {
    throw std::invalid_argument(fmt::format("clock speed {} is not positive", speed));
  }
  return speed;
}

}  // namespace

ArmEffect parse_arm_effect(const ArmWorld& world, std::string_view text, std::uint64_t seed) {
  const std::string_view cause = text.substr(0, text.find(':'));
  const auto causes = arm_causes();
  const auto row = std::ranges::find(causes, cause, &ArmCause::id);
  if (row == causes.end()) {
    std::string known;
    for (const ArmCause& each : causes) known += fmt::format(" {}", each.id);
    throw std::invalid_argument(
        fmt::format("an arm has no cause '{}'; known are:{}", cause, known));
  }
  const Random random(seed, Stream::kHide, 2);
  std::string_view rest =
      text.size() > cause.size() ? text.substr(cause.size() + 1) : std::string_view();
  const std::string_view where = rest.substr(0, rest.find(':'));
  rest = rest.size() > where.size() ? rest.substr(where.size() + 1) : std::string_view();
  std::string place(where);
  if (place.empty()) {
    const std::vector<std::string> places = places_at_arm(world, cause);
    const double at = random.uniform(0) * static_cast<double>(places.size());
    place = places[std::min(places.size() - 1, static_cast<std::size_t>(at))];
  }
  double amplitude = std::exp(random.uniform(1, std::log(row->least), std::log(row->most)));
  if (!rest.empty()) {
    const auto [end, error] =
        std::from_chars(rest.data(), rest.data() + rest.size(), amplitude);
    if (error != std::errc{} || end != rest.data() + rest.size() || !std::isfinite(amplitude)) {
      throw std::invalid_argument(fmt::format(
          "'{}': the amplitude '{}' is not a number; write cause:where:amplitude", text, rest));
    }
  }
  return make_arm_effect(world, cause, place, amplitude);
}

std::string arm_answer_json(const ArmWorld& world) {
  nlohmann::ordered_json answer;
  answer["robot"] = "serial";
  answer["joints"] = world.nominal.size();
  answer["seed"] = world.seed;
  answer["noise_mm"] = world.noise_mm;
  answer["effects"] = nlohmann::ordered_json::array();
  for (const ArmEffect& each : world.effects) {
    answer["effects"].push_back(
        {{"cause", each.cause}, {"where", each.where}, {"amplitude", each.amplitude}});
  }
  return answer.dump(2) + "\n";
}

MockArm::MockArm(MockArmOptions options)
    : options_(std::move(options)),
      clock_(checked(options_.clock_speed), milliseconds_of(options_.start_time)),
      bench_(
          [this] {
            ArmSetting setting = drawn_setting(options_.world);
            setting.rows = options_.rows;
            return setting;
          }(),
          [this] { return clock_.seconds(); }) {}

void MockArm::start() {
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
                  .pty_directory = {},
                  .dialects = {},
                  .speed = options_.clock_speed});
}

const Wire& MockArm::wire() const {
  if (!wire_) throw std::logic_error("the mock arm is not started, it has no ports");
  return *wire_;
}
std::uint16_t MockArm::dial_port() const { return wire().dial_port(); }
std::uint16_t MockArm::robot_port() const {
  return served_ ? served_->port() : wire().robot_port();
}
std::string MockArm::robot_connection() const {
  if (served_) return served_->connection();
  return fmt::format("modbus-tcp://{}:{}?unit=1", options_.address, robot_port());
}
std::string MockArm::robot_serial_connection() const {
  return served_ ? served_->serial_connection() : "";
}

std::string MockArm::rig_text() const {
  // The counter of scans stands behind the status words.
  return bench_.rig_text(
      robot_connection(), fmt::format(
                              "modbus-tcp://{}:{}?unit=1&counter={}", options_.address,
                              dial_port(), 100 + bench_.dial_ids().size()));
}

}  // namespace sixdial::mock_devices
