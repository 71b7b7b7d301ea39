// A value that may be missing, as JSON.
#pragma once

#include <optional>

#include "service/error.h"

namespace sixdial::service {

template <typename T>
[[nodiscard]] Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace sixdial::service
