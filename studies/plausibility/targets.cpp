// Targets that do not fit the joint values: of another part, another frame, another file. A
// robot's error "before" would be measured from them, and be anything.
#include <algorithm>
#include <cmath>

#include "session/sample_layout.h"
#include "studies/plausibility/check.h"
#include "studies/plausibility/tool_seen.h"

namespace sixdial::studies::plausibility {
namespace {

/// A commanded target differs from the nominal robot's place by what compensation corrects.
constexpr double kCorrected_mm = 3.0;
/// And not by many times what the robot itself misses.
constexpr double kTimesItsError = 4.0;
/// Where the targets as a whole fit, a single one must be further off than this to be wrong.
constexpr double kOneOff_mm = 10.0;
constexpr double kTimesTheOthers = 5.0;

/// Where the tool was measured, as far as a turn and a shift tell it from the nominal robot.
std::optional<geometry::Registration> registered(const session::Session& session) {
  std::optional<geometry::Registration> best;
  for (const ToolSeen& seen : tools_seen(session, measured_tool(session))) {
    auto found = geometry::register_points(seen.nominal_mm, seen.measured_mm);
    if (found && (!best || found->median < best->median)) best = std::move(found);
  }
  return best;
}

/// How far a target is from where the joint values put the nominal robot; `nearest_mm`: or, if
/// that is nearer, from where they put it in the frame of the measurement.
struct TargetMiss {
  double nominal_mm = 0.0, nearest_mm = 0.0;
};
std::optional<TargetMiss> miss_of(
    const geometry::Rig& rig, session::Sample sample,
    const std::optional<geometry::Registration>& measured) {
  const auto at = nominal_at_target(rig, sample);
  if (!at) return std::nullopt;
  const double miss = (*sample.target_mm - *at).norm();
  if (!measured) return TargetMiss{miss, miss};
  sample.target_mm = measured->X.inverse()(*sample.target_mm);
  const auto there = nominal_at_target(rig, sample);
  return TargetMiss{miss, there ? std::min(miss, (*sample.target_mm - *there).norm()) : miss};
}

}  // namespace

void look_at_targets(Look& look) {
  const auto measured = registered(look.used);
  std::vector<std::size_t> row;
  std::vector<double> off, from_nominal;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out || !sample.q.allFinite()) continue;
    const auto miss = miss_of(look.used.rig, sample, measured);
    if (!miss) continue;
    row.push_back(i);
    off.push_back(miss->nearest_mm);
    from_nominal.push_back(miss->nominal_mm);
  }
  if (row.empty()) return;
  double limit = std::max(kCorrected_mm, kTimesItsError * (measured ? measured->median : 0.0));
  const double middle = geometry::median_of(off);
  if (middle < limit) limit = std::max({limit, kOneOff_mm, kTimesTheOthers * middle});
  // Where most are wrong, one that fits does so by chance.
  const auto wrong = std::ranges::count_if(off, [&](double each) { return each > limit; });
  if (2 * wrong > std::ssize(off)) limit = -1.0;
  std::vector<std::size_t> elsewhere;
  std::vector<double> missed;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (!(off[i] > limit)) continue;
    elsewhere.push_back(row[i]);
    missed.push_back(from_nominal[i]);
    look.used.samples[row[i]].target_mm.reset();
  }
  if (elsewhere.empty()) return;
  std::string columns;
  for (const std::string& axis : session::layout_of(look.used.rig).axes) {
    columns += (columns.empty() ? "target_" : ", target_") + axis + "_mm";
  }
  look.tell(
      "targets_elsewhere", Severity::kNote, look.rows(elsewhere, std::move(columns)),
      {{"targets", static_cast<double>(row.size())},
       {"miss", geometry::median_of(std::move(missed))}});
}

}  // namespace sixdial::studies::plausibility
