// One pseudo-terminal with a dial, or a multiplexer, at its other end. Used by wire.cpp's
// thread.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mock_devices/dials/dialect.h"
#include "mock_devices/ports.h"

namespace sixdial::mock_devices {

class SerialLine {
 public:
  using Clock = std::chrono::steady_clock;

  /// `speed`: mock seconds a wall second. `seed`: for the noise byte.
  SerialLine(
      const Dialect& dialect, std::size_t dial, std::unique_ptr<Panel> panel,
      std::filesystem::path link, double speed, std::uint64_t seed);
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  [[nodiscard]] int descriptor() const {  // -1 while hung up
    return terminal_ ? terminal_->descriptor() : -1;
  }
  [[nodiscard]] const std::filesystem::path& link() const { return link_; }
  void read_and_answer();
  /// Sends what is due and carries out faults that need no question.
  void attend(Clock::time_point now);
  /// When attend() is needed next.
  [[nodiscard]] std::optional<Clock::time_point> next_due() const;

 private:
  struct Out {
    Clock::time_point first;  // end of the first character
    Clock::duration each;
    std::string bytes;
    std::size_t sent = 0;
  };
  void hang_up();
  void answer(const std::string& request);
  void send(std::string bytes, Clock::duration after);
  [[nodiscard]] std::vector<std::size_t> own_dials() const;

  const Dialect dialect_;
  const std::size_t dial_;
  const std::unique_ptr<Panel> panel_;
  const std::filesystem::path link_;
  const double speed_;
  const std::uint64_t seed_;
  std::uint64_t noise_count_ = 0;
  std::optional<PseudoTerminal> terminal_;  // empty: hung up
  std::string in_;
  Clock::time_point last_in_{};
  Clock::time_point free_at_{};
  std::deque<Out> out_;
  std::optional<Clock::time_point> comes_back_;
};

}  // namespace sixdial::mock_devices
