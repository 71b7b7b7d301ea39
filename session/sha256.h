// SHA-256 (FIPS 180-4): the name by which results say which rig file and which data they are
// from.
#pragma once

#include <string>
#include <string_view>

namespace sixdial::session {

/// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace sixdial::session
