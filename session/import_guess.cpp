#include "session/import_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "session/csv.h"
#include "session/import_joints.h"
#include "session/import_names.h"
#include "session/import_seen.h"
#include "session/import_time.h"
#include "session/import_units.h"
#include "session/toml_write.h"

namespace sixdial::session {
namespace {

using What = NameRole::What;

class Guesser {
 public:
  Guesser(const ImportTable& table, const SampleLayout* layout)
      : table_(table), layout_(layout), seen_(seen_columns(table)) {}

  Guess guess() {
    for (const SeenColumn& each : seen_) tell_doubtful_unit(each);
    channels();
    guess_joints(seen_, layout_, guess_);
    for (const GuessedColumn& each : guess_.columns) given_.insert(each.to);
    turns();
    places();
    times();
    others();
    tell_left_out();
    tell_missing();
    std::ranges::sort(guess_.columns, {}, &GuessedColumn::column);
    return std::move(guess_);
  }

 private:
  [[nodiscard]] bool is_used(std::size_t column) const {
    return std::ranges::find(guess_.columns, column, &GuessedColumn::column) !=
               guess_.columns.end() ||
           guess_.left_out.contains(column);
  }

  bool take(GuessedColumn column) {
    if (!given_.insert(column.to).second) return false;
    guess_.columns.push_back(std::move(column));
    return true;
  }

  void leave(const SeenColumn& each, std::string why) {
    guess_.left_out.emplace(each.column, std::move(why));
  }

  void tell_doubtful_unit(const SeenColumn& each) {
    for (const std::string& said : each.doubts) {
      guess_.open.push_back(fmt::format("column {}: {}", shown(each.name), said));
    }
  }

  /// Columns that are called as the rig's own channels and dials are: "dial_A", "distance_K1".
  void channels() {
    if (layout_ == nullptr) return;
    std::vector<Channel> all(
        layout_->channels.begin(),
        layout_->channels.begin() + static_cast<std::ptrdiff_t>(layout_->dials));
    for (const Channel& other : layout_->others) {
      if (!other.name.starts_with("socket_") && other.name.size() > 2) all.push_back(other);
    }
    for (const SeenColumn& each : seen_) {
      const auto words = words_of(unit_in_name(each.name).base);
      const auto found = std::ranges::find_if(
          all, [&](const Channel& channel) { return words_of(channel.name) == words; });
      if (found == all.end() || each.values.numbers == 0) continue;
      const std::string to = found->column();
      const bool fits = each.unit != nullptr && factor_of(to, *each.unit);
      if (each.unit != nullptr && !fits) {
        leave(each, fmt::format("{}, which is no unit of {}", each.unit_from, to));
        continue;
      }
      take(
          {.column = each.column,
           .to = to,
           .unit = fits ? std::string(each.unit->name) : "",
           .why =
               fmt::format("the rig calls a channel so{}", fits ? "; " + each.unit_from : "")});
      if (each.unit == nullptr) {
        guess_.open.push_back(fmt::format(
            "column {}: no unit is in the file; it is taken as {} has it: look at unit",
            shown(each.name), to));
      }
    }
  }

  /// The columns of a kind, by key; of several for one key the likeliest.
  std::map<std::string, const SeenColumn*> of_kind(
      What what, UnitKind kind, std::string_view in_words) {
    std::map<std::string, const SeenColumn*> best;
    for (const SeenColumn& each : seen_) {
      if (each.role.what != what || is_used(each.column) || each.values.numbers == 0) continue;
      if (each.unit != nullptr && !each.is_in(kind)) {
        leave(each, fmt::format("{}, which is no unit of {}", each.unit_from, each.role.key));
        continue;
      }
      if (each.role.commanded) {
        leave(each, "what was commanded, not measured");
        continue;
      }
      const SeenColumn*& at = best[each.role.key];
      if (at == nullptr || at->role.rank < each.role.rank) at = &each;
    }
    for (const SeenColumn& each : seen_) {
      if (each.role.what != what || is_used(each.column) || each.values.numbers == 0) continue;
      const SeenColumn* taken = best[each.role.key];
      if (taken == &each) continue;
      leave(each, fmt::format("{} was taken for {}", shown(taken->name), each.role.key));
      guess_.open.push_back(fmt::format(
          "{} and {} may both be {}: the first was taken; look which of them is {}",
          shown(taken->name), shown(each.name), each.role.key, in_words));
    }
    return best;
  }

  [[nodiscard]] bool measures_turns() const {
    return layout_ == nullptr ||
           std::ranges::find(layout_->others, "rx", &Channel::name) != layout_->others.end();
  }

  void turns() {
    auto quaternion = of_kind(What::kQuaternion, UnitKind::kNone, "the measured turn");
    auto angles = of_kind(What::kTurn, UnitKind::kAngle, "the measured turn");
    const bool whole = quaternion.size() == 4;
    for (const auto& [key, each] : quaternion) {
      if (!measures_turns()) {
        leave(*each, "the rig's instrument measures no turns");
      } else if (!whole) {
        leave(*each, "a part of a quaternion; the others are not there");
      } else {
        take({.column = each->column, .to = key, .why = "its name is a part of a quaternion"});
      }
    }
    for (const auto& [key, each] : angles) {
      if (!measures_turns()) {
        leave(*each, "the rig's instrument measures no turns");
      } else if (whole) {
        leave(*each, "the turn is taken from the quaternion");
      }
    }
    if (whole || angles.empty() || !measures_turns()) return;
    double most = 0.0;
    for (const auto& [key, each] : angles) most = std::max(most, each->values.most());
    bool doubtful = false;
    for (const auto& [key, each] : angles) {
      const AngleUnit unit = angle_unit(*each, most);
      doubtful = doubtful || unit.guessed_radians;
      const bool degrees = unit.name == "deg";
      const bool stored = degrees || unit.name == "rad";
      take(
          {.column = each->column,
           .to = key + (degrees ? "_deg" : "_rad"),
           .unit = stored ? "" : unit.name,
           .why = fmt::format("its name speaks of {}; {}", key, unit.why)});
    }
    if (doubtful) guess_.open.push_back(radians_or_degrees("turns of the tool", most));
    guess_.open.push_back(fmt::format(
        "what rx, ry, rz mean is told by orientation in the rig file{}",
        layout_ == nullptr ? "" : fmt::format(": \"{}\"", layout_->orientation)));
  }

  void places() {
    const auto found = of_kind(What::kPlace, UnitKind::kLength, "the measured place");
    double most = 0.0;
    for (const auto& [key, each] : found) {
      if (each->unit == nullptr) most = std::max(most, each->values.most());
    }
    const bool metres = most < kMostMetres;
    bool doubtful = false;
    for (const auto& [key, each] : found) {
      if (layout_ != nullptr && std::ranges::find(layout_->axes, key) == layout_->axes.end()) {
        leave(*each, "the rig's instrument measures in x and y alone");
        continue;
      }
      if (layout_ != nullptr && !layout_->gives_position) {
        leave(*each, "the rig's instrument gives no positions");
        continue;
      }
      doubtful = doubtful || (each->unit == nullptr && metres);
      const std::string unit = each->unit != nullptr ? std::string(each->unit->name)
                               : metres              ? "m"
                                                     : "mm";
      const std::string why = each->unit != nullptr ? each->unit_from
                                                    : fmt::format(
                                                          "values up to {:.4g} are {}", most,
                                                          metres ? "metres" : "millimetres");
      take(
          {.column = each->column,
           .to = key + "_mm",
           .unit = unit,
           .why = fmt::format("its name speaks of {}; {}", key, why)});
    }
    if (!doubtful) return;
    guess_.open.push_back(fmt::format(
        "places up to {:.4g}: no unit is in the file; they are taken as metres, and could be "
        "millimetres: look at unit",
        most));
  }

  /// A column that is named a time counts before one that only has cells like one.
  void times() {
    std::vector<const SeenColumn*> found;
    for (const SeenColumn& each : seen_) {
      if (is_used(each.column)) continue;
      const ColumnValues& values = each.values;
      const int cells = values.numbers + values.others;
      const bool named = each.role.what == What::kTime;
      const bool all_stamps = values.numbers == 0 && values.times == cells;
      if (cells > 0 && 2 * values.times >= cells && (named || all_stamps)) {
        found.push_back(&each);
      } else if (const std::string why = no_time(each); !why.empty()) {
        leave(each, why);
      }
    }
    std::ranges::stable_sort(
        found, {}, [](const SeenColumn* each) { return each->role.what != What::kTime; });
    for (const SeenColumn* each : found) {
      if (!take({.column = each->column, .to = "time_utc", .why = "its cells are times"})) {
        leave(*each, "another column was taken for the time");
        guess_.open.push_back(fmt::format(
            "column {} has times too: look which one is that of the measurement",
            shown(each->name)));
      } else if (any_without_zone(*each)) {
        guess_.open.push_back(fmt::format(
            "times in column {} name no zone: they are taken as UTC", shown(each->name)));
      }
    }
  }

  [[nodiscard]] bool any_without_zone(const SeenColumn& each) const {
    return std::ranges::any_of(table_.rows, [&](const auto& row) {
      const auto time = time_in(row[each.column], table_.decimal_of(each.column));
      return time && time->zone_assumed;
    });
  }

  /// Why what looks like a time is none; empty: it does not look like one.
  [[nodiscard]] std::string no_time(const SeenColumn& each) const {
    const auto first = std::ranges::find_if(
        table_.rows, [&](const auto& row) { return !row[each.column].empty(); });
    if (first == table_.rows.end()) return "";
    const std::string& cell = (*first)[each.column];
    if (is_date_alone(cell) || is_time_of_day(cell)) {
      return "a date or a time of day alone; a time needs both in one column";
    }
    if (is_doubtful_date(cell)) {
      return "day and month cannot be told apart; write times as 2026-11-30 10:09:25";
    }
    if (each.role.what != What::kTime) return "";
    return each.values.numbers > 0 ? "numbers that are no seconds since 1970: damaged by a "
                                     "spreadsheet, or counted from a "
                                     "begin that the file does not say"
                                   : "its cells are no times that are known";
  }

  void others() {
    for (const SeenColumn& each : seen_) {
      if (is_used(each.column)) continue;
      const auto words = words_of(each.name);
      if (each.role.what == What::kTemperature && each.values.numbers > 0) {
        temperature(each);
      } else if (words == std::vector<std::string>{"set"} && each.values.numbers == 0) {
        take({.column = each.column, .to = "set", .why = "its name"});
      } else if (
          words == std::vector<std::string>{"socket"} &&
          (layout_ == nullptr || !layout_->gives_position)) {
        take({.column = each.column, .to = "socket", .why = "its name"});
      }
    }
  }

  void temperature(const SeenColumn& each) {
    GuessedColumn column{
        .column = each.column, .to = "temperature_c", .why = "its name speaks of temperature"};
    if (each.unit != nullptr && !each.is_in(UnitKind::kTemperature)) {
      leave(each, each.unit_from + ", which is no unit of a temperature");
      return;
    }
    if (each.unit != nullptr) {
      column.factor = each.unit->in_stored;
      column.offset = each.unit->offset;
      column.why += "; " + each.unit_from;
    }
    if (!take(std::move(column))) leave(each, "another column was taken for the temperature");
  }

  void tell_left_out() {
    for (const SeenColumn& each : seen_) {
      if (is_used(each.column)) continue;
      if (each.role.what == What::kOther) leave(each, "nothing that a session holds");
    }
  }

  void tell_missing() {
    if (layout_ == nullptr) return;
    const auto lacking = [&](const std::vector<std::string>& needed) {
      std::string list;
      for (const std::string& to : needed) {
        const bool there =
            given_.contains(to) ||
            (to.ends_with("_rad") && given_.contains(to.substr(0, to.size() - 3) + "deg"));
        const bool turned = to.starts_with("r") && given_.contains("qw");
        const bool instead_of_dial = to.starts_with("dial_") && given_.contains("x_mm");
        if (!there && !turned && !instead_of_dial) list += (list.empty() ? "" : ", ") + to;
      }
      return list;
    };
    for (const auto& needed : {needed_joints(*layout_), needed_measured(*layout_)}) {
      const std::string list = lacking(needed);
      if (list.empty()) continue;
      guess_.open.push_back(fmt::format(
          "no column was recognised for {}: add [[column]] with from, to and unit", list));
    }
  }

  const ImportTable& table_;
  const SampleLayout* layout_;
  std::vector<SeenColumn> seen_;
  Guess guess_;
  std::set<std::string> given_;
};

}  // namespace

Guess guess_columns(const ImportTable& table, const SampleLayout* layout) {
  return Guesser(table, layout).guess();
}

std::vector<std::string> needed_joints(const SampleLayout& layout) {
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    columns.push_back(joint_target(&layout, i, false).to);
  }
  return columns;
}

std::vector<std::string> needed_measured(const SampleLayout& layout) {
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < layout.dials; ++i) columns.push_back(layout.channels[i].column());
  if (layout.dials == 0 && layout.gives_position) {
    for (const std::string& axis : layout.axes) columns.push_back(axis + "_mm");
  }
  for (const Channel& other : layout.others) {
    if (!other.name.starts_with("socket_")) columns.push_back(other.column());
  }
  if (columns.empty()) columns.emplace_back("socket");
  return columns;
}

std::string map_lines(const ImportTable& table, const GuessedColumn& column) {
  const std::string& name = table.names[column.column];
  // A name that stands twice, and one that has a meaning of its own, is said by its place.
  const bool by_place = name == "file" || std::ranges::count(table.names, name) > 1;
  std::string text = fmt::format(
      "[[column]]\nfrom = {}\nto = {}\n",
      by_place ? std::to_string(column.column + 1) : toml_string(name), toml_string(column.to));
  if (!column.unit.empty()) text += fmt::format("unit = {}\n", toml_string(column.unit));
  if (column.factor != 1.0) text += fmt::format("factor = {}\n", column.factor);
  if (column.offset != 0.0) text += fmt::format("offset = {}\n", column.offset);
  return text;
}

std::string names_in_words(const ImportTable& table) {
  constexpr std::size_t kLongest = 400;
  constexpr std::size_t kLongestName = 60;
  std::string names;
  for (const std::string& name : table.names) {
    if (names.size() > kLongest) return names + ", ...";
    names += (names.empty() ? "" : ", ");
    std::size_t end = std::min(name.size(), kLongestName);
    while (end < name.size() && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) ++end;
    names += name.substr(0, end) + (end < name.size() ? "..." : "");
  }
  return names;
}

}  // namespace sixdial::session
