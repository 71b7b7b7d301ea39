// Raw samples: appended, retaken, withdrawn. Nothing is changed or deleted.
#include <fmt/format.h>

#include <utility>

#include "db/sample_writer.h"
#include "db/store_steps.h"
#include "session/bundle.h"
#include "session/csv.h"

namespace sixdial::db {
namespace {

std::optional<std::string> text_of(const std::optional<session::TimePoint>& time) {
  return time ? std::optional(session::to_iso8601(*time)) : std::nullopt;
}

std::optional<double> commanded_value(const session::Sample& sample, std::size_t joint) {
  const auto j = static_cast<Eigen::Index>(joint);
  return j < sample.q_command.size() ? std::optional(sample.q_command[j]) : std::nullopt;
}

}  // namespace

std::optional<double> coordinate(const std::optional<session::Position>& point, int axis) {
  return point && axis < point->size() ? std::optional((*point)[axis]) : std::nullopt;
}

SampleWriter::SampleWriter(Database& database)
    : database_(database),
      sample_(
          database,
          "INSERT INTO samples (session_id, set_name, point, repeat, time_utc, target_x_mm, "
          "target_y_mm, target_z_mm, temperature_c, line, source_row, supersedes, stored_utc) "
          "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      joint_(
          database,
          "INSERT INTO sample_joints (sample_id, joint_index, joint, unit, value, approach, "
          "commanded) VALUES (?, ?, ?, ?, ?, ?, ?)"),
      channel_(
          database,
          "INSERT INTO sample_channels (sample_id, channel_index, channel, unit, value, "
          "quality, reason, time_utc) VALUES (?, ?, ?, ?, ?, ?, ?, ?)") {}

SampleId SampleWriter::write(
    SessionId session, const session::Sample& sample, std::optional<SampleId> supersedes,
    const session::SampleLayout& layout) {
  std::optional<std::int64_t> replaced;
  if (supersedes) replaced = supersedes->value;
  sample_
      .bind(
          session.value, session::as_utf8(sample.set), sample.point, sample.repeat,
          text_of(sample.time_utc), coordinate(sample.target_mm, 0),
          coordinate(sample.target_mm, 1), coordinate(sample.target_mm, 2),
          sample.temperature_c, sample.line, sample.source_row, replaced, now_utc())
      .run();
  const SampleId id{database_.last_row_id()};
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    joint_
        .bind(
            id.value, static_cast<int>(i), layout.joints[i].name, layout.joints[i].unit,
            sample.q[static_cast<Eigen::Index>(i)], session::approach_of(sample, i),
            commanded_value(sample, i))
        .run();
  }
  for (std::size_t i = 0; i < sample.channels.size(); ++i) {
    const session::ChannelValue& reading = sample.channels[i];
    channel_
        .bind(
            id.value, static_cast<int>(i), layout.channels[i].name, layout.channels[i].unit,
            reading.value, session::to_string(reading.quality),
            session::as_utf8(reading.reason), text_of(reading.time_utc))
        .run();
  }
  return id;
}

void Store::refuse_bad_sample(SessionId id, const session::Sample& sample) {
  const std::string problem = session::sample_problem(layout_of(id), sample);
  if (problem.empty()) return;
  throw StoreError(
      StoreTrouble::kRefused, path_,
      fmt::format(
          "set {}, point {}, repeat {} cannot be stored: {}", session::as_utf8(sample.set),
          sample.point, sample.repeat, problem),
      "");
}

std::optional<SampleId> Store::live_sample(SessionId id, const session::Sample& sample) {
  Statement query(
      *database_,
      "SELECT id FROM live_samples WHERE session_id = ? AND set_name = ? AND point = ? AND "
      "repeat = ?");
  query.bind(id.value, session::as_utf8(sample.set), sample.point, sample.repeat);
  if (!query.step()) return std::nullopt;
  return SampleId{query.number(0)};
}

SampleId Store::append_sample(SessionId id, const session::Sample& sample) {
  return writing([&] {
    refuse_bad_sample(id, sample);
    if (live_sample(id, sample)) {
      throw StoreError(
          StoreTrouble::kAlreadyThere, path_,
          fmt::format(
              "set {}, point {}, repeat {} is measured already", sample.set, sample.point,
              sample.repeat),
          "retake it, or give it the next repeat number");
    }
    return SampleWriter(*database_).write(id, sample, std::nullopt, layout_of(id));
  });
}

SampleId Store::retake_sample(SessionId id, const session::Sample& sample) {
  return writing([&] {
    refuse_bad_sample(id, sample);
    const auto replaced = live_sample(id, sample);
    if (!replaced) {
      not_found(
          "sample",
          fmt::format(
              "set {}, point {}, repeat {} is not measured yet", sample.set, sample.point,
              sample.repeat),
          "append it instead");
    }
    return SampleWriter(*database_).write(id, sample, replaced, layout_of(id));
  });
}

void Store::insert_withdrawal(SampleId id, const std::string& reason, const Operator& who) {
  Statement(
      *database_,
      "INSERT INTO withdrawals (sample_id, reason, operator, stored_utc) VALUES (?, ?, ?, ?)")
      .bind(id.value, reason, who.name, now_utc())
      .run();
}

void Store::withdraw_sample(SampleId id, const std::string& reason, const Operator& who) {
  writing([&] {
    Statement live(*database_, "SELECT 1 FROM live_samples WHERE id = ?");
    live.bind(id.value);
    if (!live.step()) {
      not_found(
          "sample", fmt::format("there is no sample number {} that counts", id.value),
          "it was retaken or undone already");
    }
    insert_withdrawal(id, reason, who);
  });
}

std::optional<SampleId> Store::undo_last(
    SessionId id, const std::string& reason, const Operator& who) {
  return writing([&]() -> std::optional<SampleId> {
    (void)rig_of(id);
    Statement newest(*database_, "SELECT max(id) FROM live_samples WHERE session_id = ?");
    newest.bind(id.value);
    newest.step();
    if (newest.is_null(0)) return std::nullopt;
    const SampleId last{newest.number(0)};
    insert_withdrawal(last, reason, who);
    return last;
  });
}

}  // namespace sixdial::db
