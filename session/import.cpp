#include "session/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "geometry/units.h"
#include "session/csv.h"
#include "session/data_error.h"
#include "session/import_guess.h"
#include "session/import_roles.h"
#include "session/import_time.h"
#include "session/live_channels.h"
#include "session/rig_file.h"
#include "session/rig_write.h"
#include "session/sample_layout.h"
#include "session/sha256.h"
#include "session/toml_write.h"
#include "session/traceability.h"

namespace sixdial::session {
namespace {

constexpr std::string_view kFile = "file";
constexpr int kDigits = 9;

/// Cells of one row, in the map's order; empty: there is nothing.
struct Row {
  std::vector<std::string> cells;
  std::vector<double> joints;  // those that the map gives [rad, mm], in the map's order
};

/// What cells of one column could not be read as.
struct Odd {
  int count = 0;
  int first_line = 0;
  std::string example;
};

/// Letters that can name a socket, and the last parts of a path without its ending.
std::string name_from_path(const std::string& file, int parts) {
  const std::filesystem::path path(file);
  std::vector<std::string> all;
  for (const auto& part : path.parent_path()) all.push_back(part.string());
  all.push_back(path.stem().string());
  const auto first = static_cast<std::ptrdiff_t>(all.size()) - parts;
  std::string name;
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(first, 0); i < std::ssize(all); ++i) {
    name += (name.empty() ? "" : "_") + all[static_cast<std::size_t>(i)];
  }
  for (char& letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) == 0 && letter != '-') letter = '_';
  }
  return name;
}

class Importer {
 public:
  explicit Importer(const ImportMap& map)
      : map_(map),
        rig_(as_instrument(parse_rig(map.rig_toml, map.file))),
        layout_(layout_of(rig_)) {
    for (std::size_t i = 0; i < layout_.joints.size(); ++i) {
      const Joint& joint = layout_.joints[i];
      const std::string number = fmt::format("q{}", i + 1);
      int found = 0;
      for (const MapColumn& column : map.columns) {
        for (const std::string& name : {joint.name, number}) {
          const bool degrees = column.to == name + "_deg";
          if (degrees || column.to == name + "_rad" || column.to == name + "_mm") {
            ++found;
            joint_unit_[column.to] = degrees ? geometry::kRadPerDeg : 1.0;
            break;
          }
        }
      }
      if (found == 0) missing_joints_.push_back(joint.column());
      if (found > 1) {
        throw DataError(
            map_.file, Mistake{
                           0, 0, joint.column(), "several [[column]] give this joint",
                           "the map names each joint once"});
      }
    }
    odd_.resize(map.columns.size());
    left_out_.no_value.resize(map.columns.size());
  }

  void take(const ImportTable& table) {
    if (!missing_joints_.empty()) {
      throw DataError(map_.file, joints_missing(missing_joints_, map_, layout_, table));
    }
    if (auto mistake = nothing_measured(map_, layout_, table)) {
      throw DataError(map_.file, std::move(*mistake));
    }
    std::vector<std::size_t> at;
    for (const MapColumn& column : map_.columns) {
      if (column.value || (!column.number && column.from == kFile)) {
        at.push_back(table.names.size());
        continue;
      }
      if (column.number) {
        const auto place = static_cast<std::size_t>(*column.number);
        if (place > table.names.size()) no_such_column(table, column);
        at.push_back(place - 1);
        continue;
      }
      const auto found = std::ranges::find(table.names, column.from);
      if (found == table.names.end()) no_such_column(table, column);
      at.push_back(static_cast<std::size_t>(found - table.names.begin()));
    }
    std::vector<std::string> notes = table.notes;
    scales_.assign(map_.columns.size(), {});
    for (std::size_t k = 0; k < map_.columns.size(); ++k) {
      if (at[k] == table.names.size()) continue;
      scales_[k] = stated_scale(map_.columns[k], table, at[k], notes);
    }
    for (const std::string& note : notes) note_once(table.file + ": " + note);
    const std::string of_file = name_from_path(table.file, map_.file_parts);
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      take_row(table, i, at, of_file);
    }
  }

  Imported finish(const std::string& file, const std::string& hashes) {
    for (std::size_t k = 0; k < odd_.size(); ++k) tell_odd(k);
    const std::size_t left_out = left_out_.without_joint + left_out_.without_measured;
    if (left_out > 0) {
      note_once(fmt::format(
          "{} {} left out: no value of every joint, or nothing measured", left_out,
          left_out == 1 ? "row is" : "rows are"));
    }
    for (const auto& [what, count] : cleared_) {
      note_once(fmt::format(
          "{} {}{} {} left out: not all of {} numbers were read", count, what,
          count == 1 ? "" : "s", count == 1 ? "is" : "are", count == 1 ? "its" : "their"));
    }
    if (rows_.empty()) throw DataError(file, no_row_left(map_, left_out_));
    Imported result;
    result.session_csv = csv();
    result.rig_toml =
        add_sockets() ? write_rig(rig_, traceability_of(map_.rig_toml)) : map_.rig_toml;
    result.rows = rows_.size();
    result.left_out = left_out;
    result.notes = notes_;
    result.record = "# Where this session comes from.\nnotes = [\n";
    for (const std::string& note : notes_) result.record += "  " + toml_string(note) + ",\n";
    result.record += "]\nmap = " + toml_string(map_.text) + "\n" + hashes;
    return result;
  }

 private:
  [[noreturn]] static void no_such_column(const ImportTable& table, const MapColumn& column) {
    throw DataError(
        table.file,
        Mistake{
            1, 1, column.from, "the map's column is not there",
            fmt::format("the file has {}: {}", table.names.size(), names_in_words(table))});
  }

  void note_once(const std::string& note) {
    if (std::ranges::find(notes_, note) == notes_.end()) notes_.push_back(note);
  }

  void is_odd(std::size_t column, const std::string& cell, int line) {
    Odd& odd = odd_[column];
    if (odd.count++ > 0) return;
    odd.first_line = line;
    odd.example = cell;
  }

  std::string value_of(std::size_t k, const std::string& cell, char decimal_mark, int line) {
    const MapColumn& column = map_.columns[k];
    if (cell.empty() || std::ranges::find(column.missing, cell) != column.missing.end()) {
      return "";
    }
    if (column.to == "time_utc") {
      const auto time = time_in(cell, decimal_mark);
      if (!time) is_odd(k, cell, line);
      if (time && time->zone_assumed) {
        note_once(fmt::format("column {}: times without a zone are taken as UTC", column.from));
      }
      return time ? time->utc : "";
    }
    if (column.is_text) return cell;
    const auto number = number_in(cell, decimal_mark);
    if (!number || !std::isfinite(*number)) {
      is_odd(k, cell, line);
      return "";
    }
    const UnitScale& scale = scales_[k];
    const double value = *number * column.factor * scale.factor + column.offset + scale.offset;
    if (std::isfinite(value)) return decimal(value, kDigits);
    is_odd(k, cell, line);
    return "";
  }

  void take_row(
      const ImportTable& table, std::size_t i, const std::vector<std::size_t>& at,
      const std::string& of_file) {
    Row row;
    const auto& cells = table.rows[i];
    bool joints = true;
    bool measured = false;
    for (std::size_t k = 0; k < map_.columns.size(); ++k) {
      const MapColumn& column = map_.columns[k];
      if (column.value) {
        row.cells.push_back(decimal(*column.value, 0));
      } else if (at[k] == table.names.size()) {
        row.cells.push_back(of_file);
      } else {
        row.cells.push_back(value_of(k, cells[at[k]], table.decimal_of(at[k]), table.lines[i]));
      }
      const std::string& value = row.cells.back();
      if (value.empty()) ++left_out_.no_value[k];
      if (const auto unit = joint_unit_.find(column.to); unit != joint_unit_.end()) {
        joints = joints && !value.empty();
        row.joints.push_back(value.empty() ? 0.0 : parse_number(value).value * unit->second);
      } else if (is_measured(column.to) && !value.empty()) {
        measured = true;
      }
    }
    ++left_out_.rows;
    if (!joints || !measured) {
      ++(joints ? left_out_.without_measured : left_out_.without_joint);
      return;
    }
    whole_position(row);
    rows_.push_back(std::move(row));
  }

  /// x, y and z are there together, or not at all; so are the numbers of a turn.
  void whole_position(Row& row) {
    struct Together {
      std::string what;
      std::vector<std::string> names;
    };
    static const std::array<Together, 5> kTogether{{
        {"position", {"x_mm", "y_mm", "z_mm"}},
        {"target", {"target_x_mm", "target_y_mm", "target_z_mm"}},
        {"measured turn", {"rx_deg", "ry_deg", "rz_deg"}},
        {"measured turn", {"rx_rad", "ry_rad", "rz_rad"}},
        {"measured turn", {"qw", "qx", "qy", "qz"}},
    }};
    for (const auto& [what, names] : kTogether) {
      std::vector<std::size_t> parts;
      std::size_t given = 0;
      for (std::size_t k = 0; k < map_.columns.size(); ++k) {
        if (std::ranges::find(names, map_.columns[k].to) == names.end()) continue;
        parts.push_back(k);
        given += row.cells[k].empty() ? 0U : 1U;
      }
      if (given == 0 || given == parts.size()) continue;
      ++cleared_[what];
      for (const std::size_t k : parts) row.cells[k].clear();
    }
  }

  /// Words for what could not be read; a column of times that are all damaged is left out.
  void tell_odd(std::size_t k) {
    const Odd& odd = odd_[k];
    if (odd.count == 0) return;
    const MapColumn& column = map_.columns[k];
    const bool time = column.to == "time_utc";
    std::string said = fmt::format(
        "column {}: {} of {} values {}, such as {} in line {}", column.from, odd.count,
        left_out_.rows,
        !time                           ? "are no number"
        : is_doubtful_date(odd.example) ? "are times whose day and month cannot be told apart"
                                        : "are no time (damaged by a spreadsheet?)",
        shown(odd.example), odd.first_line);
    left_out_.odd.push_back(said);
    note_once(said + "; left empty");
  }

  /// Number of the pose that each row stands in: rows whose joints agree.
  [[nodiscard]] std::vector<std::size_t> poses() const {
    std::vector<std::size_t> of_row;
    std::vector<std::size_t> first_row;
    std::map<double, std::vector<std::size_t>> near;  // poses by their first joint
    const double step = std::max(map_.same_rad, 1e-12);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto& q = rows_[i].joints;
      const double cell = std::floor(q[0] / step);
      std::optional<std::size_t> same;
      for (const double neighbour : {-1.0, 0.0, 1.0}) {
        const auto bucket = near.find(cell + neighbour);
        if (same || bucket == near.end()) continue;
        for (const std::size_t pose : bucket->second) {
          const auto& other = rows_[first_row[pose]].joints;
          const bool agrees = std::ranges::equal(
              q, other, [&](double a, double b) { return std::abs(a - b) <= map_.same_rad; });
          if (agrees) same = pose;
        }
      }
      if (!same) {
        same = first_row.size();
        first_row.push_back(i);
        near[cell].push_back(*same);
      }
      of_row.push_back(*same);
    }
    return of_row;
  }

  [[nodiscard]] std::string csv() {
    const bool own_sets = std::ranges::any_of(
        map_.columns, [](const MapColumn& column) { return column.to == "set"; });
    std::string out = own_sets ? "point,repeat" : "set,point,repeat";
    std::vector<std::size_t> used;
    for (std::size_t k = 0; k < map_.columns.size(); ++k) {
      // A column without any value is none.
      const bool any =
          std::ranges::any_of(rows_, [k](const Row& row) { return !row.cells[k].empty(); });
      if (!any) continue;
      used.push_back(k);
      out += ',' + csv_field(map_.columns[k].to);
    }
    const std::vector<std::size_t> pose = poses();
    std::map<std::size_t, int> repeats;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const bool g1 = map_.sets == SetRule::kAll || pose[i] % 2 == 0;
      out += own_sets ? "\n" : g1 ? "\nG1," : "\nG2,";
      out += fmt::format("{},{}", pose[i], repeats[pose[i]]++);
      for (const std::size_t k : used) out += ',' + csv_field(rows_[i].cells[k]);
    }
    const auto different = repeats.size();
    if (different < rows_.size()) {
      note_once(fmt::format(
          "{} rows at {} poses: rows whose joints agree are repeats of one pose", rows_.size(),
          different));
    }
    return out + "\n";
  }

  /// Sockets that the rows name and the rig file does not; whether there are any.
  bool add_sockets() {
    std::vector<std::string> added;
    for (std::size_t k = 0; k < map_.columns.size(); ++k) {
      if (map_.columns[k].to != "socket") continue;
      for (const Row& row : rows_) {
        const std::string& name = row.cells[k];
        auto& sockets = rig_.instrument.sockets;
        if (name.empty() || std::ranges::find(sockets, name, &geometry::ReferencePoint::name) !=
                                sockets.end()) {
          continue;
        }
        sockets.push_back({.name = name});
        added.push_back(name);
      }
    }
    if (added.empty()) return false;
    note_once("sockets were added to the rig file, which has lost its comments by that");
    if (!map_.pair_distance_mm) return true;
    // Two names that differ in their last number only are of one block.
    const auto block = [](const std::string& name) {
      return name.substr(0, name.find_last_not_of("0123456789") + 1);
    };
    for (std::size_t i = 0; i < added.size(); ++i) {
      for (std::size_t j = i + 1; j < added.size(); ++j) {
        if (block(added[i]) != block(added[j])) continue;
        rig_.instrument.socket_distances.push_back(
            {added[i], added[j], *map_.pair_distance_mm, map_.pair_sd_mm});
      }
    }
    return true;
  }

  const ImportMap& map_;
  geometry::Rig rig_;
  SampleLayout layout_;
  std::vector<std::string> missing_joints_;  // that no [[column]] gives
  std::vector<UnitScale> scales_;  // by column of the map: what the file says of units
  std::map<std::string, double> joint_unit_;  // by column; one of it in rad or mm
  std::vector<Row> rows_;
  std::vector<Odd> odd_;  // by column of the map
  RowsLeftOut left_out_;
  std::map<std::string, int> cleared_;  // what a row gave a part of only, and how often
  std::vector<std::string> notes_;
};

}  // namespace

Imported import_files(const std::vector<std::string>& files, const ImportMap& map) {
  std::vector<NamedText> texts;
  for (const std::string& file : files) texts.push_back({file, read_file(file)});
  return import_texts(texts, map);
}

Imported import_texts(const std::vector<NamedText>& files, const ImportMap& map) {
  Importer importer(map);
  std::string hashes;
  std::vector<ImportTable> tables;
  for (const auto& [name, text] : files) {
    hashes += fmt::format(
        "\n[[file]]\nname = {}\nsha256 = \"{}\"\n",
        toml_string(std::filesystem::path(name).filename().string()), sha256(text));
    ImportTable table = read_table(text, name, map.format);
    if (map.side_by_side) {
      tables.push_back(std::move(table));
    } else {
      importer.take(table);
    }
  }
  if (map.side_by_side && !tables.empty()) importer.take(beside(std::move(tables)));
  return importer.finish(files.empty() ? "the import" : files.front().name, hashes);
}

}  // namespace sixdial::session
