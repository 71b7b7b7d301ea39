#include "session/stated_figures.h"

#include <toml++/toml.h>

#include "session/toml_text.h"

namespace sixdial::session {

bool states_figure(std::string_view rig_text, std::string_view dial, std::string_view key) {
  if (rig_text.empty()) return true;
  if (stray_character(rig_text)) return false;
  try {
    const toml::table top = toml::parse(rig_text);
    const auto* all = top.get_as<toml::table>("dials");
    if (all != nullptr && all->contains(key)) return true;
    const auto* dials = top.get_as<toml::array>("dial");
    if (dials == nullptr) return false;
    for (const toml::node& each : *dials) {
      const toml::table* table = each.as_table();
      if (table == nullptr || (*table)["id"].value<std::string_view>() != dial) continue;
      return table->contains(key);
    }
  } catch (const toml::parse_error&) {
    return false;
  }
  return false;
}

}  // namespace sixdial::session
