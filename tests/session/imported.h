// A table of text, imported by the map that the guess made of it.
#pragma once

#include <string>

#include "session/bundle.h"
#include "session/import.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"

namespace sixdial::session {

inline constexpr const char* kArm =
    "[robot]\nmodel = \"serial\"\n[[joint]]\nalpha_deg = 90\n[[joint]]\na_mm = 100\n"
    "[[joint]]\na_mm = 80\n[instrument]\nkind = \"position\"\n";
inline constexpr const char* kGantry =
    "[robot]\nmodel = \"serial\"\n[[joint]]\nkind = \"prismatic\"\nalpha_deg = 90\n[[joint]]\n"
    "a_mm = 100\n[[joint]]\na_mm = 80\n[instrument]\nkind = \"position\"\n";

inline SampleLayout layout_of_text(const std::string& rig) {
  return session::layout_of(parse_rig(rig, "rig.toml"));
}

inline ImportMap map_of(const std::string& text, const std::string& rig) {
  return parse_import_map(text, "map.toml", [&](const std::string&) { return rig; });
}

struct Taken {
  FirstMap map;
  Imported imported;
  Session session;
};
/// The guess's own map, and what an import by it makes.
inline Taken taken(const std::string& table, const std::string& rig = kArm) {
  const SampleLayout layout = layout_of_text(rig);
  const NamedText file{"a.csv", table};
  Taken all{.map = guessed_map(file, "rig.toml", &layout), .imported = {}, .session = {}};
  all.imported = import_texts({file}, map_of(all.map.text, rig));
  all.session =
      parse_session(all.imported.session_csv, "session.csv", all.imported.rig_toml, "rig.toml");
  return all;
}

}  // namespace sixdial::session
