#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "session/bundle.h"
#include "session/columns.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "session/sha256.h"

namespace sixdial::session {
namespace {

constexpr int kAngleDigits = 9;  // 1 nrad, a tenth of the encoder's step
constexpr int kPositionDigits = 6;
constexpr int kTemperatureDigits = 2;

/// Digits after the point that show every step of a dial: 0.001 -> 3, 0.0005 -> 4.
int dial_digits(double resolution_mm) {
  int digits = 3;
  double steps = resolution_mm * 1e3;
  while (digits < 9 && std::abs(steps - std::round(steps)) > 1e-6) {
    steps *= 10;
    ++digits;
  }
  return digits;
}

std::string coordinate(const std::optional<Eigen::Vector2d>& point, int axis) {
  return point ? decimal((*point)[axis], kPositionDigits) : "";
}

std::string field_of(const Session& session, const Sample& sample, const HeaderColumn& column) {
  const auto approach = [&](std::size_t joint) {
    const auto& sign = sample.approach[joint];
    return sign ? std::to_string(*sign) : std::string();
  };
  switch (column.column) {
    case Column::kSet:
      return csv_field(sample.set);
    case Column::kPoint:
      return std::to_string(sample.point);
    case Column::kRepeat:
      return std::to_string(sample.repeat);
    case Column::kTime:
      return sample.time_utc ? to_iso8601(*sample.time_utc) : "";
    case Column::kTheta1:
      return decimal(sample.q_rad[0], kAngleDigits);
    case Column::kTheta2:
      return decimal(sample.q_rad[1], kAngleDigits);
    case Column::kTargetX:
      return coordinate(sample.target_mm, 0);
    case Column::kTargetY:
      return coordinate(sample.target_mm, 1);
    case Column::kApproach1:
      return approach(0);
    case Column::kApproach2:
      return approach(1);
    case Column::kTemperature:
      return sample.temperature_c ? decimal(*sample.temperature_c, kTemperatureDigits) : "";
    case Column::kX:
      return coordinate(sample.position_mm, 0);
    case Column::kY:
      return coordinate(sample.position_mm, 1);
    case Column::kDial: {
      if (column.dial >= sample.dials.size()) return "";
      const DialValue& dial = sample.dials[column.dial];
      if (!dial.value_mm || dial.quality == Quality::kBad) return "";
      return decimal(*dial.value_mm, dial_digits(session.rig.dials[column.dial].resolution_mm));
    }
    case Column::kUnknown:
      return "";
  }
  return "";
}

std::vector<HeaderColumn> columns_of(const Session& session) {
  if (!session.csv_header.empty()) {
    const CsvTable table = read_csv(session.csv_header, "session.csv");
    std::vector<Finding> findings;
    return read_header(table.header, session.rig, findings);
  }
  bool any_position = false;
  bool any_dial = false;
  for (const Sample& sample : session.samples) {
    any_position = any_position || sample.position_mm.has_value();
    for (const DialValue& dial : sample.dials) any_dial = any_dial || dial.value_mm.has_value();
  }
  return spec_columns(session.rig, any_dial || !any_position, any_position);
}

}  // namespace

std::string session_csv(const Session& session) {
  const std::vector<HeaderColumn> columns = columns_of(session);
  std::string out = session.csv_header;
  if (out.empty()) {
    for (const HeaderColumn& column : columns) {
      if (!out.empty()) out += ',';
      out += csv_field(column.name);
    }
  }
  for (const Sample& sample : session.samples) {
    out += session.line_end;
    if (!sample.source_row.empty()) {
      out += sample.source_row;
      continue;
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) out += ',';
      out += field_of(session, sample, columns[i]);
    }
  }
  return out + session.csv_end;
}

std::string rig_toml(const Session& session) {
  return session.rig_text.empty() ? write_rig(session.rig) : session.rig_text;
}

std::string data_sha256(const Session& session) { return sha256(session_csv(session)); }
std::string rig_sha256(const Session& session) { return sha256(rig_toml(session)); }

void write_bundle(const Session& session, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw DataError(
        folder.string(), Finding{
                             0, 0, "", "the folder cannot be made: " + error.message(),
                             "choose another place or mend the rights"});
  }
  write_file((folder / "rig.toml").string(), rig_toml(session));
  write_file((folder / "session.csv").string(), session_csv(session));
}

std::string sample_problem(const geometry::Rig& rig, const Sample& sample) {
  const auto finite = [](const std::optional<double>& value) {
    return !value || std::isfinite(*value);
  };
  if (sample.set.empty()) return "the set is empty";
  if (sample.point < 0 || sample.repeat < 0) return "point and repeat count from 0";
  if (!sample.q_rad.allFinite()) return "a joint angle is not finite";
  for (const auto& sign : sample.approach) {
    if (sign && (*sign < -1 || *sign > 1)) return "an approach is not -1, 0 or 1";
  }
  if (!finite(sample.temperature_c)) return "the temperature is not finite";
  for (const auto& point : {sample.target_mm, sample.position_mm}) {
    if (point && !point->allFinite()) return "a target or position is not finite";
  }
  if (sample.dials.size() != rig.dials.size()) {
    return fmt::format(
        "there are {} dial readings for {} dials", sample.dials.size(), rig.dials.size());
  }
  for (std::size_t i = 0; i < sample.dials.size(); ++i) {
    if (!finite(sample.dials[i].value_mm)) {
      return fmt::format("the reading of dial {} is not finite", rig.dials[i].id);
    }
  }
  return "";
}

}  // namespace sixdial::session
