// The fixed parts of the sources that are written, for each kind of robot and each language.
// Defined by a file made at build time of report/export/templates/ (cmake/EmbedFile.cmake).
#pragma once

#include <string_view>

namespace sixdial::report::templates {

[[nodiscard]] std::string_view five_bar_c();
[[nodiscard]] std::string_view five_bar_py();
[[nodiscard]] std::string_view frame_c();
[[nodiscard]] std::string_view frame_py();
[[nodiscard]] std::string_view linear_delta_c();
[[nodiscard]] std::string_view linear_delta_py();
[[nodiscard]] std::string_view model_c();
[[nodiscard]] std::string_view model_py();
[[nodiscard]] std::string_view rotary_delta_c();
[[nodiscard]] std::string_view rotary_delta_py();
[[nodiscard]] std::string_view serial_c();
[[nodiscard]] std::string_view serial_py();
[[nodiscard]] std::string_view serial_weight_c();
[[nodiscard]] std::string_view serial_weight_py();
[[nodiscard]] std::string_view smooth_c();
[[nodiscard]] std::string_view smooth_py();
[[nodiscard]] std::string_view solve_c();
[[nodiscard]] std::string_view solve_py();
[[nodiscard]] std::string_view stewart_c();
[[nodiscard]] std::string_view stewart_py();
[[nodiscard]] std::string_view three_spheres_c();
[[nodiscard]] std::string_view three_spheres_py();

}  // namespace sixdial::report::templates
