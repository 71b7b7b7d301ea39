// Any bytes as what somebody wants to import. Up to the first form feed a map; behind it a
// table, as YAML if a 'y' comes first: an error, or a bundle that can be read, and a first map
// that is TOML.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "session/bundle.h"
#include "session/import.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"

namespace {

using namespace sixdial::session;

/// Of a robot whose model is made in no time: three joints that turn.
const std::string& rig_text() {
  static const std::string text = [] {
    sixdial::geometry::Rig rig;
    rig.robot.model = sixdial::geometry::find_robot_kind("rotary_delta")->example();
    rig.robot.nominal = rig.robot.model->nominal;
    rig.instrument.kind = "position";
    rig.instrument.dimensions = 3;
    return write_rig(rig);
  }();
  return text;
}
constexpr const char* kMap =
    "rig = \"rig.toml\"\n"
    "[[column]]\nfrom = 1\nto = \"q1_rad\"\nunit = \"deg\"\n"
    "[[column]]\nfrom = 2\nto = \"q2_deg\"\n"
    "[[column]]\nvalue = 0.5\nto = \"q3_rad\"\n"
    "[[column]]\nfrom = 3\nto = \"x_mm\"\nunit = \"m\"\nmissing = [\"0\"]\n"
    "[[column]]\nfrom = 4\nto = \"y_mm\"\n"
    "[[column]]\nfrom = 5\nto = \"z_mm\"\n"
    "[[column]]\nfrom = 6\nto = \"time_utc\"\n";

void expect(bool law) {
  if (!law) std::abort();
}

ImportMap map_of(const std::string& text) {
  return parse_import_map(text, "map.toml", [](const std::string&) { return rig_text(); });
}

void check_table(const NamedText& file) {
  try {
    const ImportTable table = read_table(file.text, file.name, {});
    expect(table.lines.size() == table.rows.size());
    for (const auto& row : table.rows) expect(row.size() == table.names.size());
  } catch (const DataError& error) {
    expect(!error.mistakes.empty());
    return;
  }
  static const SampleLayout layout = layout_of(parse_rig(rig_text(), "rig.toml"));
  for (const SampleLayout* rig : {static_cast<const SampleLayout*>(nullptr), &layout}) {
    const std::string guessed = guessed_map(file, "rig.toml", rig).text;
    // Without any column that it knows there is no map yet; a name may hold "[[column]]", too.
    if (guessed.find("\n[[column]]\n") == std::string::npos) continue;
    const ImportMap map = map_of(guessed);
    if (rig == nullptr) continue;
    try {
      expect(import_texts({file}, map).rows > 0);
    } catch (const DataError& error) {
      expect(!error.mistakes.empty());
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::size_t cut = bytes.find('\f');
  const std::string map_text(bytes.substr(0, cut));
  const std::string_view rest = cut == bytes.npos ? "" : bytes.substr(cut + 1);
  const bool yaml = rest.starts_with('y');
  const NamedText file{yaml ? "a/b.yaml" : "a/b.csv", std::string(rest.substr(yaml ? 1 : 0))};
  if (!rest.empty()) check_table(file);
  try {
    const ImportMap map = map_of(map_text.empty() ? kMap : map_text);
    if (rest.empty()) return 0;
    const Imported made = import_texts({file}, map);
    expect(made.rows > 0);
    // The map may name columns that this rig does not have: that is told then.
    static_cast<void>(
        parse_session(made.session_csv, "session.csv", made.rig_toml, "rig.toml"));
  } catch (const DataError& error) {
    expect(!error.mistakes.empty());
  }
  return 0;
}
