// What happens in the service, numbered and kept for a while, so that a client that lost its
// connection can go on where it was. Any thread may publish; the listener (the socket's loop)
// is called in the order of the numbers.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "service/error.h"

namespace sixdial::service {

/// "job": stages, progress and ends of jobs. "sample": each stored sample. "collect": state of
/// a collection. "session": one was created, imported, or had a sample withdrawn. "live": the
/// dials as they are now; never replayed, the newest wins. "service".
inline constexpr std::array<std::string_view, 6> kTopics{"job",     "sample", "collect",
                                                         "session", "live",   "service"};
inline constexpr std::string_view kLiveTopic = "live";

struct Event {
  std::uint64_t seq = 0;
  std::string topic;
  std::string line;  // the whole notification, ready to send
};
using EventPtr = std::shared_ptr<const Event>;

struct Replay {
  std::vector<EventPtr> events;
  std::uint64_t lost_from = 0;  // 0: nothing lost
  std::uint64_t lost_to = 0;
  std::uint64_t last_seq = 0;
};

class EventHub {
 public:
  explicit EventHub(std::size_t kept = 4096);

  /// Numbers and hands on one event; returns its number. Any thread.
  std::uint64_t publish(std::string_view topic, Json data);
  /// Events after `since_seq` of these topics (all if empty) that are still kept.
  [[nodiscard]] Replay since(
      std::uint64_t since_seq, const std::vector<std::string>& topics) const;
  [[nodiscard]] std::uint64_t last_seq() const;
  /// Tells one run of the service from the next: numbers begin at 1 in each.
  [[nodiscard]] const std::string& epoch() const { return epoch_; }
  /// Called under the hub's lock, in order: it must do no more than pass the event on. Empty:
  /// nobody listens.
  void set_listener(std::function<void(const EventPtr&)> listener);

 private:
  const std::size_t kept_;
  const std::string epoch_;
  mutable std::mutex mutex_;
  std::uint64_t last_seq_ = 0;
  std::uint64_t dropped_to_ = 0;  // newest number that fell out of the ring
  std::deque<EventPtr> ring_;
  std::function<void(const EventPtr&)> listener_;
};

/// Notification that events were left out for a client.
[[nodiscard]] std::string gap_line(
    std::uint64_t from_seq, std::uint64_t to_seq, std::uint64_t count, bool live);

}  // namespace sixdial::service
