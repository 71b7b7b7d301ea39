// The live page's files, carried by the program (cmake/EmbedFile.cmake).
#pragma once

#include <string_view>

namespace sixdial::service::live_assets {

[[nodiscard]] std::string_view page();        // service/web/live.html
[[nodiscard]] std::string_view stylesheet();  // service/web/live.css
[[nodiscard]] std::string_view script();      // service/web/live.js
[[nodiscard]] std::string_view link();        // service/web/link.js
[[nodiscard]] std::string_view dials();       // service/web/dials.js
[[nodiscard]] std::string_view drawing();     // service/web/drawing.js

}  // namespace sixdial::service::live_assets
