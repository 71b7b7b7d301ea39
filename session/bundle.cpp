#include "session/bundle.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "session/columns.h"
#include "session/csv.h"
#include "session/rig_file.h"

namespace sixdial::session {
namespace {

using Key = std::tuple<std::string, int, int>;  // set, point, repeat

/// Rows of a table, one after the other, into samples.
class RowReader {
 public:
  RowReader(const geometry::Rig& rig, std::vector<HeaderColumn> columns)
      : rig_(rig), columns_(std::move(columns)) {
    for (const HeaderColumn& column : columns_) {
      if (column.column == Column::kPoint) has_point_ = true;
    }
  }

  /// The sample, or what is wrong with the row, at the first field that is.
  tl::expected<Sample, Finding> read(const CsvRow& row) {
    if (row.fault) return tl::unexpected(*row.fault);
    if (row.fields.size() != columns_.size()) return tl::unexpected(wrong_count(row));
    Sample sample;
    sample.line = row.line;
    sample.source_row = std::string(row.text);
    DialValue absent;
    absent.reason = "no column in the file";
    sample.dials.assign(rig_.dials.size(), absent);
    pairs_ = {};
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (auto finding = read_field(row, row.fields[i], columns_[i], sample)) {
        return tl::unexpected(std::move(*finding));
      }
    }
    for (const Column column : {Column::kX, Column::kTargetX}) {
      const Column other = column == Column::kX ? Column::kY : Column::kTargetY;
      const auto x = pairs_.find(column);
      const auto y = pairs_.find(other);
      if ((x == pairs_.end()) != (y == pairs_.end())) {
        const Column empty = x == pairs_.end() ? column : other;
        return tl::unexpected(
            at(row, empty, "is empty while its partner is not",
               "give both coordinates or neither"));
      }
      if (x == pairs_.end()) continue;
      const Eigen::Vector2d both(x->second, y->second);
      (column == Column::kX ? sample.position_mm : sample.target_mm) = both;
    }
    if (!has_point_) sample.point = next_point_[sample.set];
    if (auto finding = check_against_rig(row, sample))
      return tl::unexpected(std::move(*finding));
    if (auto finding = check_against_rows(row, sample)) {
      return tl::unexpected(std::move(*finding));
    }
    keys_.emplace(Key(sample.set, sample.point, sample.repeat), row.line);
    if (!has_point_) ++next_point_[sample.set];
    if (sample.time_utc) last_time_ = {*sample.time_utc, row.line};
    return sample;
  }

 private:
  Finding at(const CsvRow& row, Column column, std::string what, std::string hint) const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].column != column) continue;
      return {
          row.line, row.fields[i].column, columns_[i].name, std::move(what), std::move(hint)};
    }
    return {row.line, 1, "", std::move(what), std::move(hint)};
  }

  Finding wrong_count(const CsvRow& row) const {
    const std::size_t have = row.fields.size();
    const std::size_t want = columns_.size();
    const CsvField& place = have > want ? row.fields[want] : row.fields.back();
    return {
        row.line, place.column, have > want ? "" : columns_[have - 1].name,
        fmt::format("the row has {} fields, the header has {}", have, want),
        have > want ? "is there a decimal comma, or a comma in text that is not quoted?"
                    : "leave an empty field where there is no value"};
  }

  static Finding field_finding(
      const CsvRow& row, const CsvField& field, const HeaderColumn& column, std::string what,
      std::string hint) {
    return {row.line, field.column, column.name, std::move(what), std::move(hint)};
  }

  std::optional<Finding> read_field(
      const CsvRow& row, const CsvField& field, const HeaderColumn& column, Sample& sample) {
    const auto refuse = [&](std::string what, std::string hint) {
      return field_finding(row, field, column, std::move(what), std::move(hint));
    };
    switch (column.column) {
      case Column::kUnknown:
        return std::nullopt;
      case Column::kSet:
        sample.set = field.value;
        if (field.value.empty()) return refuse("the set is empty", "write G1, G2 or a name");
        return std::nullopt;
      case Column::kPoint:
      case Column::kRepeat: {
        const auto value = parse_integer(field.value);
        if (!value || *value < 0) {
          return refuse(
              shown(field.value) + " is not a whole number from 0", "number them 0, 1, 2 ...");
        }
        (column.column == Column::kPoint ? sample.point : sample.repeat) = *value;
        return std::nullopt;
      }
      case Column::kTime:
        if (field.value.empty()) return std::nullopt;
        sample.time_utc = from_iso8601(field.value);
        if (!sample.time_utc) {
          return refuse(
              shown(field.value) + " is not a time in UTC",
              "write it as 2026-03-02T08:30:06.976Z");
        }
        return std::nullopt;
      case Column::kApproach1:
      case Column::kApproach2: {
        if (field.value.empty()) return std::nullopt;
        const auto value = parse_integer(field.value);
        if (!value || *value < -1 || *value > 1) {
          return refuse(
              shown(field.value) + " is not -1, 0 or 1",
              "give the sign of the joint's last move, or leave it empty");
        }
        sample.approach[column.column == Column::kApproach1 ? 0 : 1] = *value;
        return std::nullopt;
      }
      default:
        return read_number(row, field, column, sample);
    }
  }

  std::optional<Finding> read_number(
      const CsvRow& row, const CsvField& field, const HeaderColumn& column, Sample& sample) {
    const bool angle = column.column == Column::kTheta1 || column.column == Column::kTheta2;
    const ParsedNumber number = parse_number(field.value);
    if (number.trouble && (*number.trouble != NumberTrouble::kEmpty || angle)) {
      return number_finding(row, field, column.name, *number.trouble);
    }
    const bool empty = number.trouble.has_value();
    switch (column.column) {
      case Column::kTheta1:
        sample.q_rad[0] = number.value;
        break;
      case Column::kTheta2:
        sample.q_rad[1] = number.value;
        break;
      case Column::kTemperature:
        if (!empty && number.value < -273.15) {
          return field_finding(
              row, field, column, shown(field.value) + " is below absolute zero",
              "give degrees Celsius");
        }
        if (!empty) sample.temperature_c = number.value;
        break;
      case Column::kDial: {
        DialValue& dial = sample.dials[column.dial];
        dial.reason = empty ? "no contact or no reading" : "";
        if (!empty) dial.value_mm = number.value;
        break;
      }
      default:  // a coordinate of the target or of the position
        if (!empty) pairs_[column.column] = number.value;
        break;
    }
    return std::nullopt;
  }

  std::optional<Finding> check_against_rig(const CsvRow& row, const Sample& sample) const {
    const auto pose = geometry::forward(rig_.robot.nominal, sample.q_rad, rig_.robot.assembly);
    if (pose) return std::nullopt;
    return at(
        row, Column::kTheta1,
        fmt::format(
            "joint angles ({}, {}) rad are out of reach: {}", sample.q_rad[0], sample.q_rad[1],
            describe(pose.error())),
        "check the angles (radians?) against [robot] of the rig file");
  }

  std::optional<Finding> check_against_rows(const CsvRow& row, const Sample& sample) const {
    const auto found = keys_.find(Key(sample.set, sample.point, sample.repeat));
    if (found != keys_.end()) {
      return at(
          row, Column::kPoint,
          fmt::format(
              "set {}, point {}, repeat {} stands in line {} already", sample.set, sample.point,
              sample.repeat, found->second),
          "number repeated readings of a point 0, 1, 2 ... in the column repeat");
    }
    if (sample.time_utc && last_time_ && *sample.time_utc < last_time_->first) {
      return at(
          row, Column::kTime,
          fmt::format(
              "{} is before {} in line {}: time runs backwards", to_iso8601(*sample.time_utc),
              to_iso8601(last_time_->first), last_time_->second),
          "sort the rows by time");
    }
    return std::nullopt;
  }

  const geometry::Rig& rig_;
  std::vector<HeaderColumn> columns_;
  bool has_point_ = false;
  std::map<Column, double> pairs_;  // coordinates seen in this row
  std::map<std::string, int> next_point_;
  std::map<Key, int> keys_;  // with their line
  std::optional<std::pair<TimePoint, int>> last_time_;
};

}  // namespace

Session parse_session(
    std::string_view csv_text, const std::string& csv_name, std::string_view rig_text,
    const std::string& rig_name, const ReadOptions& options) {
  Session session;
  session.name = options.name;
  session.rig = parse_rig(rig_text, rig_name);
  session.rig_text = std::string(rig_text);
  const CsvTable table = read_csv(csv_text, csv_name);
  session.csv_header = std::string(table.header.text);
  session.line_end = table.line_end;
  session.csv_end = table.end;

  std::vector<Finding> findings;
  std::size_t total = 0;
  std::vector<HeaderColumn> columns = read_header(table.header, session.rig, findings);
  if (!findings.empty()) {
    total = findings.size();
    throw DataError(csv_name, std::move(findings), total);
  }
  RowReader reader(session.rig, std::move(columns));
  session.samples.reserve(table.rows.size());
  for (const CsvRow& row : table.rows) {
    auto sample = reader.read(row);
    if (sample) {
      session.samples.push_back(std::move(*sample));
    } else if (options.skip_bad_rows) {
      session.rejected.push_back(
          {row.line, std::string(row.text), to_string(csv_name, sample.error())});
    } else {
      ++total;
      if (findings.size() < DataError::kMostShown) findings.push_back(sample.error());
    }
  }
  if (total > 0) throw DataError(csv_name, std::move(findings), total);
  return session;
}

Session read_bundle(
    const std::filesystem::path& session_csv, const std::filesystem::path& rig_toml,
    const ReadOptions& options) {
  ReadOptions named = options;
  if (named.name.empty()) {
    // The folder says more than "session.csv" does.
    const auto folder = std::filesystem::absolute(session_csv).lexically_normal().parent_path();
    named.name = folder.filename().string();
  }
  const std::string rig_text = read_file(rig_toml.string());
  const std::string csv_text = read_file(session_csv.string());
  return parse_session(csv_text, session_csv.string(), rig_text, rig_toml.string(), named);
}

Session read_bundle(const std::filesystem::path& bundle, const ReadOptions& options) {
  const bool folder = std::filesystem::is_directory(bundle);
  if (!folder && !std::filesystem::exists(bundle)) {
    throw DataError(
        bundle.string(), Finding{
                             0, 0, "", "there is no such folder or file",
                             "name a folder with session.csv and rig.toml, or a CSV file with "
                             "rig.toml beside it"});
  }
  const auto csv = folder ? bundle / "session.csv" : bundle;
  const auto rig = folder ? bundle / "rig.toml" : bundle.parent_path() / "rig.toml";
  return read_bundle(csv, rig, options);
}

}  // namespace sixdial::session
