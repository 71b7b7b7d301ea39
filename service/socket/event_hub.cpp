#include "service/socket/event_hub.h"

#include <fmt/format.h>

#include <algorithm>

#include "service/socket/request.h"
#include "session/clock_text.h"

namespace sixdial::service {
namespace {

std::string event_line(std::uint64_t seq, std::string_view topic, Json data) {
  const auto line_with = [&](const Json& content) {
    return to_line(
        {{"jsonrpc", "2.0"},
         {"method", "events.event"},
         {"params",
          {{"seq", seq},
           {"topic", topic},
           {"time_utc", session::now_utc_text()},
           {"data", content}}}});
  };
  std::string line = line_with(data);
  if (line.size() + 1 < kMaxLineBytes) return line;
  return line_with({{"type", data.value("type", "")}, {"too_large_bytes", line.size()}});
}

}  // namespace

EventHub::EventHub(std::size_t kept) : kept_(kept), epoch_(session::now_utc_text()) {}

std::uint64_t EventHub::publish(std::string_view topic, Json data) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t seq = ++last_seq_;
  auto event = std::make_shared<const Event>(
      Event{seq, std::string(topic), event_line(seq, topic, std::move(data))});
  if (topic != kLiveTopic) {
    ring_.push_back(event);
    if (ring_.size() > kept_) {
      dropped_to_ = ring_.front()->seq;
      ring_.pop_front();
    }
  }
  if (listener_) listener_(event);
  return seq;
}

Replay EventHub::since(std::uint64_t since_seq, const std::vector<std::string>& topics) const {
  const std::lock_guard lock(mutex_);
  Replay replay;
  replay.last_seq = last_seq_;
  if (dropped_to_ > since_seq) {
    replay.lost_from = since_seq + 1;
    replay.lost_to = dropped_to_;
  }
  const auto first = std::ranges::upper_bound(ring_, since_seq, {}, &Event::seq);
  for (auto each = first; each != ring_.end(); ++each) {
    if (topics.empty() || std::ranges::find(topics, (*each)->topic) != topics.end()) {
      replay.events.push_back(*each);
    }
  }
  return replay;
}

std::uint64_t EventHub::last_seq() const {
  const std::lock_guard lock(mutex_);
  return last_seq_;
}

void EventHub::set_listener(std::function<void(const EventPtr&)> listener) {
  const std::lock_guard lock(mutex_);
  listener_ = std::move(listener);
}

std::string gap_line(
    std::uint64_t from_seq, std::uint64_t to_seq, std::uint64_t count, bool live) {
  return to_line(
      {{"jsonrpc", "2.0"},
       {"method", "events.gap"},
       {"params",
        {{"from_seq", from_seq}, {"to_seq", to_seq}, {"count", count}, {"live", live}}}});
}

}  // namespace sixdial::service
