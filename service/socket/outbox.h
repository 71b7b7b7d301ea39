// Lines on their way to one client. Answers are never dropped (the reader waits instead);
// events are bounded: the oldest go first, live readings keep only the newest, and a gap line
// says so.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "service/socket/event_hub.h"

namespace sixdial::service {

class Outbox {
 public:
  explicit Outbox(std::size_t max_events = 1024) : max_events_(max_events) {}

  void push_answer(std::string line);
  void push_event(EventPtr event);
  /// Queues a line that says which events were lost before they could be queued (a replay that
  /// begins too late).
  void push_gap(std::uint64_t from_seq, std::uint64_t to_seq, std::uint64_t count);
  void drop_events();

  /// The next line with its newline; empty if there is none.
  [[nodiscard]] std::optional<std::string> pop();
  [[nodiscard]] bool empty() const;
  [[nodiscard]] std::size_t answer_bytes() const { return answer_bytes_; }

 private:
  struct Gap {
    std::uint64_t from = 0, to = 0, count = 0;
    void add(std::uint64_t first, std::uint64_t last, std::uint64_t events);
  };
  const std::size_t max_events_;
  std::deque<std::string> answers_;
  std::size_t answer_bytes_ = 0;
  std::deque<EventPtr> events_;
  EventPtr live_;  // newest live reading not yet sent
  Gap gap_, live_gap_;
};

}  // namespace sixdial::service
