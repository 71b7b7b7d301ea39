#include "session/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

#include "geometry/units.h"
#include "session/measured_turn.h"
#include "session/nearest.h"

namespace sixdial::session {
namespace {

/// Every column that a file of this layout may have, in the spec's order.
std::vector<HeaderColumn> known_columns(const SampleLayout& layout) {
  std::vector<HeaderColumn> columns{
      {SampleColumn::kSet, 0, "set"},
      {SampleColumn::kPoint, 0, "point"},
      {SampleColumn::kRepeat, 0, "repeat"},
      {SampleColumn::kTime, 0, "time_utc"}};
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    columns.push_back({SampleColumn::kJoint, i, layout.joints[i].column()});
  }
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    columns.push_back({SampleColumn::kCommand, i, layout.joints[i].command_column()});
  }
  for (std::size_t i = 0; i < layout.axes.size(); ++i) {
    columns.push_back({SampleColumn::kTarget, i, fmt::format("target_{}_mm", layout.axes[i])});
  }
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    columns.push_back({SampleColumn::kApproach, i, fmt::format("approach{}", i + 1)});
  }
  columns.push_back({SampleColumn::kTemperature, 0, "temperature_c"});
  for (std::size_t i = 0; i < layout.channels.size(); ++i) {
    columns.push_back({SampleColumn::kChannel, i, layout.channels[i].column()});
  }
  for (std::size_t i = 0; i < layout.others.size(); ++i) {
    if (layout.others[i].name.starts_with(kSocketChannel)) continue;
    columns.push_back({SampleColumn::kOther, i, layout.others[i].column()});
  }
  if (!layout.sockets.empty()) columns.push_back({SampleColumn::kSocket, 0, "socket"});
  return columns;
}

/// The other names and units in which a file may give what it must give: degrees, and q1, q2
/// ... of an arm whose joints have names of their own. Commanded values in all of them.
std::vector<HeaderColumn> other_names(const SampleLayout& layout) {
  std::vector<HeaderColumn> columns;
  const auto add = [&](std::size_t i, const std::string& name) {
    const Joint& joint = layout.joints[i];
    const std::string command = name + std::string(kCommandSuffix);
    if (name != joint.name) {
      columns.push_back({SampleColumn::kJoint, i, name + '_' + joint.unit});
      columns.push_back({SampleColumn::kCommand, i, command + '_' + joint.unit});
    }
    if (joint.degrees_too) {
      columns.push_back({SampleColumn::kJoint, i, name + "_deg", geometry::kDegPerRad});
      columns.push_back({SampleColumn::kCommand, i, command + "_deg", geometry::kDegPerRad});
    }
  };
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    add(i, layout.joints[i].name);
    const std::string number = fmt::format("q{}", i + 1);
    const bool taken =
        std::ranges::find(layout.joints, number, &Joint::name) != layout.joints.end();
    if (!layout.joints[i].known_by_name_only && !taken) add(i, number);
  }
  for (std::size_t i = 0; i < layout.others.size(); ++i) {
    if (layout.others[i].unit != "rad") continue;
    columns.push_back(
        {SampleColumn::kOther, i, layout.others[i].name + "_deg", geometry::kDegPerRad});
  }
  for (std::size_t i = 0; i < 4 && first_turn(layout); ++i) {
    columns.push_back({SampleColumn::kQuaternion, i, std::string("q").append(1, "wxyz"[i])});
  }
  for (std::size_t i = 0; i < layout.axes.size() && layout.dials == 0; ++i) {
    columns.push_back({SampleColumn::kDeviation, i, fmt::format("sd_{}_mm", layout.axes[i])});
  }
  return columns;
}

std::string dial_ids(const SampleLayout& layout) {
  if (layout.dials == 0) return "none";
  std::string ids;
  for (std::size_t i = 0; i < layout.dials; ++i) {
    if (!ids.empty()) ids += ", ";
    ids += layout.channels[i].name.substr(kDialColumn.size());
  }
  return ids;
}

/// The id in "dial_<id>_mm".
std::optional<std::string> dial_id_in(const std::string& name) {
  constexpr std::string_view kBack = "_mm";
  if (!name.starts_with(kDialColumn) || !name.ends_with(kBack) ||
      name.size() <= kDialColumn.size() + kBack.size()) {
    return std::nullopt;
  }
  return name.substr(kDialColumn.size(), name.size() - kDialColumn.size() - kBack.size());
}

/// The unknown column that was most likely meant to be `wanted`.
std::string likely_meant(const std::vector<HeaderColumn>& columns, const std::string& wanted) {
  std::vector<std::string> unknown;
  for (const HeaderColumn& column : columns) {
    if (column.column == SampleColumn::kUnknown) unknown.push_back(column.name);
  }
  const std::string nearest = nearest_word(wanted, unknown);
  if (nearest.empty()) return "";
  return fmt::format("; was {} meant?", shown(nearest));
}

/// Letters and digits alone, in small letters.
std::string spelling(std::string_view name) {
  std::string plain;
  for (const char c : name) {
    const auto code = static_cast<unsigned char>(c);
    if (std::isalnum(code) != 0 || code >= 0x80U) {
      plain += static_cast<char>(std::tolower(code));
    }
  }
  return plain;
}

/// Columns that a header may leave out, and that nobody would miss if their name is misspelt:
/// an unknown column that is almost one of them is a mistake.
void find_misspelt(
    const CsvRow& header, const std::vector<HeaderColumn>& known,
    const std::vector<HeaderColumn>& columns, std::vector<Mistake>& mistakes) {
  constexpr std::size_t kLongEnough = 6;  // for a letter more or less to say nothing else
  const auto has = [&](const HeaderColumn& wanted) {
    return std::ranges::any_of(columns, [&](const HeaderColumn& each) {
      return each.column == wanted.column && each.index == wanted.index;
    });
  };
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].column != SampleColumn::kUnknown || dial_id_in(columns[i].name)) continue;
    const std::string here = spelling(columns[i].name);
    if (here.empty()) continue;
    const auto meant = std::ranges::find_if(known, [&](const HeaderColumn& each) {
      if (each.column == SampleColumn::kSet || each.column == SampleColumn::kJoint)
        return false;
      const std::string there = spelling(each.name);
      const bool alike =
          here == there || (there.size() >= kLongEnough && edit_distance(here, there) <= 1);
      // Without its unit: "temperature", "dial_A".
      const std::string front =
          spelling(std::string_view(each.name).substr(0, each.name.rfind('_')));
      return (alike || (front.size() >= kLongEnough - 1 && here == front)) && !has(each);
    });
    if (meant == known.end()) continue;
    mistakes.push_back(
        {header.line, header.fields[i].column, columns[i].name, "is no column that is known",
         fmt::format("was '{}' meant? Else give it a name that is not so near", meant->name)});
  }
}

std::string ordinal(std::size_t index) {
  constexpr std::array kWords{"first", "second", "third", "fourth", "fifth", "sixth"};
  return index < kWords.size() ? kWords[index] : fmt::format("{}th", index + 1);
}

/// "x_mm and y_mm", "target_x_mm, target_y_mm and target_z_mm".
std::string all_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

/// No column is known and some are numbers: a table's first row instead of its header.
bool is_values(const std::vector<HeaderColumn>& columns) {
  int numbers = 0;
  for (const HeaderColumn& column : columns) {
    if (column.column != SampleColumn::kUnknown) return false;
    if (!parse_number(column.name).trouble) ++numbers;
  }
  return numbers >= 2;
}

/// A table with another separator.
bool is_in_one_piece(const std::vector<HeaderColumn>& columns) {
  return columns.size() == 1 && columns[0].name.find_first_of(";\t|") != std::string::npos;
}

/// Adds mistakes for the columns that a header lacks.
class Missing {
 public:
  Missing(
      const CsvRow& header, const SampleLayout& layout,
      const std::vector<HeaderColumn>& columns, std::vector<Mistake>& mistakes)
      : layout_(layout),
        columns_(columns),
        mistakes_(mistakes),
        line_(header.line),
        after_last_(
            header.fields.back().column + static_cast<int>(header.fields.back().value.size())),
        other_separator_(is_in_one_piece(columns)) {}

  void find() {
    need(SampleColumn::kSet, 0, "set", "add it: G1 calibrates, G2 validates");
    for (std::size_t i = 0; i < layout_.joints.size(); ++i) {
      const Joint& joint = layout_.joints[i];
      need(
          SampleColumn::kJoint, i, joint.column(),
          joint.unit == "rad"
              ? fmt::format("add the {} encoder angle in radians", ordinal(i))
              : fmt::format("add the {} joint's encoder value in {}", ordinal(i), joint.unit));
    }
    const std::size_t axes = layout_.axes.size();
    const std::size_t coordinates = count(SampleColumn::kChannel, layout_.dials);
    need_turn();
    const bool others = count(SampleColumn::kOther, 0) + count(SampleColumn::kSocket, 0) > 0;
    if (coordinates == 0 && !layout_.gives_position) {
      if (!others) need_others();
    } else if (coordinates == 0 && count(SampleColumn::kChannel, 0) == 0) {
      std::vector<std::string> names;
      std::string list;
      for (const std::string& axis : layout_.axes) {
        names.push_back(axis + "_mm");
        list += (list.empty() ? "" : ", ") + names.back();
      }
      mistakes_.push_back(
          {line_, after_last_, "", fmt::format("there are no dial columns and no {}", list),
           fmt::format(
               "add dial_<id>_mm for the rig file's dials ({}) or {}", dial_ids(layout_),
               all_of(names))});
    } else if (coordinates > 0 && coordinates < axes) {
      need_all(SampleColumn::kChannel, layout_.dials, "", "a position");
    }
    need_commands();
    const std::size_t targets = count(SampleColumn::kTarget, 0);
    if (targets > 0 && targets < axes)
      need_all(SampleColumn::kTarget, 0, "target_", "a target");
  }

 private:
  /// A turn is three angles or a quaternion, whole.
  void need_turn() {
    constexpr std::array<const char*, 4> kQuaternion{"qw", "qx", "qy", "qz"};
    const std::size_t parts = count(SampleColumn::kQuaternion, 0);
    if (parts > 0) {
      for (std::size_t i = 0; i < kQuaternion.size(); ++i) {
        need(SampleColumn::kQuaternion, i, kQuaternion[i], "a quaternion needs all four");
      }
    }
    if (!first_turn(layout_) || parts > 0) return;
    for (std::size_t i = 0; i < layout_.others.size(); ++i) {
      if (layout_.others[i].unit != "rad") continue;
      need(
          SampleColumn::kOther, i, layout_.others[i].column(),
          "the rig's instrument gives a pose: add rx_rad, ry_rad, rz_rad (or _deg), or qw, qx, "
          "qy, qz");
    }
  }

  void need_commands() {
    if (count(SampleColumn::kCommand, 0) == 0) return;
    for (std::size_t i = 0; i < layout_.joints.size(); ++i) {
      need(
          SampleColumn::kCommand, i, layout_.joints[i].command_column(),
          "commanded values are of all joints or of none");
    }
  }

  void need_others() {
    std::vector<std::string> names;
    if (!layout_.sockets.empty()) names.emplace_back("socket");
    for (const Channel& other : layout_.others) {
      if (!other.name.starts_with(kSocketChannel)) names.push_back(other.column());
    }
    mistakes_.push_back(
        {line_, after_last_, "", "there is no column of what the instrument shows",
         fmt::format("the rig file's instrument shows {}", all_of(names))});
  }

  [[nodiscard]] std::size_t count(SampleColumn wanted, std::size_t from) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(columns_, [&](const HeaderColumn& column) {
          return column.column == wanted && column.index >= from;
        }));
  }

  void need(
      SampleColumn wanted, std::size_t index, const std::string& name,
      const std::string& hint) {
    const bool has = std::ranges::any_of(columns_, [&](const HeaderColumn& column) {
      return column.column == wanted && column.index == index;
    });
    if (has) return;
    mistakes_.push_back(
        {line_, after_last_, name, "the column is missing",
         other_separator_ ? std::string("separate columns by commas")
                          : hint + likely_meant(columns_, name)});
  }

  void need_all(
      SampleColumn wanted, std::size_t first, const std::string& front, const char* what) {
    std::vector<std::string> names;
    names.reserve(layout_.axes.size());
    for (const std::string& axis : layout_.axes) names.push_back(front + axis + "_mm");
    for (std::size_t i = 0; i < names.size(); ++i) {
      need(wanted, first + i, names[i], fmt::format("{} needs {}", what, all_of(names)));
    }
  }

  const SampleLayout& layout_;
  const std::vector<HeaderColumn>& columns_;
  std::vector<Mistake>& mistakes_;
  int line_;
  int after_last_;
  bool other_separator_;
};

}  // namespace

std::vector<HeaderColumn> read_header(
    const CsvRow& header, const SampleLayout& layout, std::vector<Mistake>& mistakes) {
  std::vector<HeaderColumn> known = known_columns(layout);
  std::ranges::move(other_names(layout), std::back_inserter(known));
  std::vector<HeaderColumn> columns;
  std::map<std::string, int> seen;
  if (header.fault) mistakes.push_back(*header.fault);
  for (const CsvField& field : header.fields) {
    HeaderColumn column{SampleColumn::kUnknown, 0, field.value};
    const auto found = std::ranges::find(known, field.value, &HeaderColumn::name);
    if (found != known.end()) {
      column = *found;
    } else if (const auto id = dial_id_in(field.value)) {
      mistakes.push_back(
          {header.line, field.column, field.value,
           fmt::format("dial {} is not in the rig file", shown(*id)),
           fmt::format("the rig file's dials: {}", dial_ids(layout))});
    }
    // Columns without a name are a spreadsheet's own, and nobody's.
    if (!field.value.empty() && ++seen[field.value] == 2) {
      mistakes.push_back(
          {header.line, field.column, field.value, "the column appears twice",
           "give each column a name of its own"});
    }
    const auto same = std::ranges::find_if(columns, [&](const HeaderColumn& each) {
      const bool of_joint =
          column.column == SampleColumn::kJoint || column.column == SampleColumn::kCommand;
      return of_joint && each.column == column.column && each.index == column.index &&
             each.name != column.name;
    });
    if (same != columns.end()) {
      mistakes.push_back(
          {header.line, field.column, field.value,
           fmt::format("{} gives the same joint", same->name), "leave one of them out"});
    }
    columns.push_back(std::move(column));
  }
  if (is_values(columns)) {
    std::string names;
    const bool dials = layout.dials > 0;
    for (const HeaderColumn& each : spec_columns(layout, dials, !dials)) {
      names += (names.empty() ? "" : ",") + each.name;
    }
    mistakes = {
        {header.line, 1, "", "the first line is no header: it has values",
         "put a line with the names of the columns above it: " + names}};
    return columns;
  }
  find_misspelt(header, known, columns, mistakes);
  Missing(header, layout, columns, mistakes).find();
  return columns;
}

std::vector<HeaderColumn> spec_columns(
    const SampleLayout& layout, bool with_dials, bool with_position, bool with_commands) {
  std::vector<HeaderColumn> columns;
  for (HeaderColumn& column : known_columns(layout)) {
    const bool channel = column.column == SampleColumn::kChannel;
    if (column.column == SampleColumn::kCommand && !with_commands) continue;
    if (!layout.gives_position && channel && column.index >= layout.dials) continue;
    if (channel && !(column.index < layout.dials ? with_dials : with_position)) continue;
    columns.push_back(std::move(column));
  }
  return columns;
}

}  // namespace sixdial::session
