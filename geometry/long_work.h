// Long work that can be ended from outside, and that tells how far it is, however deep in its
// loops it stands. Whoever starts such work opens a LongWork in the thread that does it; the
// loops inside call check_end() or tell_step(). Without a LongWork both do nothing.
//
// Example:
//   std::stop_source stop;
//   stop.request_stop();
//   const LongWork work(stop.get_token());
//   bool ended = false;
//   try { check_end(); } catch (const WorkEnded&) { ended = true; }
//   ended;  // -> true
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <stop_token>
#include <string_view>

namespace sixdial::geometry {

/// The work was asked to end, and ends here. No result is lost that anybody waits for.
class WorkEnded : public std::runtime_error {
 public:
  WorkEnded() : std::runtime_error("ended as asked") {}
};

/// "scoring causes", 12 of 132.
using StepListener =
    std::function<void(std::string_view what, std::int64_t done, std::int64_t total)>;

class LongWork {
 public:
  /// For this thread, until the end of the scope; the one before counts again then.
  explicit LongWork(std::stop_token stop, StepListener listener = {});
  ~LongWork();
  LongWork(const LongWork&) = delete;
  LongWork& operator=(const LongWork&) = delete;
  [[nodiscard]] const std::stop_token& stop() const { return stop_; }
  void tell(std::string_view what, std::int64_t done, std::int64_t total) const;

 private:
  const std::stop_token stop_;
  const StepListener listener_;
  const LongWork* const before_;
};

/// Throws WorkEnded if this thread's work was asked to end. A few nanoseconds.
void check_end();
/// check_end(), and tells the step that begins now.
void tell_step(std::string_view what, std::int64_t done, std::int64_t total);
/// For a thread that does a share of this thread's work.
[[nodiscard]] std::stop_token stop_of_this_work();

}  // namespace sixdial::geometry
