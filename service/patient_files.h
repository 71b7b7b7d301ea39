// Work on files that a client has named. Such a file may hang: a pipe nobody writes into, a
// network share that is gone. Then the client gets an error, and nobody else waits.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>

#include "service/methods/method.h"

namespace sixdial::service {

inline constexpr auto kFilePatience = std::chrono::seconds(10);

/// Runs `work` on a thread of its own and waits for it. Throws what it throws; Error file once
/// `patience` is over, or at once while too many earlier ones still hang; Error shutting_down
/// when the service goes down. After one of these errors the work may still be running: it must
/// own all it touches.
void run_patiently(
    const Service& service, const std::filesystem::path& path, std::function<void()> work,
    std::chrono::milliseconds patience = kFilePatience);

/// The same, and gives what the work returns.
template <class Work>
[[nodiscard]] auto with_patience(
    const Service& service, const std::filesystem::path& path, Work work,
    std::chrono::milliseconds patience = kFilePatience) {
  const auto result = std::make_shared<std::optional<std::invoke_result_t<Work>>>();
  run_patiently(
      service, path, [result, work = std::move(work)]() mutable { result->emplace(work()); },
      patience);
  return *std::move(*result);
}

}  // namespace sixdial::service
