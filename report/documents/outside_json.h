// What of a target or a plan lies outside of what was measured: "outside_measured" of the
// document "sixdial.compensation" and of the answers on the socket.
#pragma once

#include "report/documents/json.h"
#include "report/words/area_words.h"

namespace sixdial::report {

/// {farthest_mm, points, points_of_new_mode, words}; `asked`: so many targets. Words empty: all
/// of it was measured.
[[nodiscard]] inline Json outside_json(
    const studies::OutsideMeasured& outside, std::size_t asked) {
  return {
      {"farthest_mm", outside.farthest_mm},
      {"points", outside.points},
      {"points_of_new_mode", outside.points_of_new_mode},
      {"words", outside_words(outside, asked)}};
}

}  // namespace sixdial::report
