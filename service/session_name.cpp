#include "service/session_name.h"

#include <fmt/format.h>

#include "service/error.h"

namespace sixdial::service {

void check_session_name(const std::string& name) {
  constexpr std::size_t kLongest = 80;
  const bool fine = !name.empty() && name.size() <= kLongest && name.front() != '.' &&
                    name.find_first_not_of(
                        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
                        std::string::npos;
  if (!fine) {
    throw Error(
        ErrorCode::kInvalidParams,
        fmt::format("'{}' cannot be a session's name", name.substr(0, kLongest)),
        {{"param", "name"}}, "Letters, digits, '.', '_' and '-', at most 80 of them.");
  }
}

}  // namespace sixdial::service
