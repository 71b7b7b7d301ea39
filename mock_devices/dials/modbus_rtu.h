// A gauge box with six dials, whichever way its Modbus frames travel (serial line or TCP).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mock_devices/dials/dialect.h"
#include "mock_devices/registers.h"

namespace sixdial::mock_devices {

/// One scan of all dials, invalid values and status words as the box gives them.
[[nodiscard]] DialScan scan_of(Panel& panel);

struct GaugeBoxReply {
  Bytes pdu;
  bool wrong_unit = false;
  bool damaged = false;  // CRC, or on TCP the transaction number
};
[[nodiscard]] GaugeBoxReply gauge_box_answer(std::span<const std::uint8_t> pdu, Panel& panel);

}  // namespace sixdial::mock_devices
