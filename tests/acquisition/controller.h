// A robot controller in a few lines, by the register table of doc/devices.md.
#pragma once

#include <cstdlib>
#include <functional>
#include <utility>

#include "tests/acquisition/wire.h"

namespace sixdial::test {

/// Arrives after `polls` reads of its state.
class Controller {
 public:
  explicit Controller(int joints = 2) : after_(2 * joints) {
    for (int i = 0; i <= after_ + 4; ++i) table.input[i] = 0;
    for (int i = 0; i <= after_ + 1; ++i) table.holding[i] = 0;
    if (joints != 2) table.input[200] = static_cast<std::uint16_t>(joints);
    put_int32(table.input, 0, 157'079'633);  // 1.57079633 rad
    put_int32(table.input, 2, -20'000'000);
    table.input[after_ + 2] = static_cast<std::uint16_t>(-125);  // -1.25 degC
    table.on_write = [this](int) { command(); };
    table.before_read = [this](int address) {
      if (address == 0) step();
    };
  }

  ModbusTable table;
  std::function<void()> on_arrival;  // with the table's mutex held
  int polls = 3;
  bool deaf = false;  // leaves commands where they are

 private:
  void command() {
    if (deaf) return;
    const int wanted = std::exchange(table.holding[after_], std::uint16_t{0});
    if (wanted == 2) {
      table.input[after_] = 3;
      table.input[after_ + 3] = 2;
      left_ = -1;
    }
    if (wanted != 1) return;
    const int theta1 = table.holding[0] << 16 | table.holding[1];
    if (std::abs(theta1) > 400'000'000) {
      table.input[after_] = 3;
      table.input[after_ + 3] = 1;
      return;
    }
    ++table.input[after_ + 1];
    table.input[after_] = 1;
    table.input[after_ + 3] = 0;
    left_ = polls;
  }
  void step() {
    ++table.input[after_ + 4];
    if (left_ < 0 || --left_ > 0) return;
    left_ = -1;
    for (int i = 0; i < after_; ++i) table.input[i] = table.holding[i];
    table.input[after_] = 2;
    if (on_arrival) on_arrival();
  }
  int after_ = 4;  // the first register behind the joints
  int left_ = -1;
};

}  // namespace sixdial::test
