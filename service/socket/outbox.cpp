#include "service/socket/outbox.h"

#include <utility>

namespace sixdial::service {

void Outbox::Gap::add(std::uint64_t first, std::uint64_t last, std::uint64_t events) {
  if (count == 0) from = first;
  to = last;
  count += events;
}

void Outbox::push_answer(std::string line) {
  line += '\n';
  answer_bytes_ += line.size();
  answers_.push_back(std::move(line));
}

void Outbox::push_event(EventPtr event) {
  if (event->topic == kLiveTopic) {
    if (live_) live_gap_.add(live_->seq, live_->seq, 1);
    live_ = std::move(event);
    return;
  }
  events_.push_back(std::move(event));
  if (events_.size() > max_events_) {
    gap_.add(events_.front()->seq, events_.front()->seq, 1);
    events_.pop_front();
  }
}

void Outbox::push_gap(std::uint64_t from_seq, std::uint64_t to_seq, std::uint64_t count) {
  gap_.add(from_seq, to_seq, count);
}

void Outbox::drop_events() {
  events_.clear();
  live_.reset();
  gap_ = live_gap_ = {};
}

std::optional<std::string> Outbox::pop() {
  if (!answers_.empty()) {
    std::string line = std::move(answers_.front());
    answers_.pop_front();
    answer_bytes_ -= line.size();
    return line;
  }
  if (gap_.count > 0) {
    const Gap gap = std::exchange(gap_, {});
    return gap_line(gap.from, gap.to, gap.count, false) + '\n';
  }
  if (!events_.empty() && (!live_ || events_.front()->seq < live_->seq)) {
    const EventPtr event = std::move(events_.front());
    events_.pop_front();
    return event->line + '\n';
  }
  if (live_gap_.count > 0) {
    const Gap gap = std::exchange(live_gap_, {});
    return gap_line(gap.from, gap.to, gap.count, true) + '\n';
  }
  if (live_) return std::exchange(live_, nullptr)->line + '\n';
  return std::nullopt;
}

bool Outbox::empty() const {
  return answers_.empty() && gap_.count == 0 && events_.empty() && !live_ &&
         live_gap_.count == 0;
}

}  // namespace sixdial::service
