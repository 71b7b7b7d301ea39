// Charts as the JSON that report/web/charts.js draws. Schema: one key per field of document.h.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "report/document.h"

namespace sixdial::report {

/// Marks of a series beyond this are thinned out evenly, first and last kept.
inline constexpr std::size_t kMarksOnPage = 1000;

/// Values not finite are left out with their point. Texts are valid UTF-8.
[[nodiscard]] nlohmann::json chart_json(const Chart& chart);
/// True if a series of this chart has more marks than are drawn.
[[nodiscard]] bool is_thinned(const Chart& chart);

}  // namespace sixdial::report
