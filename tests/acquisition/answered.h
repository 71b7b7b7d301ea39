// A scan in which nobody was merely slow: a loaded test machine may miss a deadline of 300 ms.
#pragma once

#include <algorithm>
#include <vector>

#include "acquisition/dial_bank.h"
#include "session/reason.h"

namespace sixdial::test {

inline std::vector<acquisition::Reading> answered(acquisition::DialBank& bank) {
  std::vector<acquisition::Reading> readings;
  for (int attempt = 0; attempt < 10; ++attempt) {
    readings = bank.scan({});
    const bool late = std::any_of(readings.begin(), readings.end(), [](const auto& each) {
      return each.reason == session::reason::kTimeout;
    });
    if (!late) break;
  }
  return readings;
}

}  // namespace sixdial::test
