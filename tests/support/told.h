// What a study warned of.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "studies/plausibility.h"

namespace sixdial::studies {

/// The first warning with this code; null: there is none.
inline const Warning* told(const std::vector<Warning>& warnings, std::string_view code) {
  const auto found = std::ranges::find(warnings, code, &Warning::code);
  return found == warnings.end() ? nullptr : &*found;
}

}  // namespace sixdial::studies
