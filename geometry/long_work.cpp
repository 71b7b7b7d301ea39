#include "geometry/long_work.h"

#include <utility>

namespace sixdial::geometry {
namespace {

thread_local const LongWork* current = nullptr;

}  // namespace

LongWork::LongWork(std::stop_token stop, StepListener listener)
    : stop_(std::move(stop)), listener_(std::move(listener)), before_(current) {
  current = this;
}

LongWork::~LongWork() { current = before_; }

void LongWork::tell(std::string_view what, std::int64_t done, std::int64_t total) const {
  if (listener_) listener_(what, done, total);
}

void check_end() {
  if (current != nullptr && current->stop().stop_requested()) throw WorkEnded();
}

void tell_step(std::string_view what, std::int64_t done, std::int64_t total) {
  check_end();
  if (current != nullptr) current->tell(what, done, total);
}

std::stop_token stop_of_this_work() {
  return current == nullptr ? std::stop_token() : current->stop();
}

}  // namespace sixdial::geometry
