// The report of a small arm, calibrated: 26 poses of G1 and 14 of G2.
#pragma once

#include "report/report_run.h"
#include "studies/calibrate.h"
#include "tests/support/arm_session.h"

namespace sixdial::report {

inline ReportData arm_report() {
  const session::Session session = session::arm_session(40, 26);
  return report_data(studies::calibrate(session, {.method = "lm"}), session, "A. Person");
}

}  // namespace sixdial::report
