// Sessions: made, imported, listed and given back.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "db/sample_writer.h"
#include "db/store_steps.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "session/live_channels.h"
#include "session/rig_file.h"
#include "session/sha256.h"

namespace sixdial::db {
namespace {

using session::Sample;
using session::Session;

std::optional<session::TimePoint> time_of(const std::optional<std::string>& text) {
  return text ? session::from_iso8601(*text) : std::nullopt;
}

constexpr const char* kSampleColumns =
    "id, supersedes, set_name, point, repeat, time_utc, target_x_mm, target_y_mm, target_z_mm, "
    "temperature_c, line, source_row";

StoredSample sample_of(const Statement& row) {
  StoredSample stored;
  stored.id = SampleId{row.number(0)};
  if (!row.is_null(1)) stored.supersedes = SampleId{row.number(1)};
  Sample& sample = stored.sample;
  sample.set = row.text(2);
  sample.point = row.integer(3);
  sample.repeat = row.integer(4);
  sample.time_utc = time_of(row.text_or_none(5));
  sample.target_mm = point_from(row, 6);
  sample.temperature_c = row.real_or_none(9);
  sample.line = row.integer(10);
  sample.source_row = row.text(11);
  return stored;
}

/// Gives each row of a child table to its sample. `rows` has the sample's id in column 0 and is
/// ordered by it, as `samples` are.
template <typename Take>
void hand_out(Statement& rows, std::vector<StoredSample>& samples, Take take) {
  std::size_t at = 0;
  while (rows.step()) {
    while (at < samples.size() && samples[at].id.value < rows.number(0)) ++at;
    take(samples.at(at).sample);
  }
}

/// Samples of a table or view in order, with their joint values and readings.
std::vector<StoredSample> samples_from(
    Database& database, const std::string& table, SessionId id) {
  std::vector<StoredSample> samples;
  Statement rows(
      database,
      fmt::format("SELECT {} FROM {} WHERE session_id = ? ORDER BY id", kSampleColumns, table));
  rows.bind(id.value);
  while (rows.step()) samples.push_back(sample_of(rows));

  Statement joints(
      database,
      fmt::format(
          "SELECT j.sample_id, j.value, j.approach, j.commanded FROM {} AS s JOIN "
          "sample_joints AS j ON "
          "j.sample_id = s.id WHERE s.session_id = ? ORDER BY j.sample_id, j.joint_index",
          table));
  joints.bind(id.value);
  hand_out(joints, samples, [&](Sample& sample) {
    sample.q.conservativeResize(sample.q.size() + 1);
    sample.q[sample.q.size() - 1] = joints.real(1);
    sample.approach.push_back(joints.integer_or_none(2));
    if (const auto commanded = joints.real_or_none(3)) {
      sample.q_command.conservativeResize(sample.q.size());
      sample.q_command[sample.q.size() - 1] = *commanded;
    }
  });

  Statement readings(
      database,
      fmt::format(
          "SELECT c.sample_id, c.value, c.quality, c.reason, c.time_utc FROM {} AS s JOIN "
          "sample_channels AS c ON c.sample_id = s.id WHERE s.session_id = ? ORDER BY "
          "c.sample_id, c.channel_index",
          table));
  readings.bind(id.value);
  hand_out(readings, samples, [&](Sample& sample) {
    sample.channels.push_back(
        {.value = readings.real_or_none(1),
         .quality = session::quality_from(readings.text(2)).value_or(session::Quality::kBad),
         .reason = readings.text(3),
         .time_utc = time_of(readings.text_or_none(4))});
  });
  return samples;
}

void check_name(const std::string& path, const std::string& name) {
  const bool control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20U || c == 0x7F;
  });
  constexpr std::size_t kMostBytes = 200;
  if (name.empty() || name.size() > kMostBytes || control || session::as_utf8(name) != name) {
    throw StoreError(
        StoreTrouble::kRefused, path, "this is no name for a session",
        "give 1 to 200 characters without line ends");
  }
}

}  // namespace

std::optional<session::Position> point_from(const Statement& row, int x_column) {
  constexpr int kMost = 3;
  int size = 0;
  while (size < kMost && !row.is_null(x_column + size)) ++size;
  if (size == 0) return std::nullopt;
  session::Position point(size);
  for (int axis = 0; axis < size; ++axis) point[axis] = row.real(x_column + axis);
  return point;
}

SessionId Store::insert_session(
    const Session& session, const char* origin, const Operator& who, const std::string& note) {
  check_name(path_, session.name);
  Statement taken(*database_, "SELECT id FROM sessions WHERE name = ?");
  taken.bind(session.name);
  if (taken.step()) {
    throw StoreError(
        StoreTrouble::kNameTaken, path_,
        fmt::format(
            "there is a session '{}' already (number {})", session.name, taken.number(0)),
        "choose another name");
  }
  const std::string rig_text = session::rig_toml(session);
  const std::string rig_hash = session::sha256(rig_text);
  Statement(*database_, "INSERT INTO rigs (sha256, text) VALUES (?, ?) ON CONFLICT DO NOTHING")
      .bind(rig_hash, rig_text)
      .run();
  Statement rig(*database_, "SELECT id FROM rigs WHERE sha256 = ?");
  rig.bind(rig_hash);
  rig.step();
  Statement(
      *database_,
      "INSERT INTO sessions (name, rig_id, origin, note, created_utc, operator, operator_uid, "
      "operator_pid, program_version, csv_header, line_end, csv_end) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(
          session.name, rig.number(0), origin, note, now_utc(), who.name, who.uid, who.pid,
          SIXDIAL_VERSION, session.csv_header, session.line_end, session.csv_end)
      .run();
  return SessionId{database_->last_row_id()};
}

SessionId Store::create_session(
    const std::string& name, const std::string& rig_text, const Operator& who,
    const std::string& note) {
  Session session;
  session.name = name;
  session.rig = session::parse_rig(rig_text, "rig.toml");
  session.rig_text = rig_text;
  return writing([&] { return insert_session(session, "measured", who, note); });
}

SessionId Store::import_session(
    const Session& session, const Operator& who, const std::string& note) {
  // What stands in the store must be readable from it, whoever filled the struct in memory.
  const geometry::Rig rig = session::parse_rig(session::rig_toml(session), "rig.toml");
  const session::SampleLayout layout = session::layout_of(rig);
  const bool live = session::has_live_channels(rig);
  return writing([&] {
    const SessionId id = insert_session(session, "imported", who, note);
    SampleWriter writer(*database_);
    for (const Sample& each : session.samples) {
      const Sample& sample = live ? session::as_dials(rig, each) : each;
      const std::string problem = session::sample_problem(layout, sample);
      if (!problem.empty()) {
        throw StoreError(
            StoreTrouble::kRefused, path_,
            fmt::format(
                "set {}, point {}, repeat {} cannot be stored: {}", sample.set, sample.point,
                sample.repeat, problem),
            "nothing of this session was imported");
      }
      writer.write(id, sample, std::nullopt, layout);
    }
    Statement rejected(
        *database_,
        "INSERT INTO rejected_rows (session_id, line, text, reason) VALUES (?, ?, ?, ?)");
    for (const session::RejectedRow& row : session.rejected) {
      rejected.bind(id.value, row.line, row.text, row.reason).run();
    }
    return id;
  });
}

const Store::KnownRig& Store::known_rig(SessionId id) {
  const auto found = rigs_.find(id.value);
  if (found != rigs_.end()) return found->second;
  Statement query(
      *database_,
      "SELECT r.text FROM sessions AS s JOIN rigs AS r ON r.id = s.rig_id WHERE s.id = ?");
  query.bind(id.value);
  if (!query.step())
    not_found("session", fmt::format("there is no session number {}", id.value));
  KnownRig known{session::parse_rig(query.text(0), "rig.toml"), {}};
  known.layout = session::layout_of(known.rig);
  return rigs_.emplace(id.value, std::move(known)).first->second;
}

const geometry::Rig& Store::rig_of(SessionId id) { return known_rig(id).rig; }
const session::SampleLayout& Store::layout_of(SessionId id) { return known_rig(id).layout; }

geometry::Rig Store::load_rig(SessionId id) {
  return reading([&] { return rig_of(id); });
}

Session Store::session_of(SessionId id) {
  Session session;
  session.rig = rig_of(id);
  Statement head(
      *database_,
      "SELECT s.name, r.text, s.csv_header, s.line_end, s.csv_end FROM sessions AS s "
      "JOIN rigs AS r ON r.id = s.rig_id WHERE s.id = ?");
  head.bind(id.value);
  head.step();
  session.name = head.text(0);
  session.rig_text = head.text(1);
  session.csv_header = head.text(2);
  session.line_end = head.text(3);
  session.csv_end = head.text(4);
  for (StoredSample& stored : samples_from(*database_, "live_samples", id)) {
    session.samples.push_back(std::move(stored.sample));
  }
  Statement rejected(
      *database_,
      "SELECT line, text, reason FROM rejected_rows WHERE session_id = ? ORDER BY line");
  rejected.bind(id.value);
  while (rejected.step()) {
    session.rejected.push_back({rejected.integer(0), rejected.text(1), rejected.text(2)});
  }
  return session;
}

Session Store::load_session(SessionId id) {
  return reading([&] { return session::as_instrument(session_of(id)); });
}

std::vector<StoredSample> Store::list_samples(SessionId id) {
  return reading([&] {
    (void)rig_of(id);
    std::vector<StoredSample> samples = samples_from(*database_, "samples", id);
    Statement live(*database_, "SELECT id FROM live_samples WHERE session_id = ? ORDER BY id");
    live.bind(id.value);
    for (StoredSample& sample : samples) sample.live = false;
    std::size_t at = 0;
    while (live.step()) {
      while (samples.at(at).id.value < live.number(0)) ++at;
      samples.at(at).live = true;
    }
    return samples;
  });
}

SessionInfo Store::info_of(SessionId id) {
  Statement query(
      *database_,
      "SELECT s.name, s.origin, s.note, s.created_utc, s.operator, s.operator_uid, "
      "s.operator_pid, s.program_version, r.sha256, "
      "(SELECT count(*) FROM rejected_rows AS j WHERE j.session_id = s.id), "
      "(SELECT count(*) FROM results AS e WHERE e.session_id = s.id), "
      "(SELECT count(*) FROM plan_points AS p WHERE p.plan_id = "
      " (SELECT max(id) FROM plans WHERE session_id = s.id)) "
      "FROM sessions AS s JOIN rigs AS r ON r.id = s.rig_id WHERE s.id = ?");
  query.bind(id.value);
  if (!query.step())
    not_found("session", fmt::format("there is no session number {}", id.value));
  SessionInfo info;
  info.id = id;
  info.name = query.text(0);
  info.origin = query.text(1);
  info.note = query.text(2);
  info.created_utc = query.text(3);
  info.who = {query.text(4), query.integer_or_none(5), query.integer_or_none(6)};
  info.program_version = query.text(7);
  info.rig_sha256 = query.text(8);
  info.rejected = query.integer(9);
  info.results = query.integer(10);
  info.planned = query.integer(11);
  Statement sets(
      *database_,
      "SELECT set_name, count(*), min(time_utc), max(time_utc) FROM live_samples "
      "WHERE session_id = ? GROUP BY set_name");
  sets.bind(id.value);
  while (sets.step()) {
    info.samples[sets.text(0)] = sets.integer(1);
    info.sample_count += sets.integer(1);
    const auto first = sets.text_or_none(2);
    const auto last = sets.text_or_none(3);
    if (first && (!info.first_utc || *first < *info.first_utc)) info.first_utc = first;
    if (last && (!info.last_utc || *last > *info.last_utc)) info.last_utc = last;
  }
  return info;
}

SessionInfo Store::session_info(SessionId id) {
  return reading([&] { return info_of(id); });
}

std::vector<SessionInfo> Store::list_sessions() {
  return reading([&] {
    std::vector<SessionInfo> sessions;
    Statement ids(*database_, "SELECT id FROM sessions ORDER BY id");
    while (ids.step()) sessions.push_back(info_of(SessionId{ids.number(0)}));
    return sessions;
  });
}

SessionId Store::find_session(const std::string& name_or_id) {
  return reading([&]() -> SessionId {
    Statement by_name(*database_, "SELECT id FROM sessions WHERE name = ?");
    by_name.bind(name_or_id);
    if (by_name.step()) return SessionId{by_name.number(0)};
    std::int64_t number = 0;
    const char* end = name_or_id.data() + name_or_id.size();
    const auto parsed = std::from_chars(name_or_id.data(), end, number);
    if (parsed.ec == std::errc{} && parsed.ptr == end) {
      Statement by_id(*database_, "SELECT id FROM sessions WHERE id = ?");
      by_id.bind(number);
      if (by_id.step()) return SessionId{number};
    }
    std::vector<std::string> names;
    Statement all(*database_, "SELECT name FROM sessions");
    while (all.step()) names.push_back(all.text(0));
    const std::string nearest = session::nearest_word(name_or_id, names);
    not_found(
        "session",
        fmt::format("there is no session {}", session::shown(session::as_utf8(name_or_id))),
        nearest.empty() ? "there are no sessions yet"
                        : fmt::format("the nearest name is '{}'", nearest));
  });
}

}  // namespace sixdial::db
