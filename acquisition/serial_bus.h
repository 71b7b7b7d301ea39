// One serial port: a single dial's cable, or a multiplexer with several dials behind it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/bus.h"
#include "acquisition/dial_protocol.h"
#include "acquisition/serial_port.h"

namespace sixdial::acquisition {

struct SerialDial {
  DialLimits limits;
  int channel = 0;
  std::chrono::milliseconds timeout{300};  // device time
};

class SerialBus final : public Bus {
 public:
  /// Clock and board must outlive the bus.
  SerialBus(
      std::string device, const DialProtocol& protocol, std::vector<SerialDial> dials,
      Clock& clock, ReadingBoard& board);
  void run(const std::stop_token& stop) override;

 private:
  struct Answer {
    double value_mm = 0.0;
    DeviceTime requested{0};
    session::TimePoint time_utc{};
  };
  void connect(const std::stop_token& stop);
  void scan(const std::stop_token& stop);
  [[nodiscard]] bool check_identity(const std::stop_token& stop);
  void ask_battery(const std::stop_token& stop);
  tl::expected<Answer, Fault> ask(const SerialDial& dial, const std::stop_token& stop);
  tl::expected<double, Fault> listen(const SerialDial& dial, const std::stop_token& stop);
  void stay_quiet(const std::stop_token& stop);
  void publish_fault(const SerialDial& dial, const Fault& fault, DeviceTime requested);
  void publish_fault_for_all(const Fault& fault);
  void note_fault(const Fault& fault);

  std::string device_;
  const DialProtocol& protocol_;
  std::vector<SerialDial> dials_;
  Clock& clock_;
  ReadingBoard& board_;
  LinkHealth health_;
  std::optional<SerialPort> port_;
  Fault down_{FaultKind::kDisconnected, "not opened yet"};
  std::string identity_;  // as first answered; empty: never answered
  bool identity_checked_ = false;
  bool opened_before_ = false;
  bool asks_battery_ = false;  // the dial knows the question
  bool battery_low_ = false;
  DeviceTime battery_next_{0};
};

}  // namespace sixdial::acquisition
