// Charts as the JSON that report/web/charts.js draws. Schema: one key per field of document.h.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "report/document.h"

namespace sixdial::report {

/// A chart with more marks than this (an arrow counts for two) is thinned: every series to an
/// equal share, evenly chosen, first and last kept.
inline constexpr std::size_t kMarksOnChart = 3000;

/// Values not finite are left out with their point. Texts are valid UTF-8.
[[nodiscard]] nlohmann::json chart_json(const Chart& chart);
/// True if this chart has more marks than are drawn.
[[nodiscard]] bool is_thinned(const Chart& chart);

}  // namespace sixdial::report
