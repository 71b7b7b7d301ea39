// What the collector looks after while the robot moves: that a person has looked before the
// first move, and that the dials keep the cuboid.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <thread>

#include "acquisition/collector.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

constexpr std::chrono::milliseconds kLookEvery{50};  // on the wall
constexpr std::size_t kHaltBy = 2;                   // dials at once: one may stick or be slow
constexpr int kLooksAtPath = 8;

/// Sees the dials lose the cuboid while another thread waits for the robot.
class ContactWatch {
 public:
  ContactWatch(DialSource& dials, std::vector<std::size_t> sure, DeviceTime began)
      : dials_(dials), sure_(std::move(sure)), began_(began) {}

  /// Until `over`; asks `halt` to stop, once, if it comes to that.
  void run(const std::stop_token& over, std::stop_source halt) {
    std::mutex mutex;
    std::condition_variable_any ended;
    std::unique_lock lock(mutex);
    std::vector<std::uint64_t> seen;
    while (!ended.wait_for(lock, over, kLookEvery, [&] { return over.stop_requested(); })) {
      const std::vector<Reading> readings = dials_.latest();
      std::vector<std::size_t> free;
      std::vector<std::uint64_t> when;
      for (const std::size_t i : sure_) {
        const bool lost = i < readings.size() && readings[i].requested >= began_ &&
                          readings[i].reason == session::reason::kNoContact;
        if (!lost) continue;
        free.push_back(i);
        when.push_back(readings[i].sequence);
      }
      if (free.size() < kHaltBy) {
        seen.clear();
        continue;
      }
      // Another answer of each must say the same: one may be a slip of the line.
      if (free == lost_ && !seen.empty() && std::ranges::equal(when, seen, std::greater{})) {
        tripped_ = true;
        halt.request_stop();
        return;
      }
      if (free != lost_ || seen.empty()) {
        lost_ = free;
        seen = when;
      }
    }
  }
  /// Empty: nothing was lost. After run() has ended.
  [[nodiscard]] std::vector<std::size_t> lost() const {
    return tripped_ ? lost_ : std::vector<std::size_t>{};
  }

 private:
  DialSource& dials_;
  const std::vector<std::size_t> sure_;
  const DeviceTime began_;
  std::vector<std::size_t> lost_;
  bool tripped_ = false;
};

}  // namespace

bool Collector::asked_before_first_move(const std::stop_token& stop) {
  if (before_first_move_.empty()) return !stop.stop_requested();
  const std::optional<std::size_t> first =
      pending_.empty() ? std::nullopt : std::optional(pending_.front());
  (void)wait_paused(
      first, PauseReason::kFirstMove, before_first_move_, "resume begins to move, stop ends it",
      stop);
  if (!stop.stop_requested()) return true;
  report(CollectorStage::kStopped, std::nullopt);
  return false;
}

// Those that the nominal robot pushes in by more than it may be wrong, from where it stands all
// the way to q.
std::vector<std::size_t> Collector::sure_contacts(const Eigen::VectorXd& q) const {
  std::vector<std::size_t> sure;
  if (!last_q_ || last_q_->size() != q.size()) return sure;
  for (std::size_t i = 0; i < rig_.dials.size(); ++i) sure.push_back(i);
  for (int step = 0; step <= kLooksAtPath && !sure.empty(); ++step) {
    const double share = static_cast<double>(step) / kLooksAtPath;
    const std::vector<ExpectedDial> expected = plausibility_.expected_at(
        *last_q_ + share * (q - *last_q_),
        branch_ ? std::optional(branch_->assembly) : std::nullopt);
    std::erase_if(sure, [&](std::size_t i) {
      const auto& there = expected[i].displacement_mm;
      return !there || *there <= settings_.implausible_mm;
    });
  }
  return sure;
}

tl::expected<RobotState, RobotFault> Collector::guarded_move(
    const Eigen::VectorXd& q, const std::stop_token& here) {
  lost_.clear();
  std::vector<std::size_t> sure;
  if (settings_.halt_on_lost_contact && !robot_.by_hand()) sure = sure_contacts(q);
  if (sure.size() < kHaltBy) return robot_.move_to(q, settings_.move_timeout, here);
  std::stop_source halt;
  const std::stop_callback relay(here, [&] { halt.request_stop(); });
  ContactWatch watch(dials_, std::move(sure), clock_.monotonic());
  std::jthread eye([&](const std::stop_token& over) { watch.run(over, halt); });
  auto arrived = robot_.move_to(q, settings_.move_timeout, halt.get_token());
  eye.request_stop();
  eye.join();
  for (const std::size_t i : watch.lost()) lost_.push_back(rig_.dials[i].id);
  if (!lost_.empty() && arrived) {  // it was there before the halt reached it
    return tl::unexpected(RobotFault{RobotFaultKind::kHalted, "dials lost the cuboid"});
  }
  return arrived;
}

Collector::Outcome Collector::lost_contact(std::size_t index, const std::stop_token& stop) {
  const std::string trouble = fmt::format(
      "dials {} should touch the cuboid and touch nothing: the robot was halted",
      fmt::join(lost_, ", "));
  lost_.clear();
  const Wish wish = wait_paused(
      index, PauseReason::kLostContact, trouble,
      "look at cuboid, clamp and dials before anything moves; resume goes on, skip leaves the "
      "point out",
      stop);
  if (stop.stop_requested()) return Outcome::kStopped;
  return wish == Wish::kSkip ? skipped(index, "skipped by the operator: " + trouble)
                             : Outcome::kAgain;
}

}  // namespace sixdial::acquisition
