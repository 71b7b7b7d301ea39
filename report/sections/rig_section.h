// The rig as the data see it: the table of what each place and size of the rig became.
#pragma once

#include "report/report_data.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// Empty blocks where the rig file claims exactness, and nothing contradicts it.
[[nodiscard]] Section rig_section(const studies::DiagnosisResult& result);

}  // namespace sixdial::report
