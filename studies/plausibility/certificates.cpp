// Certificates of dials, cuboid and thermometer that had run out when the session was measured.
#include <algorithm>

#include "session/traceability.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {

void look_at_certificates(Look& look) {
  std::string measured;
  for (const session::Sample& sample : look.measured.samples) {
    if (!sample.time_utc) continue;
    const std::string day = session::to_iso8601(*sample.time_utc).substr(0, 10);
    measured = std::max(measured, day);
  }
  if (measured.empty()) return;
  std::string which;
  std::string earliest;
  for (const session::TracedPart& part :
       session::traceability_of(look.measured.rig_text).parts) {
    if (part.due.empty() || part.due >= measured) continue;  // ISO 8601 sorts as text
    which += (which.empty() ? "" : ", ") + part.what;
    if (earliest.empty() || part.due < earliest) earliest = part.due;
  }
  if (which.empty()) return;
  look.tell(
      "certificate_expired", Severity::kNote, Look::rig_key("due"),
      {{"which", which}, {"due", earliest}, {"measured", measured}});
}

}  // namespace sixdial::studies::plausibility
