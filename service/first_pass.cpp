#include "service/first_pass.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "acquisition/plausibility.h"
#include "session/plan_outline.h"
#include "session/reason.h"

namespace sixdial::service {
namespace {

[[noreturn]] void no_speed(const acquisition::RobotFault& fault) {
  throw Error(
      ErrorCode::kDevice,
      fmt::format(
          "the robot's speed cannot be set, so nothing was moved: {}: {}",
          acquisition::describe(fault.kind), fault.detail),
      {{"field", "robot"}},
      "Look at the controller; sixdial rig scan --rig tells whether it answers.");
}

}  // namespace

ReducedSpeed::ReducedSpeed(acquisition::RobotPort& robot, std::optional<int> percent)
    : robot_(robot) {
  if (!percent) return;
  const auto now = robot_.speed({});
  if (!now) no_speed(now.error());
  before_ = *now;
  if (const auto set = robot_.set_speed(*percent, {}); !set) no_speed(set.error());
}

ReducedSpeed::~ReducedSpeed() {
  if (!before_) return;
  const auto set = robot_.set_speed(*before_, {});
  if (!set) spdlog::warn("the robot keeps its reduced speed: {}", set.error().detail);
}

void Collection::prepare_first_pass(Run& run) {
  run.plan = session::outermost(run.rig, run.plan);
  if (!run.speed_percent) run.speed_percent = kFirstPassSpeed_percent;
  run.before_first_move = fmt::format(
      "first pass to the {} outermost points at {} % of full speed; nothing is stored. Look "
      "first: nobody in reach of the links, the emergency stop at hand; {}no link, clamp or "
      "cable meets a dial on the way",
      run.plan.points.size(), *run.speed_percent,
      run.rig.on_cuboid() ? "every plunger meets its face of the cuboid at the height of the "
                            "face's middle, and "
                          : "");
}

// Judged as a sample is, but by a person at the rig and at once: what is far off here may be a
// dial that stands elsewhere than the rig file says, and the next point a collision.
void Collection::on_rehearsed(Run& run, const acquisition::CollectedSample& collected) {
  std::vector<std::string> odd;
  for (std::size_t i = 0; i < run.rig.dials.size(); ++i) {
    const session::ChannelValue& channel = collected.sample.channels[i];
    if (channel.quality == session::Quality::kGood) continue;
    if (channel.reason == session::reason::kUnsettled ||
        channel.reason == session::reason::kLowBattery) {
      continue;
    }
    odd.push_back(run.rig.dials[i].id);
  }
  const std::string remarks = fmt::format("{}", fmt::join(collected.remarks, "; "));
  if (odd.empty() || run.doubted == collected.plan_index) {
    run.doubted.reset();
    return;
  }
  run.doubted = collected.plan_index;
  throw acquisition::StoreLater(fmt::format(
      "first pass: dial {} does not show what the rig file and the nominal robot say ({}). "
      "Look "
      "whether it stands where the rig file says before going on",
      fmt::join(odd, ", "), remarks));
}

}  // namespace sixdial::service
