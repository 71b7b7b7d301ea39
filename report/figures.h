// The figures of a calibration: what each shows, what good looks like, what this session has.
#pragma once

#include <optional>

#include "report/report_data.h"

namespace sixdial::report {

/// Colours and symbols (Series::style): 0 before, 1 parameters alone, 2 the result, 3.. the
/// rest; 8 and 9 are the sets G1 and G2.
inline constexpr int kStyleBefore = 0;
inline constexpr int kStyleKinematic = 1;
inline constexpr int kStyleResult = 2;
inline constexpr int kStyleRival = 3;
inline constexpr int kStyleG1 = 8;
inline constexpr int kStyleG2 = 9;

/// Each is empty if the session has nothing to draw in it.
[[nodiscard]] std::optional<Figure> residual_map(const ReportData& data);
[[nodiscard]] std::optional<Figure> error_by_point(const ReportData& data);    // Fig. 10
[[nodiscard]] std::optional<Figure> convergence(const ReportData& data);       // Fig. 8
[[nodiscard]] std::optional<Figure> parameter_traces(const ReportData& data);  // Fig. 9
/// What the parameters leave, by joint angle, time, temperature and side of arrival.
[[nodiscard]] std::optional<Figure> residual_by(const ReportData& data);
/// What the parameters leave of each dial's readings; no rows if not known.
[[nodiscard]] Table dial_table(const ReportData& data);

/// 1, 2 or 5 times a power of ten, the largest not above `value` (> 0).
[[nodiscard]] double round_down(double value);

}  // namespace sixdial::report
