#include "report/words/area_words.h"

#include <fmt/format.h>

namespace sixdial::report {

std::string outside_words(const studies::OutsideMeasured& outside, std::size_t asked) {
  std::string where;
  if (outside.points > 0) {
    where = asked == 1 ? fmt::format(
                             "the target lies {:.1f} mm outside of the area that was measured",
                             outside.farthest_mm)
                       : fmt::format(
                             "{} of {} targets lie up to {:.1f} mm outside of the area that "
                             "was measured",
                             outside.points, asked, outside.farthest_mm);
  }
  if (outside.points_of_new_mode > 0) {
    if (!where.empty()) where += ", and ";
    where += asked == 1
                 ? std::string("no sample is in its working mode")
                 : fmt::format(
                       "{} are in a working mode without a sample", outside.points_of_new_mode);
  }
  if (where.empty()) return "";
  return where +
         ": the calibration is extrapolated there and its accuracy is not known; "
         "measure there, too";
}

}  // namespace sixdial::report
