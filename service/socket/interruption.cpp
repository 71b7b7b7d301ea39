#include "service/socket/interruption.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <ctime>

#include "service/error.h"

namespace sixdial::service {
namespace {

volatile std::sig_atomic_t interrupted = 0;
timer_t last_resort{};
std::atomic<bool> has_timer = false;
std::atomic<const char*> last_words = nullptr;
std::atomic<const termios*> terminal_before = nullptr;
static_assert(std::atomic<const char*>::is_always_lock_free);  // for a signal's handler

constexpr const char* kNothingKept = "\ninterrupted; nothing of it is kept\n";

/// Zero: the timer is taken back. May be called in a signal's handler.
void set_timer(std::chrono::milliseconds after) {
  if (!has_timer) return;
  itimerspec when{};
  const auto whole_s = std::chrono::duration_cast<std::chrono::seconds>(after);
  when.it_value.tv_sec = whole_s.count();
  when.it_value.tv_nsec = std::chrono::nanoseconds(after - whole_s).count();
  ::timer_settime(last_resort, 0, &when, nullptr);
}

void on_interrupt(int) {
  interrupted = 1;
  last_words = kNothingKept;
  set_timer(kLongestEnd);
}

void on_last_resort(int) {
  if (const termios* before = terminal_before) ::tcsetattr(STDIN_FILENO, TCSANOW, before);
  const char* words = last_words;
  if (words != nullptr && ::write(STDERR_FILENO, words, std::strlen(words)) < 0) {
    // Nobody hears it.
  }
  ::_exit(static_cast<int>(ExitCode::kInterrupted));
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  // A write to the terminal goes on, or half of it would be lost; poll ends all the same.
  action.sa_flags = SA_RESTART;
  ::sigaction(signal, &action, nullptr);
}

}  // namespace

void interrupt_on_signals() {
  sigevent event{};
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = SIGALRM;
  has_timer = ::timer_create(CLOCK_MONOTONIC, &event, &last_resort) == 0;
  handle(SIGALRM, on_last_resort);
  handle(SIGINT, on_interrupt);
  handle(SIGTERM, on_interrupt);
}

bool take_interruption() {
  if (interrupted == 0) return false;
  interrupted = 0;
  set_timer(std::chrono::milliseconds(0));
  return true;
}

void end_soon(const char* words) {
  last_words = words;
  set_timer(kLongestEnd);
}

void restore_terminal_at_end(const termios* before) { terminal_before = before; }

}  // namespace sixdial::service
