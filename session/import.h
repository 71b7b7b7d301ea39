// Files that people have, by a map, as a session bundle: which column is what in which unit,
// which text means that there is nothing, which rows are one pose, which set each belongs to
// (doc/importing.md has the map's keys).
//
//   const ImportMap map = read_import_map("maps/ur10.toml");
//   const Imported bundle = import_files({"measured.csv"}, map);
//   bundle.session_csv;  // as session.csv
//   bundle.notes;        // what was found out, left out, and odd
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "session/import_table.h"

namespace sixdial::session {

struct SampleLayout;

struct MapColumn {
  std::string from{};  // a name, or "file" (the last parts of its path)
  /// The column's place from 1, instead of its name: `from = 1`.
  std::optional<int> number{};
  std::string to{};     // a column of session.csv
  double factor = 1.0;  // value = cell * factor + offset, in the unit of `to`
  double offset = 0.0;
  std::string unit{};  // of the file, as the map says it; part of `factor`
  bool has_scale =
      false;  // the map says unit, factor or offset: what the file says is not used
  std::vector<std::string> missing{};  // texts that mean that there is nothing
  std::optional<double> value{};       // the same in every row, instead of `from`
  bool is_text = false;                // `to` holds text (socket, set)
};

enum class SetRule {
  kAll,        // every row calibrates
  kAlternate,  // poses go to G1 and G2 in turn: rows whose joints agree are one pose
};

struct ImportMap {
  std::string file;  // that it was read from
  std::string text;
  std::string rig_toml;  // the rig file that it names; with a URDF, written anew without it
  TableFormat format{};
  bool side_by_side = false;  // several files are columns of the same rows
  int file_parts = 1;         // "file" is so many last parts of a file's path
  std::vector<MapColumn> columns{};
  SetRule sets = SetRule::kAlternate;
  double same_rad = 1e-3;  // rows whose joints agree to this (lengths: in mm) are one pose
  // Sockets that the rig file does not name are added; of two of one folder the distance may be
  // known.
  std::optional<double> pair_distance_mm{};
  double pair_sd_mm = 0.05;
};

struct Imported {
  std::string session_csv;
  std::string rig_toml;
  std::string record;  // imported.toml: names and hashes of the files, the map, the notes
  std::vector<std::string> notes{};
  std::size_t rows = 0;
  std::size_t left_out = 0;
};

/// Throws DataError with all that is wrong with the map, or with the rig file that it names.
[[nodiscard]] ImportMap read_import_map(const std::string& path);
/// The same of the map's text; `text_beside` gives that of a file beside it.
[[nodiscard]] ImportMap parse_import_map(
    const std::string& text, const std::string& file,
    const std::function<std::string(const std::string& name)>& text_beside);

/// Throws DataError: a file is no table, a column is not there, no row is left.
[[nodiscard]] Imported import_files(
    const std::vector<std::string>& files, const ImportMap& map);
struct NamedText {
  std::string name;  // of the file
  std::string text;
};
[[nodiscard]] Imported import_texts(const std::vector<NamedText>& files, const ImportMap& map);

struct FirstMap {
  std::string text{};  // map.toml
  /// What the file does not say and somebody has to look at: "no unit is in the file; ...".
  std::vector<std::string> open{};
};
/// A first map for a file: which column is most likely what, and by which sign it was taken for
/// that. `rig_file`: to name in it; may be empty. `layout` of that rig; null: not known.
[[nodiscard]] FirstMap guessed_map(
    const NamedText& file, const std::string& rig_file, const SampleLayout* layout = nullptr);

/// Factor from `unit` to the unit of `to` ("q1_rad", "deg": 0.01745...). Empty:
/// there is no such unit, or it is of another kind.
[[nodiscard]] std::optional<double> factor_to(const std::string& to, std::string_view unit);

}  // namespace sixdial::session
