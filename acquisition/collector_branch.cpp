// The collector between working modes: how the robot stands, and what a person does where a
// plan goes on in another one.
#include <fmt/format.h>

#include <algorithm>

#include "acquisition/collector.h"

namespace sixdial::acquisition {

// How the legs stand before the first move: the tool is then on the dials' side of the elbows.
// A robot that has not moved since it was switched on, or is moved by hand, stands as the rig
// file says.
session::Branch Collector::branch_now(const std::stop_token& here) {
  const session::Branch by_rig{rig_.robot.working_mode, rig_.robot.assembly};
  const auto now = robot_.state(here);
  const bool stopped_before_moving = now && now->motion == Motion::kFault && now->moves == 0;
  if (!now || now->motion == Motion::kIdle || stopped_before_moving) return by_rig;
  // Without a cuboid there is no side on which the tool is known to be.
  if (!rig_.on_cuboid()) return by_rig;
  if (now->q.size() != plan_.points.front().q.size()) return by_rig;  // it cannot tell
  session::PlanPoint place;
  place.q = now->q;
  place.target_mm = rig_.cuboid.reference_pose_mm;
  return session::branch_of(rig_, place);
}

std::optional<Collector::Outcome> Collector::change_branch(
    std::size_t index, const std::stop_token& here, const std::stop_token& stop) {
  const session::Branch wanted = session::branch_of(rig_, plan_.points[index]);
  if (!branch_) branch_ = branch_now(here);
  if (here.stop_requested()) return interrupted(index, stop);
  if (*branch_ == wanted) return std::nullopt;
  const std::string change = fmt::format(
      "working mode {} (assembly {}) follows on {} (assembly {})", to_string(wanted.mode),
      static_cast<int>(wanted.assembly), to_string(branch_->mode),
      static_cast<int>(branch_->assembly));
  if (settings_.on_branch_change == OnBranchChange::kPause) {
    const Wish wish = wait_paused(
        index, PauseReason::kBranchChange,
        change + ", across singular poses: clear the dials and bring the legs over",
        "resume goes on, skip leaves the point out", stop);
    if (stop.stop_requested()) return Outcome::kStopped;
    if (wish == Wish::kSkip) return skipped(index, "skipped by the operator: " + change);
    last_q_.reset();  // moved by hand
    std::ranges::fill(last_move_, 0);
  }
  branch_ = wanted;
  remarks_.push_back(change);
  return std::nullopt;
}

}  // namespace sixdial::acquisition
