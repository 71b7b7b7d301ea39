// map.toml: what the columns of somebody's file are.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string_view>
#include <utility>

#include "session/csv.h"
#include "session/import.h"
#include "session/import_units.h"
#include "session/rig_file.h"
#include "session/rig_write.h"
#include "session/toml_checks.h"
#include "session/toml_text.h"
#include "session/traceability.h"

namespace sixdial::session {
namespace {

bool holds_text(const std::string& to) {
  return to == "set" || to == "socket" || to == "time_utc";
}

class MapReader : TomlChecks {
 public:
  using Beside = std::function<std::string(const std::string&)>;
  MapReader(std::string file, Beside text_beside)
      : TomlChecks(std::move(file), "map"), text_beside_(std::move(text_beside)) {}

  ImportMap read(const std::string& text) {
    ImportMap map;
    map.file = file();
    map.text = text;
    const toml::table top = toml::parse(text);
    known_keys(top, "the top level", {"rig", "file", "column", "sets", "sockets"});
    if (top.get("rig") == nullptr) {
      missing(top, "the map", "rig");
    } else {
      const std::string rig = this->text(top, "", "rig", "");
      const auto folder = std::filesystem::path(file()).parent_path();
      map.rig_toml = text_beside_(rig);
      const geometry::Rig read = parse_rig(map.rig_toml, (folder / rig).string());
      if (read.robot.model->from_other_file) {  // a bundle has no URDF beside it
        map.rig_toml = write_rig(read, traceability_of(map.rig_toml));
      }
    }
    if (top.get("file") != nullptr) read_format(top, map);
    if (top.get("sets") != nullptr) read_sets(top, map);
    if (top.get("sockets") != nullptr) read_sockets(top, map);
    read_columns(top, map);
    stop_if_faulty();
    return map;
  }

 private:
  std::string word(
      const toml::table& from, const std::string& where, const char* key,
      const std::vector<std::string>& words) {
    const std::string given = text(from, where, key, words[0]);
    if (std::ranges::find(words, given) == words.end()) {
      std::string list;
      for (const std::string& each : words) {
        list += fmt::format("{}\"{}\"", list.empty() ? "" : " or ", each);
      }
      fault(
          from.get(key)->source(), key, shown(given) + " is none of its values",
          "write " + list);
    }
    return given;
  }

  std::optional<bool> flag(const toml::table& from, const char* key) {
    const toml::node* node = from.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->value_exact<bool>();
    if (!value) fault(node->source(), key, "is neither true nor false", "write true or false");
    return value;
  }

  std::optional<int> whole(const toml::table& from, const char* key) {
    const toml::node* node = from.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < 0 || *value > 1'000'000) {
      fault(node->source(), key, "is not a whole number from 0", "write one, such as 3");
      return std::nullopt;
    }
    return static_cast<int>(*value);
  }

  void read_format(const toml::table& top, ImportMap& map) {
    const toml::table* from = table(top, "file");
    if (from == nullptr) return;
    const std::string where = "[file]";
    known_keys(
        *from, where,
        {"format", "separator", "decimal", "header", "skip_lines", "units_row", "together",
         "file_parts"});
    if (from->get("format") != nullptr) {
      map.format.kind = word(*from, where, "format", {"text", "yaml"}) == "yaml"
                            ? TableFormat::Kind::kYaml
                            : TableFormat::Kind::kText;
    }
    if (from->get("separator") != nullptr) {
      const std::string given = text(*from, where, "separator", ",");
      if (given.size() == 1) {
        map.format.separator = given[0];
      } else if (given == "tab") {
        map.format.separator = '\t';
      } else {
        fault(
            from->get("separator")->source(), "separator", "is not one character",
            "write one, such as \";\", or \"tab\"");
      }
    }
    if (from->get("decimal") != nullptr) {
      map.format.decimal =
          word(*from, where, "decimal", {"point", "comma"}) == "comma" ? ',' : '.';
    }
    map.format.header = flag(*from, "header");
    map.format.units_row = flag(*from, "units_row");
    map.format.skip_lines = whole(*from, "skip_lines").value_or(0);
    map.file_parts = std::max(1, whole(*from, "file_parts").value_or(1));
    map.side_by_side = word(*from, where, "together", {"rows", "columns"}) == "columns";
  }

  void read_sets(const toml::table& top, ImportMap& map) {
    const toml::table* from = table(top, "sets");
    if (from == nullptr) return;
    known_keys(*from, "[sets]", {"rule", "same_rad"});
    map.sets = word(*from, "[sets]", "rule", {"alternate", "all"}) == "all"
                   ? SetRule::kAll
                   : SetRule::kAlternate;
    if (from->get("same_rad") != nullptr) {
      length(*from, "[sets]", "same_rad", true, map.same_rad);
    }
  }

  void read_sockets(const toml::table& top, ImportMap& map) {
    const toml::table* from = table(top, "sockets");
    if (from == nullptr) return;
    known_keys(*from, "[sockets]", {"pair_distance_mm", "pair_sd_mm"});
    length(*from, "[sockets]", "pair_distance_mm", false, map.pair_distance_mm.emplace());
    if (from->get("pair_sd_mm") != nullptr) {
      length(*from, "[sockets]", "pair_sd_mm", false, map.pair_sd_mm);
    }
  }

  void read_columns(const toml::table& top, ImportMap& map) {
    const toml::node* list = top.get("column");
    const toml::array* array = list == nullptr ? nullptr : list->as_array();
    if (array == nullptr || !array->is_array_of_tables()) {
      fault(
          list == nullptr ? top.source() : list->source(), "column", "is no list of columns",
          "write [[column]] with from and to for each column that is used");
      return;
    }
    for (const toml::node& row : *array) read_column(*row.as_table(), map);
  }

  void read_column(const toml::table& from, ImportMap& map) {
    const std::string where = "[[column]]";
    known_keys(from, where, {"from", "to", "unit", "factor", "offset", "missing", "value"});
    MapColumn column;
    if (from.get("value") != nullptr) column.value = number(from, where, "value");
    if (from.get("to") == nullptr) missing(from, where, "to");
    if (from.get("from") == nullptr && from.get("value") == nullptr) {
      missing(from, where, "from");
    }
    if (const toml::node* node = from.get("from")) {
      if (node->is_integer()) {
        column.number = whole(from, "from");
        column.from = fmt::format("column {}", column.number.value_or(0));
        if (column.number == 0) {
          fault(node->source(), "from", "is no column", "the first column has the number 1");
        }
      } else {
        column.from = text(from, where, "from", "");
      }
    }
    column.to = text(from, where, "to", "");
    check_target(from, column.to, map);
    column.is_text = holds_text(column.to);
    column.has_scale = from.get("unit") != nullptr || from.get("factor") != nullptr ||
                       from.get("offset") != nullptr;
    if (from.get("factor") != nullptr) {
      column.factor = number(from, where, "factor").value_or(1.0);
    }
    if (from.get("offset") != nullptr) {
      column.offset = number(from, where, "offset").value_or(0.0);
    }
    read_unit(from, column);
    if (const toml::node* node = from.get("missing")) {
      const toml::array* texts = node->as_array();
      if (texts == nullptr || !texts->is_homogeneous(toml::node_type::string)) {
        fault(
            node->source(), "missing", "is no list of texts",
            "write those that mean \"no value\", such as [\"0\", \"nan\"]");
      } else {
        for (const toml::node& each : *texts) {
          column.missing.push_back(each.value_or(std::string()));
        }
      }
    }
    map.columns.push_back(std::move(column));
  }

  /// A column of session.csv is given once, and not one that the import makes.
  void check_target(const toml::table& from, const std::string& to, const ImportMap& map) {
    const toml::node* node = from.get("to");
    if (node == nullptr) return;
    if (to == "point" || to == "repeat") {
      fault(
          node->source(), "to", shown(to) + " cannot be given: the import numbers the poses",
          "leave this [[column]] out; [sets] same_rad says which rows are one pose");
    } else if (std::ranges::find(map.columns, to, &MapColumn::to) != map.columns.end()) {
      fault(
          node->source(), "to", fmt::format("two [[column]] give {}", shown(to)),
          "leave one of them out");
    }
  }

  void read_unit(const toml::table& from, MapColumn& column) {
    const toml::node* node = from.get("unit");
    if (node == nullptr) return;
    column.unit = text(from, "[[column]]", "unit", "");
    const auto factor = factor_to(column.to, column.unit);
    if (!factor) {
      fault(
          node->source(), "unit",
          shown(column.unit) + " does not turn into the unit of " + shown(column.to),
          fmt::format("use {}", kMapUnits));
      return;
    }
    column.factor *= *factor;
  }

  Beside text_beside_;
};

}  // namespace

std::optional<double> factor_to(const std::string& to, std::string_view unit_text) {
  const ImportUnit* unit = find_import_unit(unit_text);
  const std::size_t last = to.rfind('_');
  if (unit == nullptr || last == std::string::npos) return std::nullopt;
  const ImportUnit* wanted = find_import_unit(to.substr(last + 1));
  const bool measures = unit->kind == UnitKind::kLength || unit->kind == UnitKind::kAngle;
  if (wanted == nullptr || !measures || unit->kind != wanted->kind) return std::nullopt;
  return unit->in_stored / wanted->in_stored;
}

ImportMap read_import_map(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  return parse_import_map(read_file(path), path, [folder](const std::string& name) {
    return read_file((folder / name).string());
  });
}

ImportMap parse_import_map(
    const std::string& text, const std::string& file,
    const std::function<std::string(const std::string& name)>& text_beside) {
  if (auto mistake = stray_character(text)) throw DataError(file, std::move(*mistake));
  try {
    return MapReader(file, text_beside).read(text);
  } catch (const toml::parse_error& error) {
    const auto& where = error.source().begin;
    throw DataError(
        file, Mistake{
                  static_cast<int>(where.line), static_cast<int>(where.column), "",
                  std::string(error.description()), "mend the TOML syntax there"});
  }
}

}  // namespace sixdial::session
