// Figures that were found go back into a rig file's text: only their lines change, comments
// stay.

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sixdial::session {

struct AdoptedFigure {
  std::string key;              // "d_mm"
  std::vector<double> value;    // in the unit of its key: one number, or those of a list
  double sd = 0.0;              // standard deviation, for the note; 0: no note
  std::string dial{};           // of this [[dial]]
  std::string table = "robot";  // else of this table: "robot", "cuboid"
};

/// A key that the file lacks is added at the end of its table. Throws DataError where the text
/// cannot be changed so (the table written inline, say).
[[nodiscard]] std::string with_adopted(
    std::string_view rig_text, const std::string& file_name,
    const std::vector<AdoptedFigure>& figures, const std::string& from);

}  // namespace sixdial::session
