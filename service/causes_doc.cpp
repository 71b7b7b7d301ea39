#include "service/causes_doc.h"

#include <fmt/format.h>

#include "geometry/rig.h"
#include "simulation/effect.h"

namespace sixdial::service {
namespace {

std::string needs_of(unsigned needs) {
  std::string text;
  const auto add = [&](unsigned bit, const char* words) {
    if ((needs & bit) != 0) text += (text.empty() ? "" : ", ") + std::string(words);
  };
  add(simulation::kTime, "time of each sample");
  add(simulation::kTemperature, "temperature");
  add(simulation::kApproach, "side of approach");
  add(simulation::kDials, "raw readings of the dials");
  return text.empty() ? "nothing but positions" : text;
}

}  // namespace

std::string causes_markdown() {
  std::string page =
      "# The causes, one by one\n\n<!-- Printed by `sixdiald --print-causes` from "
      "simulation/effects/; a test compares. -->\n\nEach physical effect of the catalogue: how "
      "it "
      "shows in the residuals, what it does to parts, what to do. Plausible sizes are those "
      "that "
      "the search begins with on a rig of this kind.\n";
  const geometry::Rig rig = geometry::default_rig();
  for (const simulation::Effect* effect : simulation::all_effects()) {
    page +=
        fmt::format("\n## {} (`{}`)\n\n| | |\n|---|---|\n", effect->in_words, effect->cause);
    page += fmt::format("| signature | {} |\n", effect->signature);
    page += fmt::format("| effect on parts | {} |\n", effect->consequence);
    page += fmt::format("| action | {} |\n", effect->advice);
    std::string sizes;
    for (const simulation::EffectParameter& each : effect->parameters) {
      sizes += fmt::format(
          "{}{} {:g} {}", sizes.empty() ? "" : ", ", each.name, each.sigma, each.unit);
    }
    page += fmt::format("| plausible size | {} |\n", sizes);
    page += fmt::format("| needs | {} |\n", needs_of(effect->needs));
    std::string places;
    for (const simulation::Place& place : effect->places(rig)) {
      places += (places.empty() ? "" : ", ") + place.name;
    }
    page += fmt::format("| looked for at | {} |\n", places);
    if (!effect->why_not_learned.empty()) {
      page += fmt::format("| and the network? | {} |\n", effect->why_not_learned);
    }
  }
  return page;
}

}  // namespace sixdial::service
