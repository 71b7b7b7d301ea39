// How far a study is, told while it runs.
#pragma once

#include <chrono>
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
  std::optional<double> eta_s{};    // of the whole, else of this stage
};
using ProgressCallback = std::function<void(Progress)>;

/// How long a study still takes that has done `fraction` of its work since `began`; empty: it
/// is too early to tell.
[[nodiscard]] inline std::optional<double> time_left_s(
    std::chrono::steady_clock::time_point began, double fraction) {
  constexpr double kTooEarly = 0.02;
  if (fraction < kTooEarly) return std::nullopt;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began;
  return spent.count() * (1.0 - fraction) / fraction;
}

}  // namespace sixdial::studies
