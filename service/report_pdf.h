// A report page printed to A4 by Chromium, where one is installed.
#pragma once

#include <filesystem>
#include <optional>

namespace sixdial::service {

/// The first of chromium, chromium-browser, google-chrome on PATH.
[[nodiscard]] std::optional<std::filesystem::path> find_chromium();

/// Throws Error file: no Chromium, or it made no PDF; with what it said and what to do.
void print_pdf(const std::filesystem::path& html, const std::filesystem::path& pdf);

}  // namespace sixdial::service
