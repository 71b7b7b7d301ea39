// What a report tells of the recommended model: the figures of its headline, its first advice,
// the section with all candidates and the parameters that belong to it.
#pragma once

#include "report/report_data.h"
#include "studies/recommendation.h"

namespace sixdial::report {

/// Fills headline, measured_again and first_to_do, and puts the section first. `diagnosis`,
/// `validation`: those that `recommended` was made with, or null.
void add_recommendation(
    ReportData& data, const studies::Recommendation& recommended,
    const studies::CalibrationResult& calibration, const geometry::RobotModel& robot,
    const studies::DiagnosisResult* diagnosis, const studies::ValidationResult* validation);

}  // namespace sixdial::report
