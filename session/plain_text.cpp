#include "session/plain_text.h"

#include <utility>

#include "session/data_error.h"

namespace sixdial::session {

void check_is_plain(std::string_view text, const std::string& file_name) {
  const auto refuse = [&](std::string what, std::string hint) {
    throw DataError(file_name, Mistake{1, 1, "", std::move(what), std::move(hint)});
  };
  using namespace std::string_view_literals;
  if (text.starts_with("\x1F\x8B"sv)) {
    refuse("the file is compressed (gzip)", "unpack it first: gunzip");
  }
  if (text.starts_with("PK\x03\x04"sv)) {
    refuse(
        "the file is a zip archive, such as a spreadsheet (.xlsx, .ods)",
        "export the table as CSV (UTF-8)");
  }
  const bool marked = text.starts_with("\xFF\xFE"sv) || text.starts_with("\xFE\xFF"sv);
  const auto zero = [&](std::size_t at) { return at < text.size() && text[at] == '\0'; };
  if (marked || (zero(0) && zero(2) && !zero(1)) || (zero(1) && zero(3) && !zero(2))) {
    refuse("the file is UTF-16", "save it as UTF-8 (CSV UTF-8)");
  }
}

}  // namespace sixdial::session
