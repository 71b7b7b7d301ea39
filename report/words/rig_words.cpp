#include "report/words/rig_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/coverage.h"
#include "report/words/diagnosis_words.h"
#include "simulation/rig_quantities.h"

namespace sixdial::report {

std::string rig_in_words(const std::vector<diagnosis::RigSeen>& rig) {
  std::vector<diagnosis::RigSeen> stated;
  for (const diagnosis::RigSeen& each : rig) {
    if (each.stated) stated.push_back(each);
  }
  const diagnosis::RigSeen* worst = diagnosis::worst_of(stated);
  if (worst == nullptr) return "";
  constexpr double kWithin = 3.0;  // one of some thirty may be off by that
  const std::string size = fmt::format(
      "{} {} (k = 2), {:.1f} times its stated standard deviation", worst->name,
      quantity_in_words(worst->off, worst->sd, worst->unit), worst->ratio());
  return worst->ratio() <= kWithin
             ? fmt::format("The rig stands within what its file states; off by most: {}.", size)
             : fmt::format(
                   "The rig does not stand within what its file states: {}. Measure that "
                   "again.",
                   size);
}

std::string unsaid_of_rig(const geometry::Rig& rig) {
  const bool silent =
      !rig.dials.empty() && std::ranges::none_of(rig.dials, [](const geometry::Dial& dial) {
        return dial.deviations.position_mm.has_value();
      });
  if (!silent) return "";
  return "The rig file does not say how well the places of the dials are known; real ones are "
         "known to 0.03 to 0.1 mm. Positions and their uncertainties here take the places as "
         "exact.";
}

std::string unfitted_rig(
    const std::optional<std::vector<diagnosis::RigSeen>>& seen, const geometry::Rig& rig) {
  const bool fitted = seen && !seen->empty();
  const bool by_dials = rig.instrument.kind == "dials_on_cuboid";
  if (fitted || !by_dials || simulation::stated_quantities(rig).empty()) return "";
  return "The rig file states how well its dials stand, but they could not be fitted along "
         "with "
         "the robot (too few readings, or the fit did not settle): their places are taken as "
         "the file has them.";
}

std::vector<std::string> lines_on_rig(
    const std::optional<std::vector<diagnosis::RigSeen>>& seen, const geometry::Rig& rig,
    const studies::SharedUncertainty& of_rig) {
  std::vector<std::string> lines;
  std::string line = seen ? rig_in_words(*seen) : "";
  if (line.empty()) line = unsaid_of_rig(rig);
  if (line.empty()) line = unfitted_rig(seen, rig);
  if (!line.empty()) lines.push_back(std::move(line));
  if (of_rig.mm > 0.0) {
    lines.push_back(fmt::format(
        "What is not known of the rig's geometry{} gives a measured position U = {:.3f} mm (k "
        "= "
        "2, root mean square over G1). Most of it is common to all positions, so the errors "
        "above do not show it; U of a tolerance holds it.",
        of_rig.holds_curves ? " and of the dials' error curves" : "",
        geometry::kCoverage * of_rig.mm));
  }
  return lines;
}

}  // namespace sixdial::report
