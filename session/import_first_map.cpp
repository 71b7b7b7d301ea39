// A first map.toml for somebody's file, with the sign by which each column was recognised.
#include <fmt/format.h>

#include <algorithm>

#include "session/csv.h"
#include "session/import.h"
#include "session/import_guess.h"
#include "session/import_seen.h"
#include "session/toml_write.h"

namespace sixdial::session {
namespace {

/// A comment of TOML holds no control characters.
std::string in_comment(std::string text) {
  for (char& letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte < 0x20U || byte == 0x7F) letter = '?';
  }
  return text;
}

/// "#   Nr (90 numbers from 1 to 90): why it is not used"
std::string unused_line(const ImportTable& table, std::size_t column, const Guess& guess) {
  const ColumnValues values = values_of(table, column);
  const auto why = guess.left_out.find(column);
  return fmt::format(
      "#   {} ({} numbers{}{}){}\n", in_comment(table.names[column]), values.numbers,
      values.numbers > 0 ? fmt::format(" from {:.5g} to {:.5g}", values.low, values.high) : "",
      values.others > 0 ? fmt::format(", {} other texts", values.others) : "",
      why == guess.left_out.end() ? "" : ": " + in_comment(why->second));
}

}  // namespace

FirstMap guessed_map(
    const NamedText& file, const std::string& rig_file, const SampleLayout* layout) {
  const ImportTable table = read_table(file.text, file.name, {});
  const Guess guess = guess_columns(table, layout);
  FirstMap map{.open = guess.open};
  map.text = "# Made by `sixdial import --guess` from " + in_comment(file.name) +
             ": look at every line.\n";
  for (const std::string& note : table.notes) map.text += "# " + in_comment(note) + "\n";
  if (layout == nullptr) {
    map.text += "# the rig was not looked at: its joints and what it measures are not known\n";
  }
  for (const std::string& open : guess.open) map.text += "# LOOK: " + in_comment(open) + "\n";
  map.text += fmt::format("rig = {}\n", toml_string(rig_file.empty() ? "rig.toml" : rig_file));
  for (const GuessedColumn& column : guess.columns) {
    map.text += "\n# " + in_comment(column.why) + "\n" + map_lines(table, column);
  }
  std::string unused;
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    const bool used =
        std::ranges::find(guess.columns, k, &GuessedColumn::column) != guess.columns.end();
    if (!used) unused += unused_line(table, k, guess);
  }
  if (!unused.empty()) map.text += "\n# Columns that nothing was guessed for:\n" + unused;
  return map;
}

}  // namespace sixdial::session
