#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "session/bundle.h"
#include "session/columns.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"
#include "session/sha256.h"

namespace sixdial::session {
namespace {

constexpr int kAngleDigits = 9;  // 1 nrad, a tenth of the encoder's step
constexpr int kPositionDigits = 6;
constexpr int kTemperatureDigits = 2;

/// Digits after the point that show every step of a reading: 0.001 -> 3, 0.0005 -> 4.
int digits_for(double resolution) {
  int digits = 3;
  double steps = resolution * 1e3;
  while (digits < 9 && std::abs(steps - std::round(steps)) > 1e-6) {
    steps *= 10;
    ++digits;
  }
  return digits;
}

std::string channel_field(
    const SampleLayout& layout, const Sample& sample, std::size_t channel) {
  if (channel >= sample.channels.size()) return "";
  const ChannelValue& reading = sample.channels[channel];
  if (!reading.value || reading.quality == Quality::kBad) return "";
  const double resolution = layout.channels[channel].resolution;
  return decimal(*reading.value, resolution > 0 ? digits_for(resolution) : kPositionDigits);
}

std::string field_of(
    const SampleLayout& layout, const Sample& sample, const HeaderColumn& column) {
  const auto at = static_cast<Eigen::Index>(column.index);
  switch (column.column) {
    case SampleColumn::kSet:
      return csv_field(sample.set);
    case SampleColumn::kPoint:
      return std::to_string(sample.point);
    case SampleColumn::kRepeat:
      return std::to_string(sample.repeat);
    case SampleColumn::kTime:
      return sample.time_utc ? to_iso8601(*sample.time_utc) : "";
    case SampleColumn::kJoint:
    case SampleColumn::kCommand: {
      const Eigen::VectorXd& q =
          column.column == SampleColumn::kJoint ? sample.q : sample.q_command;
      const bool length = layout.joints[column.index].unit == "mm";
      if (at >= q.size()) return "";
      return decimal(q[at] * column.per_unit, length ? kPositionDigits : kAngleDigits);
    }
    case SampleColumn::kTarget:
      return sample.target_mm ? decimal((*sample.target_mm)[at], kPositionDigits) : "";
    case SampleColumn::kApproach: {
      const auto sign = approach_of(sample, column.index);
      return sign ? std::to_string(*sign) : "";
    }
    case SampleColumn::kTemperature:
      return sample.temperature_c ? decimal(*sample.temperature_c, kTemperatureDigits) : "";
    case SampleColumn::kChannel:
      return channel_field(layout, sample, column.index);
    case SampleColumn::kOther: {
      if (column.index >= sample.others.size() || !sample.others[column.index]) return "";
      const bool length = layout.others[column.index].unit == "mm";
      return decimal(
          *sample.others[column.index] * column.per_unit,
          length ? kPositionDigits : kAngleDigits);
    }
    case SampleColumn::kDeviation: {
      if (column.index >= sample.position_sd_mm.size()) return "";
      const auto& sd_mm = sample.position_sd_mm[column.index];
      return sd_mm ? decimal(*sd_mm, kPositionDigits) : "";
    }
    case SampleColumn::kSocket:
      for (std::size_t i = 0; i < layout.sockets.size(); ++i) {
        if (3 * i < sample.others.size() && sample.others[3 * i]) return layout.sockets[i];
      }
      return "";
    case SampleColumn::kQuaternion:  // written as a rotation vector
    case SampleColumn::kUnknown:
      return "";
  }
  return "";
}

std::vector<HeaderColumn> columns_of(const Session& session, const SampleLayout& layout) {
  if (!session.csv_header.empty()) {
    // A line of a file, as it was read: a carriage return within it is no line end.
    const std::string header = session.csv_header + "\n";
    const CsvTable table = read_csv(header, "session.csv");
    std::vector<Mistake> mistakes;
    return read_header(table.header, layout, mistakes);
  }
  bool any_position = false;
  bool any_dial = false;
  for (const Sample& sample : session.samples) {
    for (std::size_t i = 0; i < sample.channels.size(); ++i) {
      if (sample.channels[i].value) (i < layout.dials ? any_dial : any_position) = true;
    }
  }
  const bool any_command = std::ranges::any_of(
      session.samples, [](const Sample& each) { return each.q_command.size() > 0; });
  return spec_columns(layout, any_dial || !any_position, any_position, any_command);
}

}  // namespace

std::string session_csv(const Session& session) {
  const SampleLayout layout = layout_of(session.rig);
  const std::vector<HeaderColumn> columns = columns_of(session, layout);
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
      out += field_of(layout, sample, columns[i]);
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
        folder.string(), Mistake{
                             0, 0, "", "the folder cannot be made: " + error.message(),
                             "choose another place or mend the rights"});
  }
  write_file((folder / "rig.toml").string(), rig_toml(session));
  write_file((folder / "session.csv").string(), session_csv(session));
}

std::string sample_problem(const geometry::Rig& rig, const Sample& sample) {
  return sample_problem(layout_of(rig), sample);
}

std::string sample_problem(const SampleLayout& layout, const Sample& sample) {
  if (sample.set.empty()) return "the set is empty";
  if (sample.point < 0 || sample.repeat < 0) return "point and repeat count from 0";
  const std::size_t joints = layout.joints.size();
  if (static_cast<std::size_t>(sample.q.size()) != joints) {
    return fmt::format("there are {} joint values for {} joints", sample.q.size(), joints);
  }
  for (std::size_t i = 0; i < joints; ++i) {
    if (std::isfinite(sample.q[static_cast<Eigen::Index>(i)])) continue;
    return fmt::format(
        "a joint {} is not finite", layout.joints[i].unit == "rad" ? "angle" : "value");
  }
  const auto told = static_cast<std::size_t>(sample.q_command.size());
  if (told != 0 && told != joints) {
    return fmt::format("there are {} commanded values for {} joints", told, joints);
  }
  if (!sample.q_command.allFinite()) return "a commanded joint value is not finite";
  if (sample.approach.size() > joints) {
    return fmt::format("there are {} approaches for {} joints", sample.approach.size(), joints);
  }
  for (const auto& sign : sample.approach) {
    if (sign && (*sign < -1 || *sign > 1)) return "an approach is not -1, 0 or 1";
  }
  if (sample.temperature_c && !std::isfinite(*sample.temperature_c)) {
    return "the temperature is not finite";
  }
  const auto axes = static_cast<Eigen::Index>(layout.axes.size());
  if (sample.target_mm && sample.target_mm->size() != axes) {
    return fmt::format("a target has {} coordinates, not {}", axes, sample.target_mm->size());
  }
  if (sample.target_mm && !sample.target_mm->allFinite()) {
    return "a target or position is not finite";
  }
  const std::size_t channels = sample.channels.size();
  if (channels != layout.dials && channels != layout.channels.size()) {
    return fmt::format("there are {} dial readings for {} dials", channels, layout.dials);
  }
  for (std::size_t i = 0; i < channels; ++i) {
    const auto& value = sample.channels[i].value;
    if (!value || std::isfinite(*value)) continue;
    if (i >= layout.dials) return "a target or position is not finite";
    return fmt::format(
        "the reading of dial {} is not finite",
        layout.channels[i].name.substr(kDialColumn.size()));
  }
  return "";
}

}  // namespace sixdial::session
