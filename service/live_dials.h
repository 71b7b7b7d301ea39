// What a person at the rig sees of the dials while a session is collected: each reading with a
// state in one word, how far they are from rest, and where the readings put the tool.
#pragma once

#include <string_view>
#include <vector>

#include "acquisition/collector.h"
#include "acquisition/reading.h"
#include "geometry/rig.h"
#include "service/error.h"
#include "session/plan.h"

namespace sixdial::service {

enum class DialState {
  kOk,        // a value that rests; while nothing is collected, any value
  kSettling,  // a value that still moves
  kWaiting,   // no value while the robot moves: some dials give none then
  kFree,      // at its end stop: touches nothing, which is normal for three of six
  kStale,     // the newest answer is too old
  kLost,      // no answer, or one that cannot be read
};
[[nodiscard]] std::string_view to_string(DialState state);

class LiveDials {
 public:
  explicit LiveDials(const geometry::Rig& rig) : rig_(rig) {}

  /// {stage, dials {id: {value_mm, quality, reason, words, detail?, state}}, settle {spread_mm,
  /// limit_mm, settled, dial}, pose {x_mm, y_mm, gamma_rad, dials [ids]} or null}. `settle`:
  /// the spread of the dial furthest from rest, and whether all have settled, as the collector
  /// judged them last; all null while
  /// nobody waits for the dials. `point`: the one in hand, null before the first; it tells how
  /// the cuboid is turned.
  [[nodiscard]] Json show(
      const std::vector<acquisition::Reading>& readings, const session::PlanPoint* point,
      const acquisition::CollectorProgress& now) const;

  /// The same while nothing is collected: stage "watching", no pose, and nothing to settle for.
  [[nodiscard]] Json watched(const std::vector<acquisition::Reading>& readings) const;

 private:
  [[nodiscard]] Json pose(
      const std::vector<acquisition::Reading>& readings, const session::PlanPoint* point) const;

  const geometry::Rig rig_;
};

}  // namespace sixdial::service
