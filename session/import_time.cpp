#include "session/import_time.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <regex>

#include "session/csv.h"
#include "session/import_table.h"
#include "session/session.h"

namespace sixdial::session {
namespace {

constexpr std::size_t kLongest = 48;  // of a time stamp
constexpr std::string_view kDate =
    R"((?:(\d{4})([-/.])(\d{1,2})\2(\d{1,2})|(\d{1,2})\.(\d{1,2})\.(\d{4})))";
constexpr std::string_view kClock = R"((\d{1,2}):(\d{2})(?::(\d{2})(?:[.,](\d{1,9}))?)?)";
constexpr std::string_view kZone = R"( ?(?:(Z|UTC|GMT)|([+-])(\d{2}):?(\d{2}))?)";

bool matches(std::string_view cell, const std::regex& pattern, std::cmatch* parts = nullptr) {
  if (cell.size() > kLongest) return false;
  std::cmatch unused;
  return std::regex_match(
      cell.data(), cell.data() + cell.size(), parts == nullptr ? unused : *parts, pattern);
}

/// 0 where the part is not there.
int number(const std::cmatch& parts, std::size_t group) {
  return parts[group].matched ? std::stoi(parts[group].str()) : 0;
}

std::optional<ImportedTime> calendar_time(std::string_view cell) {
  static const std::regex kPattern(fmt::format("{}(?:[T ] *|, *){}{}", kDate, kClock, kZone));
  std::cmatch parts;
  if (cell.find(':') == cell.npos || !matches(cell, kPattern, &parts)) return std::nullopt;
  const bool year_first = parts[1].matched;
  const std::chrono::year_month_day date(
      std::chrono::year(number(parts, year_first ? 1 : 7)),
      std::chrono::month(static_cast<unsigned>(number(parts, year_first ? 3 : 6))),
      std::chrono::day(static_cast<unsigned>(number(parts, year_first ? 4 : 5))));
  const int hour = number(parts, 8);
  const int minute = number(parts, 9);
  const int second = number(parts, 10);
  if (!date.ok() || hour > 23 || minute > 59 || second > 59) return std::nullopt;
  std::string fraction = parts[11].str() + "000";
  const int offset_min =
      (parts[13].str() == "-" ? -1 : 1) * (60 * number(parts, 14) + number(parts, 15));
  const TimePoint time = std::chrono::sys_days(date) + std::chrono::hours(hour) +
                         std::chrono::minutes(minute - offset_min) +
                         std::chrono::seconds(second) +
                         std::chrono::milliseconds(std::stoi(fraction.substr(0, 3)));
  std::string utc = to_iso8601(time);
  if (!from_iso8601(utc)) return std::nullopt;  // an offset left the years of four digits
  return ImportedTime{std::move(utc), !parts[12].matched && !parts[13].matched};
}

}  // namespace

std::optional<ImportedTime> time_in(std::string_view cell, char decimal) {
  if (from_iso8601(cell)) return ImportedTime{std::string(cell), false};
  if (cell.size() == 14 && cell.find_first_not_of("0123456789") == cell.npos) {
    std::string iso = fmt::format(
        "{}-{}-{}T{}:{}:{}.000Z", cell.substr(0, 4), cell.substr(4, 2), cell.substr(6, 2),
        cell.substr(8, 2), cell.substr(10, 2), cell.substr(12, 2));
    if (!from_iso8601(iso)) return std::nullopt;
    return ImportedTime{std::move(iso), true};
  }
  if (auto time = calendar_time(cell)) return time;
  constexpr double kFirst_s = 6e8;  // 1989
  constexpr double kLast_s = 5e9;   // 2128
  const bool scientific = cell.find_first_of("eE") != cell.npos;
  const auto seconds = number_in(cell, decimal);
  if (scientific || !seconds || *seconds < kFirst_s || *seconds > kLast_s) return std::nullopt;
  const auto ms = static_cast<std::int64_t>(std::llround(*seconds * 1000.0));
  return ImportedTime{to_iso8601(TimePoint(std::chrono::milliseconds(ms))), false};
}

bool is_doubtful_date(std::string_view cell) {
  static const std::regex kPattern(R"(\d{1,2}[/-]\d{1,2}[/-]\d{4}( .*)?)");
  return matches(cell, kPattern);
}

bool is_date_alone(std::string_view cell) {
  static const std::regex kPattern{std::string(kDate)};
  return matches(cell, kPattern);
}

bool is_time_of_day(std::string_view cell) {
  static const std::regex kPattern(fmt::format("{}{}", kClock, kZone));
  return matches(cell, kPattern);
}

}  // namespace sixdial::session
