// A gauge box on Modbus, TCP or RTU: all its dials in one read. Also several boxes (units) on
// one line.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "acquisition/bus.h"
#include "acquisition/modbus_link.h"

namespace sixdial::acquisition {

struct ModbusDial {
  DialLimits limits;
  int index = 0;  // place among the values of the box
};

/// One unit with its register map. Every index is below map.count.
struct ModbusBox {
  ModbusMap map;
  std::vector<ModbusDial> dials;
};

/// A dial's status word as a reading without value, or nothing where the value counts.
/// 0 ok, 1 no contact, 2 low battery (the value counts), 18 under, 19 over range, 246 wrong
/// probe, 247 no probe.
[[nodiscard]] std::optional<Fault> fault_of_status(std::uint16_t status);
inline constexpr std::uint16_t kStatusNoContact = 1;
inline constexpr std::uint16_t kStatusLowBattery = 2;

class ModbusBus final : public Bus {
 public:
  /// Clock and board must outlive the bus. `connection` gives end point and times.
  ModbusBus(
      const ModbusConnection& connection, std::vector<ModbusBox> boxes, Clock& clock,
      ReadingBoard& board);
  void run(const std::stop_token& stop) override;

 private:
  // What is known of a box since the last connection.
  struct Box {
    ModbusBox is;
    bool has_status = false;
    bool has_counter = false;
    bool counts = false;  // the counter was seen to move
    std::optional<std::uint16_t> counter;
    DeviceTime new_at{0};
    std::vector<std::uint16_t> status;
  };
  bool scan(Box& box, const std::stop_token& stop);
  tl::expected<void, Fault> read_extras(Box& box, const std::stop_token& stop);
  tl::expected<void, Fault> read_extra(
      Box& box, bool& has, int address, int count, Words& words, const std::stop_token& stop);
  void publish_values(const Box& box, const Words& words, DeviceTime requested);
  void fail(const Box& box, const Fault& fault, DeviceTime requested);
  void forget(Box& box) const;

  ModbusLink link_;
  std::vector<Box> boxes_;
  Clock& clock_;
  ReadingBoard& board_;
  std::uint64_t known_connection_ = 0;
};

}  // namespace sixdial::acquisition
