// Text for pages and tables: numbers as people read them, and escapes for what people typed.
#pragma once

#include <string>
#include <string_view>

#include "report/document.h"

namespace sixdial::report {

/// The same text with every byte that is not valid UTF-8, and every control character but tab
/// and newline, replaced by U+FFFD: safe for HTML and JSON.
[[nodiscard]] std::string valid_utf8(std::string_view text);
/// For element content and quoted attributes. Includes valid_utf8.
[[nodiscard]] std::string escape_html(std::string_view text);
/// JSON text that may stand in a <script> element: no '<', '>' or '&' is left.
[[nodiscard]] std::string escape_script(std::string_view json);
/// A field of RFC 4180: quoted if it holds a comma, a quote or a line end.
[[nodiscard]] std::string csv_field(std::string_view text);

/// "0.0180", "-0.556"; never "-0.000"; a dash if not finite.
[[nodiscard]] std::string fixed(double value, int decimals);
/// Shortest text that reads back as the same double; empty if not finite.
[[nodiscard]] std::string exact(double value);
/// As on the page: "0.0180", the text itself, or a dash for nothing.
[[nodiscard]] std::string shown(const Cell& cell);
/// Decimals that show two significant digits of a standard deviation (GUM 7.2.6), 1 to 7.
[[nodiscard]] int decimals_for(double standard_deviation);
/// A length with three significant digits in the unit that suits it: "2.82 mm", "3.1 µm".
[[nodiscard]] std::string length(double value_mm);
/// "1 point", "3 points".
[[nodiscard]] std::string counted(long long n, std::string_view one, std::string_view many);
/// "2026-03-02 08:30 UTC" from "2026-03-02T08:30:06.976Z"; the text itself if it is no such
/// time.
[[nodiscard]] std::string readable_time(std::string_view iso8601);

}  // namespace sixdial::report
