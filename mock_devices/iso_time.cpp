#include "mock_devices/iso_time.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <chrono>
#include <stdexcept>

namespace sixdial::mock_devices {

std::int64_t milliseconds_of(std::string_view text) {
  const auto refuse = [&] {
    return std::invalid_argument(
        fmt::format("'{}' is not a time; write it as 2026-03-02T08:30:06.976Z", text));
  };
  constexpr std::string_view kPattern = "dddd-dd-ddTdd:dd:dd.dddZ";
  std::string whole(text);
  if (whole.size() == 20 && whole.back() == 'Z') whole.insert(19, ".000");
  if (whole.size() != kPattern.size()) throw refuse();
  for (std::size_t i = 0; i < kPattern.size(); ++i) {
    const bool digit = whole[i] >= '0' && whole[i] <= '9';
    if (kPattern[i] == 'd' ? !digit : whole[i] != kPattern[i]) throw refuse();
  }
  const auto field = [&](std::size_t at, std::size_t length) {
    int value = 0;
    std::from_chars(whole.data() + at, whole.data() + at + length, value);
    return value;
  };
  using namespace std::chrono;
  const year_month_day date{
      year{field(0, 4)}, month{static_cast<unsigned>(field(5, 2))},
      day{static_cast<unsigned>(field(8, 2))}};
  if (!date.ok() || field(11, 2) > 23 || field(14, 2) > 59 || field(17, 2) > 59) throw refuse();
  const auto time = sys_days{date} + hours{field(11, 2)} + minutes{field(14, 2)} +
                    seconds{field(17, 2)} + milliseconds{field(20, 3)};
  return duration_cast<milliseconds>(time.time_since_epoch()).count();
}

std::string iso8601(std::int64_t milliseconds_since_1970) {
  using namespace std::chrono;
  const sys_time<milliseconds> time{milliseconds{milliseconds_since_1970}};
  const auto midnight = floor<days>(time);
  const year_month_day date{midnight};
  const hh_mm_ss clock{time - midnight};
  return fmt::format(
      "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
      static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
      clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
      clock.subseconds().count());
}

}  // namespace sixdial::mock_devices
