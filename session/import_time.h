// Time stamps as files write them.
//
//   time_in("2026-11-30 10:09:25.5", '.')->utc;  // "2026-11-30T10:09:25.500Z", zone assumed
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sixdial::session {

struct ImportedTime {
  std::string utc;            // ISO 8601
  bool zone_assumed = false;  // the cell names no zone: taken as UTC
};

/// ISO 8601 with 'T' or a blank, in UTC, with an offset or without a zone; year, month and day
/// with '-', '/' or '.', or day.month.year with '.'; seconds since 1970; 14 digits
/// YYYYMMDDhhmmss. Empty: it is none of these.
[[nodiscard]] std::optional<ImportedTime> time_in(std::string_view cell, char decimal);

/// "03/04/2026 10:09": nobody can tell its day from its month.
[[nodiscard]] bool is_doubtful_date(std::string_view cell);

/// A date alone ("2026-11-30"), a time of day alone ("10:09:25.5").
[[nodiscard]] bool is_date_alone(std::string_view cell);
[[nodiscard]] bool is_time_of_day(std::string_view cell);

}  // namespace sixdial::session
