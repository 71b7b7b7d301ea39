// Charts as the JSON that report/web/charts.js draws. Schema: one key per field of document.h.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "report/document.h"

namespace sixdial::report {

/// A chart with more marks than this (an arrow counts for two) is thinned: every series to an
/// equal share, evenly chosen, first and last kept.
inline constexpr std::size_t kMarksOnChart = 3000;

/// All charts of a page together have no more than this: a page of many causes stays small too.
inline constexpr std::size_t kMarksOnPage = 10000;
/// The most marks of a chart, at most kMarksOnChart, with which these stay within kMarksOnPage.
[[nodiscard]] std::size_t marks_allowed(const std::vector<const Chart*>& charts);

/// Values not finite are left out with their point. Texts are valid UTF-8.
[[nodiscard]] nlohmann::json chart_json(const Chart& chart, std::size_t most = kMarksOnChart);
/// True if this chart has more marks than are drawn.
[[nodiscard]] bool is_thinned(const Chart& chart, std::size_t most = kMarksOnChart);

}  // namespace sixdial::report
