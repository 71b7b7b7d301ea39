// The rig as the data see it: the table of what each place and size of the rig became.
#pragma once

#include <vector>

#include "diagnosis/rig_seen.h"
#include "report/report_data.h"

namespace sixdial::report {

/// No blocks where the table is empty.
[[nodiscard]] Section rig_seen_section(const std::vector<diagnosis::RigSeen>& rig);

}  // namespace sixdial::report
