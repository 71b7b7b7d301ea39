// What a file that should be text turns out to be by its first bytes.
#pragma once

#include <string>
#include <string_view>

namespace sixdial::session {

/// Throws DataError for what no text file begins with: compressed, a spreadsheet, UTF-16.
void check_is_plain(std::string_view text, const std::string& file_name);

}  // namespace sixdial::session
