// What the cables of a mock rig plug into: displays of dials, and the robot's controller.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mock_devices/dials/dialect.h"
#include "mock_devices/registers.h"

namespace sixdial::mock_devices {

/// Any thread.
class Bench {
 public:
  Bench() = default;
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  virtual ~Bench() = default;
  /// The displays as one connection sees them; `connection` is what faults are ordered for. The
  /// bench must outlive it.
  [[nodiscard]] virtual std::unique_ptr<Panel> panel(std::string connection) = 0;
  [[nodiscard]] virtual RobotCalls robot_port() = 0;
  [[nodiscard]] virtual std::vector<std::string> dial_ids() const = 0;
  /// Of what is drawn on the cables.
  [[nodiscard]] virtual std::uint64_t seed() const = 0;
};

}  // namespace sixdial::mock_devices
