// Ctrl-C and SIGTERM in a program that asks a service or calculates: what waits for the service
// ends by Interrupted, calculations are asked to stop, and whatever hears neither (a file that
// hangs, a long step) is ended within a second all the same.
#pragma once

#include <termios.h>

#include <chrono>
#include <stdexcept>

namespace sixdial::service {

/// A signal (Ctrl-C) came while waiting for the service.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// A signal to the process and its end by force, at the latest.
inline constexpr auto kLongestEnd = std::chrono::milliseconds(650);

/// From now on a signal is kept for take_interruption(); where nobody takes it within
/// kLongestEnd, the process ends.
void interrupt_on_signals();
/// Such a signal has come since it was last asked. Who takes it has to end.
[[nodiscard]] bool take_interruption();
/// The process ends by force after kLongestEnd, with these words (a literal) on stderr, unless
/// it has ended before.
void end_soon(const char* words);
/// Settings that the terminal gets back if the process is ended by force; null: none.
void restore_terminal_at_end(const termios* before);

}  // namespace sixdial::service
