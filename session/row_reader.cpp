#include "session/row_reader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

#include "geometry/rotation.h"
#include "geometry/tool.h"
#include "session/measured_turn.h"

namespace sixdial::session {
namespace {

using Key = std::tuple<std::string, int, int>;  // set, point, repeat

/// "G1 " is G1: a blank that nobody sees does not make another set.
std::string without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks[] = {" ", "\t", "\u00A0", "\u2007", "\u202F", "\uFEFF"};
  for (bool cut = true; cut;) {
    cut = false;
    for (const std::string_view blank : kBlanks) {
      if (text.starts_with(blank)) {
        text.remove_prefix(blank.size());
        cut = true;
      }
      if (text.ends_with(blank)) {
        text.remove_suffix(blank.size());
        cut = true;
      }
    }
  }
  return std::string(text);
}

constexpr double kUnit = 1e-3;  // as quaternions are rounded

/// Rows of a table, one after the other, into samples.
class RowReader {
 public:
  RowReader(
      const geometry::Rig& rig, const SampleLayout& layout, std::vector<HeaderColumn> columns)
      : rig_(rig), layout_(layout), columns_(std::move(columns)) {
    for (const HeaderColumn& column : columns_) {
      if (column.column == SampleColumn::kPoint) has_point_ = true;
      if (column.column == SampleColumn::kCommand) has_commands_ = true;
    }
  }

  /// The sample, or what is wrong with the row, at the first field that is.
  tl::expected<Sample, Mistake> read(const CsvRow& row) {
    if (row.fault) return tl::unexpected(*row.fault);
    if (is_header_again(row)) {
      return tl::unexpected(Mistake{
          row.line, 1, "", "the names of the columns stand here again",
          "leave this line out; two files below each other need points of their own"});
    }
    if (!has_all_fields(row)) return tl::unexpected(wrong_count(row));
    Sample sample;
    sample.line = row.line;
    sample.source_row = std::string(row.text);
    sample.q.setZero(static_cast<Eigen::Index>(layout_.joints.size()));
    sample.q_command.setConstant(has_commands_ ? sample.q.size() : 0, std::nan(""));
    sample.approach.resize(layout_.joints.size());
    sample.channels.assign(layout_.dials, {.reason = "no column in the file"});
    sample.others.assign(layout_.others.size(), std::nullopt);
    quaternion_.assign(4, std::nullopt);
    target_.assign(layout_.axes.size(), std::nullopt);
    position_.assign(layout_.axes.size(), std::nullopt);
    for (std::size_t i = 0; i < std::min(columns_.size(), row.fields.size()); ++i) {
      if (auto mistake = read_field(row, row.fields[i], columns_[i], sample)) {
        return tl::unexpected(std::move(*mistake));
      }
    }
    if (auto mistake = take_coordinates(row, sample)) {
      return tl::unexpected(std::move(*mistake));
    }
    if (auto mistake = take_turn(row, sample)) return tl::unexpected(std::move(*mistake));
    if (auto mistake = take_command(row, sample)) return tl::unexpected(std::move(*mistake));
    if (!has_point_) sample.point = next_point_[sample.set];
    if (auto mistake = check_against_rig(row, sample)) {
      return tl::unexpected(std::move(*mistake));
    }
    if (auto mistake = check_against_rows(row, sample)) {
      return tl::unexpected(std::move(*mistake));
    }
    keys_.emplace(Key(sample.set, sample.point, sample.repeat), row.line);
    if (!has_point_) ++next_point_[sample.set];
    return sample;
  }

 private:
  using Coordinates = std::vector<std::optional<double>>;

  Mistake at(
      const CsvRow& row, SampleColumn column, std::string what, std::string hint,
      std::size_t index = 0) const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].column != column || columns_[i].index != index) continue;
      return {
          row.line, row.fields[i].column, columns_[i].name, std::move(what), std::move(hint)};
    }
    return {row.line, 1, "", std::move(what), std::move(hint)};
  }

  /// As many as the header; columns without a name and fields without a value at the end, as
  /// spreadsheets add them, do not count.
  [[nodiscard]] bool has_all_fields(const CsvRow& row) const {
    const std::size_t have = row.fields.size();
    const std::size_t want = columns_.size();
    for (std::size_t i = have; i < want; ++i) {
      if (!without_blanks(columns_[i].name).empty()) return false;
    }
    for (std::size_t i = want; i < have; ++i) {
      if (!without_blanks(row.fields[i].value).empty()) return false;
    }
    return true;
  }

  [[nodiscard]] bool is_header_again(const CsvRow& row) const {
    return std::ranges::equal(row.fields, columns_, {}, &CsvField::value, &HeaderColumn::name);
  }

  /// A line of units below the header has no number at all.
  static std::string hint_of_empty_set(const CsvRow& row) {
    const bool any_number = std::ranges::any_of(
        row.fields, [](const CsvField& each) { return !parse_number(each.value).trouble; });
    return any_number ? "write G1, G2 or a name"
                      : "no field of this row is a number: leave lines of units or remarks out";
  }

  Mistake wrong_count(const CsvRow& row) const {
    const std::size_t have = row.fields.size();
    const std::size_t want = columns_.size();
    const CsvField& place = have > want ? row.fields[want] : row.fields.back();
    return {
        row.line, place.column, have > want ? "" : columns_[have - 1].name,
        fmt::format("the row has {} fields, the header has {}", have, want),
        have > want ? "is there a decimal comma, or a comma in text that is not quoted?"
                    : "leave an empty field where there is no value"};
  }

  static Mistake field_mistake(
      const CsvRow& row, const CsvField& field, const HeaderColumn& column, std::string what,
      std::string hint) {
    return {row.line, field.column, column.name, std::move(what), std::move(hint)};
  }

  std::optional<Mistake> read_field(
      const CsvRow& row, const CsvField& field, const HeaderColumn& column, Sample& sample) {
    const auto refuse = [&](std::string what, std::string hint) {
      return field_mistake(row, field, column, std::move(what), std::move(hint));
    };
    switch (column.column) {
      case SampleColumn::kUnknown:
        return std::nullopt;
      case SampleColumn::kSet:
        sample.set = without_blanks(field.value);
        if (sample.set.empty()) return refuse("the set is empty", hint_of_empty_set(row));
        return std::nullopt;
      case SampleColumn::kPoint:
      case SampleColumn::kRepeat: {
        const auto value = parse_integer(field.value);
        if (!value || *value < 0) {
          return refuse(
              shown(field.value) + " is not a whole number from 0", "number them 0, 1, 2 ...");
        }
        (column.column == SampleColumn::kPoint ? sample.point : sample.repeat) = *value;
        return std::nullopt;
      }
      case SampleColumn::kTime:
        if (field.value.empty()) return std::nullopt;
        sample.time_utc = from_iso8601(field.value);
        if (!sample.time_utc) {
          return refuse(
              shown(field.value) + " is not a time in UTC",
              "write it as 2026-03-02T08:30:06.976Z");
        }
        return std::nullopt;
      case SampleColumn::kApproach: {
        if (field.value.empty()) return std::nullopt;
        const auto value = parse_integer(field.value);
        if (!value || *value < -1 || *value > 1) {
          return refuse(
              shown(field.value) + " is not -1, 0 or 1",
              "give the sign of the joint's last move, or leave it empty");
        }
        sample.approach[column.index] = *value;
        return std::nullopt;
      }
      case SampleColumn::kSocket: {
        const std::string name = without_blanks(field.value);
        if (name.empty()) return std::nullopt;
        const auto at = std::ranges::find(layout_.sockets, name);
        if (at == layout_.sockets.end()) {
          return refuse(
              shown(name) + " is no socket of the rig file",
              "name a [[socket]], or leave it empty where the tool is in none");
        }
        const auto first = 3 * static_cast<std::size_t>(at - layout_.sockets.begin());
        for (std::size_t k = first; k < first + 3; ++k) sample.others[k] = 0.0;
        return std::nullopt;
      }
      default:
        return read_number(row, field, column, sample);
    }
  }

  /// A quaternion, or three angles of the rig file's convention, as a rotation vector.
  std::optional<Mistake> take_turn(const CsvRow& row, Sample& sample) const {
    const std::optional<std::size_t> turns_from = first_turn(layout_);
    if (!turns_from) return std::nullopt;
    const std::size_t first = *turns_from;
    Eigen::Vector3d turn;
    const auto is_there = [](const std::optional<double>& each) { return each.has_value(); };
    const auto missing = std::ranges::find_if_not(quaternion_, is_there);
    if (missing == quaternion_.end()) {
      Eigen::Quaterniond q(*quaternion_[0], *quaternion_[1], *quaternion_[2], *quaternion_[3]);
      if (!(std::abs(q.norm() - 1.0) < kUnit)) {
        return at(
            row, SampleColumn::kQuaternion,
            fmt::format("the quaternion has length {:.6g}", q.norm()), "it must be 1");
      }
      turn = geometry::rotation_vector(q.normalized().toRotationMatrix());
    } else if (std::ranges::any_of(quaternion_, is_there)) {
      return at(
          row, SampleColumn::kQuaternion, "is empty while its partners are not",
          "give all four numbers of a quaternion or none",
          static_cast<std::size_t>(missing - quaternion_.begin()));
    } else {
      Eigen::Vector3d angles;
      std::size_t given = 0;
      std::size_t empty = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<double>& each = sample.others[first + k];
        given += each ? 1U : 0U;
        if (!each) empty = k;
        angles[static_cast<Eigen::Index>(k)] = each.value_or(0.0);
      }
      if (given == 0) return std::nullopt;
      if (given < 3) {
        return at(
            row, SampleColumn::kOther, "is empty while its partners are not",
            "give all three angles of a turn or none", first + empty);
      }
      turn = turn_of_angles(layout_.orientation, angles).value_or(angles);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      sample.others[first + k] = turn[static_cast<Eigen::Index>(k)];
    }
    return std::nullopt;
  }

  /// Commanded values of all joints, or of none.
  std::optional<Mistake> take_command(const CsvRow& row, Sample& sample) const {
    if (sample.q_command.array().isNaN().all()) {
      sample.q_command.resize(0);
      return std::nullopt;
    }
    for (Eigen::Index i = 0; i < sample.q_command.size(); ++i) {
      if (std::isfinite(sample.q_command[i])) continue;
      return at(
          row, SampleColumn::kCommand,
          "is empty while commanded values of other joints are not",
          "give those of all joints or of none", static_cast<std::size_t>(i));
    }
    return std::nullopt;
  }

  std::optional<Mistake> read_number(
      const CsvRow& row, const CsvField& field, const HeaderColumn& column, Sample& sample) {
    const bool joint = column.column == SampleColumn::kJoint;
    const ParsedNumber number = parse_number(field.value);
    if (number.trouble && (*number.trouble != NumberTrouble::kEmpty || joint)) {
      return number_mistake(row, field, column.name, *number.trouble);
    }
    const bool empty = number.trouble.has_value();
    switch (column.column) {
      case SampleColumn::kJoint:
        sample.q[static_cast<Eigen::Index>(column.index)] = number.value / column.per_unit;
        break;
      case SampleColumn::kCommand:
        if (!empty) {
          sample.q_command[static_cast<Eigen::Index>(column.index)] =
              number.value / column.per_unit;
        }
        break;
      case SampleColumn::kTemperature:
        if (!empty && number.value < -273.15) {
          return field_mistake(
              row, field, column, shown(field.value) + " is below absolute zero",
              "give degrees Celsius");
        }
        if (!empty) sample.temperature_c = number.value;
        break;
      case SampleColumn::kChannel:
        if (column.index < layout_.dials) {
          ChannelValue& dial = sample.channels[column.index];
          dial.reason = empty ? "no contact or no reading" : "";
          if (!empty) dial.value = number.value;
        } else if (!empty) {
          position_[column.index - layout_.dials] = number.value;
        }
        break;
      case SampleColumn::kOther:
        if (!empty) sample.others[column.index] = number.value / column.per_unit;
        break;
      case SampleColumn::kQuaternion:
        if (!empty) quaternion_[column.index] = number.value;
        break;
      case SampleColumn::kDeviation:
        sample.position_sd_mm.resize(layout_.axes.size());
        if (!empty && !(number.value > 0.0)) {
          return field_mistake(
              row, field, column, shown(field.value) + " is no standard deviation",
              "give a positive number, or leave it empty");
        }
        if (!empty) sample.position_sd_mm[column.index] = number.value;
        break;
      default:
        if (!empty) target_[column.index] = number.value;
        break;
    }
    return std::nullopt;
  }

  /// Target and position from the coordinates that were read; each whole or not at all.
  std::optional<Mistake> take_coordinates(const CsvRow& row, Sample& sample) const {
    std::optional<Position> position_mm;
    if (auto empty = point_from(position_, position_mm)) {
      return half_a_point(row, SampleColumn::kChannel, layout_.dials + *empty);
    }
    set_position(sample, layout_.dials, position_mm);
    if (auto empty = point_from(target_, sample.target_mm)) {
      return half_a_point(row, SampleColumn::kTarget, *empty);
    }
    return std::nullopt;
  }

  /// Gives the point if there is one; the first empty coordinate if only some are there.
  static std::optional<std::size_t> point_from(
      const Coordinates& coordinates, std::optional<Position>& point_mm) {
    const auto is_there = [](const std::optional<double>& each) { return each.has_value(); };
    const auto empty = std::ranges::find_if_not(coordinates, is_there);
    if (empty == coordinates.end() && !coordinates.empty()) {
      point_mm.emplace(static_cast<Eigen::Index>(coordinates.size()));
      for (std::size_t i = 0; i < coordinates.size(); ++i) {
        (*point_mm)[static_cast<Eigen::Index>(i)] = coordinates[i].value();
      }
      return std::nullopt;
    }
    if (std::ranges::none_of(coordinates, is_there)) return std::nullopt;
    return static_cast<std::size_t>(empty - coordinates.begin());
  }

  Mistake half_a_point(const CsvRow& row, SampleColumn column, std::size_t index) const {
    const bool two = layout_.axes.size() == 2;
    return at(
        row, column,
        fmt::format("is empty while its {} not", two ? "partner is" : "partners are"),
        two ? "give both coordinates or neither" : "give all coordinates or none", index);
  }

  std::optional<Mistake> check_against_rig(const CsvRow& row, const Sample& sample) const {
    const auto pose =
        geometry::Tool(rig_).position(rig_.robot.nominal, sample.q, rig_.robot.assembly);
    if (pose) return std::nullopt;
    return at(
        row, SampleColumn::kJoint,
        fmt::format(
            "{} are out of reach: {}", joints_in_words(layout_, sample.q),
            describe(pose.error())),
        "check the angles (radians? columns exchanged? a sign?) against [robot] of the rig "
        "file");
  }

  std::optional<Mistake> check_against_rows(const CsvRow& row, const Sample& sample) const {
    const auto found = keys_.find(Key(sample.set, sample.point, sample.repeat));
    if (found != keys_.end()) {
      return at(
          row, SampleColumn::kPoint,
          fmt::format(
              "set {}, point {}, repeat {} stands in line {} already", sample.set, sample.point,
              sample.repeat, found->second),
          "number repeated readings of a point 0, 1, 2 ... in the column repeat");
    }
    return std::nullopt;
  }

  const geometry::Rig& rig_;
  const SampleLayout& layout_;
  std::vector<HeaderColumn> columns_;
  bool has_point_ = false;
  bool has_commands_ = false;
  Coordinates target_;  // of this row, as far as they are there
  Coordinates position_;
  Coordinates quaternion_;
  std::map<std::string, int> next_point_;
  std::map<Key, int> keys_;  // with their line
};

}  // namespace

bool is_blank(const CsvRow& row) {
  return !row.fault && row.fields.size() > 1 &&
         std::ranges::all_of(row.fields, [](const CsvField& field) {
           return without_blanks(field.value).empty();
         });
}

ReadRow row_reader(
    const geometry::Rig& rig, const SampleLayout& layout, std::vector<HeaderColumn> columns) {
  auto reader = std::make_shared<RowReader>(rig, layout, std::move(columns));
  return [reader](const CsvRow& row) { return reader->read(row); };
}

}  // namespace sixdial::session
