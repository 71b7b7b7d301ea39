// The tables of a report: the same ones go to the page and to the CSV files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/report_data.h"

namespace sixdial::report {

/// A name as print spells it: one letter or a Greek one with its digits below, "δθ" for a
/// change of it. Other names unchanged.
[[nodiscard]] std::string symbol(std::string_view name);
/// "ekf_dqpso_anfis" for "ekf_dqpso+anfis": lower-case letters, digits and '_'.
[[nodiscard]] std::string key_of(std::string_view name);
/// |residual| of a point by a method [mm].
[[nodiscard]] std::optional<double> position_error(const PointRow& point, std::size_t method);

/// Paper's Table 2 with uncertainties. `plain`: names and columns for programs.
[[nodiscard]] Table parameter_table(const ReportData& data, bool plain);
/// The parameters by each fit of ReportData::facts, side by side.
[[nodiscard]] Table fits_table(const ReportData& data);
/// Paper's Table 6.
[[nodiscard]] Table accuracy_table(const ReportData& data, bool plain);
/// 95 % intervals of Table 6's means and computing times; no rows if none are known.
[[nodiscard]] Table confidence_table(const ReportData& data);
/// Everything about every point: angles, target, position, residual and error by method.
[[nodiscard]] Table points_table(const ReportData& data);
/// Set, point, position, residual of the methods on the map.
[[nodiscard]] Table residual_table(const ReportData& data);
/// Set, point, position error by method (paper's Fig. 10).
[[nodiscard]] Table error_table(const ReportData& data);
/// The points with the largest remaining error, worst first.
[[nodiscard]] Table worst_points_table(const ReportData& data, std::size_t how_many);
/// The measured record: angles, position, dials, temperature.
[[nodiscard]] Table measurement_table(const ReportData& data);
/// Best objective by iteration (paper's Fig. 8); a column for each swarm.
/// `only_changes`: without the rows that read the same as the one above.
[[nodiscard]] Table convergence_table(const ReportData& data, bool only_changes);
/// Parameter errors by step (paper's Fig. 9), in shown units.
[[nodiscard]] Table trace_table(const ReportData& data, bool only_changes);

}  // namespace sixdial::report
