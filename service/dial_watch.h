// The dials of a session's rig shown while nothing is collected: as live events, five a second,
// for as long as somebody asks for them; on request with the check "push each with a finger".
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "acquisition/clock.h"
#include "acquisition/dial_bank.h"
#include "acquisition/push_check.h"
#include "db/store.h"
#include "service/error.h"
#include "service/live_dials.h"
#include "service/socket/event_hub.h"

namespace sixdial::service {

/// {asked: id or null, instruction, done, good, dials [{dial, verdict, words}]}.
[[nodiscard]] Json check_json(const acquisition::PushCheck& check, const geometry::Rig& rig);

class DialWatch {
 public:
  /// All must outlive it.
  DialWatch(EventHub& events, db::Store& reader, acquisition::Clock& clock);
  ~DialWatch();
  DialWatch(const DialWatch&) = delete;
  DialWatch& operator=(const DialWatch&) = delete;

  /// Begins, or goes on, until `longest` from now by the wall clock; a watch of another session
  /// ends. Throws Error not_found, bad_data
  /// (a rig without dials, connection strings).
  Json watch(const std::string& session, std::chrono::milliseconds longest);
  enum class CheckStep { kStart, kAgain, kSkip, kEnd };
  /// Throws Error wrong_state where the dials are not watched.
  Json check(CheckStep step);
  /// Lets go of the ports, and waits for that.
  void stop();
  /// {watching, session, check or null}.
  [[nodiscard]] Json status() const;

 private:
  void run(const std::stop_token& stop);
  [[nodiscard]] Json status_locked() const;

  EventHub& events_;
  db::Store& reader_;
  acquisition::Clock& clock_;
  std::mutex thread_mutex_;  // who starts or joins thread_ holds it; taken before mutex_
  mutable std::mutex mutex_;
  std::condition_variable_any over_;
  bool watching_ = false;
  std::string session_;
  geometry::Rig rig_;
  std::chrono::steady_clock::time_point until_;
  std::unique_ptr<acquisition::DialBank> dials_;
  std::unique_ptr<acquisition::PushCheck> check_;
  std::jthread thread_;
};

}  // namespace sixdial::service
