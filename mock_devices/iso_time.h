// "2026-03-02T08:30:06.976Z" and milliseconds since 1970, UTC.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sixdial::mock_devices {

/// Throws std::invalid_argument if the text is not of this form; milliseconds may be left out.
[[nodiscard]] std::int64_t milliseconds_of(std::string_view iso8601_utc);
[[nodiscard]] std::string iso8601(std::int64_t milliseconds);

}  // namespace sixdial::mock_devices
