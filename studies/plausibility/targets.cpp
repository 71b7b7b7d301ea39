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

/// What the robot misses wherever its frame stands, half of all poses.
double own_error_mm(const session::Session& session) {
  double least = HUGE_VAL;
  for (const ToolSeen& seen : tools_seen(session, measured_tool(session))) {
    const auto found = geometry::register_points(seen.nominal_mm, seen.measured_mm);
    if (found) least = std::min(least, found->median);
  }
  return std::isfinite(least) ? least : 0.0;
}

}  // namespace

void look_at_targets(Look& look) {
  std::vector<std::size_t> row;
  std::vector<double> off;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out || !sample.q.allFinite()) continue;
    const auto at = nominal_at_target(look.used.rig, sample);
    if (!at) continue;
    double miss = (*sample.target_mm - *at).norm();
    // A base that was put where it was measured leaves targets where the file's robot has them.
    session::Sample as_filed = sample;
    as_filed.target_mm = look.measured.samples[i].target_mm;
    const auto filed = nominal_at_target(look.measured.rig, as_filed);
    if (filed) miss = std::min(miss, (*as_filed.target_mm - *filed).norm());
    row.push_back(i);
    off.push_back(miss);
  }
  if (row.empty()) return;
  double limit = std::max(kCorrected_mm, kTimesItsError * own_error_mm(look.used));
  const double middle = geometry::median_of(off);
  if (middle < limit) limit = std::max({limit, kOneOff_mm, kTimesTheOthers * middle});
  std::vector<std::size_t> elsewhere;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (!(off[i] > limit)) continue;
    elsewhere.push_back(row[i]);
    look.used.samples[row[i]].target_mm.reset();
  }
  if (elsewhere.empty()) return;
  WarningParts parts{
      {"targets", static_cast<double>(row.size())}, {"miss", geometry::median_of([&] {
                                                       std::vector<double> of;
                                                       for (const double each : off) {
                                                         if (each > limit) of.push_back(each);
                                                       }
                                                       return of;
                                                     }())}};
  look.tell(
      "targets_elsewhere", Severity::kNote, look.rows(elsewhere, "target_x_mm, target_y_mm"),
      parts);
}

}  // namespace sixdial::studies::plausibility
