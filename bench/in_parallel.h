// Drawn sessions on several threads, in the order of their numbers whatever the number of
// threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <optional>
#include <thread>
#include <vector>

namespace sixdial::blind {

/// `try_one(i)` -> std::optional<Outcome>, for i = 0 to sessions - 1; those that are there.
template <typename Outcome, typename TryOne>
[[nodiscard]] std::vector<Outcome> tried_in_parallel(
    int sessions, int threads, TryOne&& try_one) {
  std::vector<std::optional<Outcome>> drawn(static_cast<std::size_t>(sessions));
  std::atomic<int> next{0};
  std::vector<std::jthread> workers;
  for (int w = 0; w < threads; ++w) {
    workers.emplace_back([&] {
      for (int i = next++; i < sessions; i = next++) {
        drawn[static_cast<std::size_t>(i)] = try_one(i);
      }
    });
  }
  workers.clear();
  std::vector<Outcome> result;
  for (auto& each : drawn) {
    if (each) result.push_back(std::move(*each));
  }
  return result;
}

}  // namespace sixdial::blind
