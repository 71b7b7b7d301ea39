#include "mock_devices/dials/dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace sixdial::mock_devices {

std::span<const Dialect* const> dialects() {
  static const std::array<const Dialect*, 5> all{&kSylvac, &kMahr, &kMux10, &kMw, &kModbusRtu};
  return all;
}

const Dialect* find_dialect(std::string_view name) {
  for (const Dialect* dialect : dialects()) {
    if (dialect->name == name) return dialect;
  }
  return nullptr;
}

std::optional<std::string> take_line(std::string& buffer) {
  while (true) {
    const std::size_t end = buffer.find_first_of("\r\n");
    if (end == std::string::npos) return std::nullopt;
    std::string line = buffer.substr(0, end);
    buffer.erase(0, end + 1);
    if (!line.empty()) return line;
  }
}

std::string signed_number(double value, int width, int decimals) {
  const std::string digits = fmt::format("{:0{}.{}f}", std::abs(value), width, decimals);
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;
  return (value < 0.0 && !zero ? "-" : "+") + digits;
}

std::string plain_command(std::string_view request) {
  std::string command;
  for (const char c : request) {
    if (c != ' ') {
      command += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
  }
  return command;
}

}  // namespace sixdial::mock_devices
