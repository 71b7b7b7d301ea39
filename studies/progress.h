// How far a study is, told while it runs.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace sixdial::studies {

struct Progress {
  std::string stage{};
  std::int64_t done = 0;
  std::int64_t total = 0;
  std::optional<double> best_mm{};  // best cost so far
  std::optional<double> eta_s{};    // of this stage
};
using ProgressCallback = std::function<void(Progress)>;

}  // namespace sixdial::studies
