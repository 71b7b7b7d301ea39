// The texts that every page carries in itself. Defined by files made at build time
// (cmake/EmbedFile.cmake, cmake/ChartLibraries.cmake).
#pragma once

#include <string_view>

namespace sixdial::report::assets {

[[nodiscard]] std::string_view stylesheet();    // report/web/report.css
[[nodiscard]] std::string_view chart_script();  // report/web/charts.js
/// d3, Observable Plot and their licences; all empty if the build had no npm.
[[nodiscard]] std::string_view d3_js();
[[nodiscard]] std::string_view plot_js();
[[nodiscard]] std::string_view licences();

}  // namespace sixdial::report::assets
