#include "report/sections/rig_section.h"

#include <algorithm>
#include <functional>
#include <vector>

#include "geometry/units.h"
#include "report/expanded.h"
#include "report/tables.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {

using diagnosis::RigSeen;

Section rig_seen_section(const std::vector<RigSeen>& rig) {
  Section section{.id = "rig_seen", .heading = "The rig as the data see it"};
  if (rig.empty()) return section;
  section.blocks.emplace_back(
      "Where dials and cuboid are, and what they measure, is fitted along with the robot: each "
      "as well as it was known before, and as far as the readings say more.");
  Table table{.id = "rig_seen", .caption = "What the readings say of the rig"};
  table.columns = {
      column("name", "quantity"),
      column("unit", "unit"),
      column("off", "off by", "", "from the rig file"),
      expanded_column("sd", "", "from the rig file"),
      expanded_column("known_sd", "", "known before"),
      column("source", "from"),
      column("ratio", "off", "times what was known, one standard deviation"),
      column("learned", "learned", "%")};
  std::vector<RigSeen> rows = rig;
  std::ranges::stable_sort(rows, std::greater{}, &RigSeen::ratio);
  for (const RigSeen& each : rows) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    constexpr int kDecimals = 4;
    constexpr double kPercent = 100.0;
    const double left = each.known_sd > 0.0 ? each.sd / each.known_sd : 1.0;
    table.rows.push_back(
        {capital(each.name), std::string(unit.name),
         number(unit.per_unit * each.off, kDecimals),
         expanded(unit.per_unit * each.sd, kDecimals),
         expanded(unit.per_unit * each.known_sd, kDecimals),
         each.stated ? "rig file" : "assumed", number(each.ratio(), 1),
         number(kPercent * std::clamp(1.0 - left * left, 0.0, 1.0), 0)});
  }
  constexpr std::size_t kOnPage = 12;
  table.rows_on_page = kOnPage;
  table.notes.emplace_back(
      "Learned: share of the variance known before that the readings took away. 0 %: they say "
      "nothing of it. Assumed: the rig file claims exactness, which the readings contradict.");
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace sixdial::report
