// A realistic session to make reports of: Table 2's robot on the default rig, 100 + 50 points,
// a smooth error of 0.03 mm that no parameter explains, noise of 0.003 mm. Seeded.
#pragma once

#include "report/report_data.h"

namespace sixdial::report {

struct SampleOptions {
  int g1_points = 100;
  int g2_points = 50;
  bool smooth_error = true;
  std::string session_name = "five-bar 2026-03-02";
};
[[nodiscard]] ReportData sample_session(const SampleOptions& options = {});

}  // namespace sixdial::report
