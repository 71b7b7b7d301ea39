// "01 04 00 00 00 0C F0 0F" -> six dials in one frame at 19200 8N1: a gauge box on a serial
// line.
#include "mock_devices/dials/modbus_rtu.h"

#include <cmath>

#include "mock_devices/dials/dialect.h"
#include "mock_devices/registers.h"

namespace sixdial::mock_devices {
namespace {

constexpr std::uint8_t kUnit = 1;

std::optional<std::string> take_request(std::string& buffer) {
  Bytes bytes(buffer.begin(), buffer.end());
  ModbusRequest request;
  switch (take_rtu_request(bytes, request)) {
    case Framing::kNeedMore:
      return std::nullopt;
    case Framing::kBroken:
      buffer.clear();  // silence until the next request
      return std::nullopt;
    case Framing::kRequest:
      buffer.assign(bytes.begin(), bytes.end());
      request.pdu.insert(request.pdu.begin(), request.unit);
      return std::string(request.pdu.begin(), request.pdu.end());
  }
  return std::nullopt;
}

Reply answer(std::string_view request, std::size_t /*own_dial*/, Panel& panel) {
  const Bytes bytes(request.begin(), request.end());
  if (bytes.empty() || bytes[0] != kUnit) return {"", 0};  // somebody else is meant
  const GaugeBoxReply reply = gauge_box_answer(std::span(bytes).subspan(1), panel);
  Bytes frame =
      rtu_frame(static_cast<std::uint8_t>(kUnit + (reply.wrong_unit ? 1 : 0)), reply.pdu);
  if (reply.damaged) frame.back() = static_cast<std::uint8_t>(frame.back() ^ 0xFF);
  return {std::string(frame.begin(), frame.end()), 0, true};
}

std::string key_pressed(std::size_t /*dial*/, Panel& /*panel*/) { return {}; }
std::string power_on(std::size_t /*dial*/) { return {}; }

}  // namespace

DialScan scan_of(Panel& panel) {
  DialScan scan;
  for (std::size_t i = 0; i < panel.dial_count(); ++i) {
    const ShownDial shown = panel.show(i);
    DialRegisters dial;
    dial.counts =
        static_cast<std::int32_t>(std::lround(shown.value * (shown.inch ? 1e5 : 1e3)));
    dial.shown = static_cast<float>(shown.value);
    dial.status = shown.at_travel_end ? 19 : !shown.in_contact ? 1 : shown.low_battery ? 2 : 0;
    if (panel.take(i, Fault::kErrorLine)) {
      dial.valid = false;
      dial.status = 246;
    }
    scan.dials.push_back(dial);
  }
  scan.scan = panel.scan();
  return scan;
}

GaugeBoxReply gauge_box_answer(std::span<const std::uint8_t> pdu, Panel& panel) {
  GaugeBoxReply reply;
  const std::uint8_t function = pdu.empty() ? std::uint8_t{0} : pdu[0];
  for (std::size_t dial = 0; dial < panel.dial_count(); ++dial) {
    reply.wrong_unit |= panel.take(dial, Fault::kWrongUnitId).has_value();
    reply.damaged |= panel.take(dial, Fault::kCrcError).has_value();
    if (panel.take(dial, Fault::kBusy)) {
      reply.pdu = exception_pdu(function, static_cast<std::uint8_t>(ModbusException::kBusy));
    } else if (const auto order = panel.take(dial, Fault::kException)) {
      reply.pdu =
          exception_pdu(function, static_cast<std::uint8_t>(order->amount.value_or(4.0)));
    }
  }
  if (reply.pdu.empty()) {
    DialRegisterMap map([&] { return scan_of(panel); });
    reply.pdu = answer_pdu(pdu, map);
  }
  return reply;
}

const Dialect kModbusRtu{
    .name = "modbus_rtu",
    .line = {19200, 8, 'N', 1},
    .latency_s = 0.005,
    .shared = true,
    .longest_gap_s = 0.050,
    .take_request = take_request,
    .answer = answer,
    .key_pressed = key_pressed,
    .power_on = power_on};

}  // namespace sixdial::mock_devices
