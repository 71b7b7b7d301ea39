// Rows of the store as plain values.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "session/session.h"

namespace sixdial::db {

/// A row's number that cannot be taken for another table's.
template <typename Tag>
struct Id {
  std::int64_t value = 0;
  friend auto operator<=>(const Id&, const Id&) = default;
};
using SessionId = Id<struct SessionTag>;
using SampleId = Id<struct SampleTag>;
using PlanId = Id<struct PlanTag>;
using JobId = Id<struct JobTag>;
using ResultId = Id<struct ResultTag>;

/// Who asked: a name, and the peer's credentials where the socket knows them.
struct Operator {
  std::string name{};
  std::optional<int> uid{};
  std::optional<int> pid{};
};

struct SessionInfo {
  SessionId id{};
  std::string name{};
  std::string origin{};  // "measured" or "imported"
  std::string note{};
  std::string created_utc{};
  Operator who{};
  std::string program_version{};
  std::string rig_sha256{};
  std::map<std::string, int> samples{};  // live samples by set
  int sample_count = 0;                  // live
  int planned = 0;                       // points of the newest plan
  int rejected = 0;
  int results = 0;
  std::optional<std::string> first_utc{};  // of the live samples
  std::optional<std::string> last_utc{};
};

struct StoredSample {
  SampleId id{};
  bool live = true;
  std::optional<SampleId> supersedes{};
  session::Sample sample{};
};

struct PointKey {
  std::string set{};
  int point = 0;
  int repeat = 0;
  friend auto operator<=>(const PointKey&, const PointKey&) = default;
};

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };
[[nodiscard]] const char* to_string(JobState state);
[[nodiscard]] std::optional<JobState> job_state_from(const std::string& text);
/// Done, failed or cancelled.
[[nodiscard]] bool is_final(JobState state);

struct NewJob {
  std::string kind{};  // "calibrate", "diagnose", ...
  std::optional<SessionId> session{};
  std::string request = "{}";  // JSON
  Operator who{};
};

/// Changes the members that are set. A job that has ended keeps its state.
struct JobUpdate {
  std::optional<JobState> state{};
  std::optional<std::string> progress{};  // JSON
  std::optional<std::string> error{};
};

struct JobRecord {
  JobId id{};
  std::string kind{};
  std::optional<SessionId> session{};
  JobState state = JobState::kQueued;
  std::string request{};
  std::string progress{};
  std::string error{};
  Operator who{};
  std::string created_utc{};
  std::optional<std::string> started_utc{};
  std::optional<std::string> finished_utc{};
};

struct NewResult {
  SessionId session{};
  std::string kind{};
  std::string json{};
  std::string settings = "{}";  // JSON
  std::uint64_t seed = 0;
  /// session::data_sha256 of what was used; empty: of the session as it stands.
  std::string data_sha256{};
  std::optional<JobId> job{};
};

struct ResultRecord {
  ResultId id{};
  SessionId session{};
  std::string kind{};
  std::string json{};
  std::string settings{};
  std::uint64_t seed = 0;
  std::string rig_sha256{};
  std::string data_sha256{};
  std::string program_version{};
  std::string created_utc{};
  std::optional<JobId> job{};
};

struct ActionRecord {
  std::string time_utc{};
  Operator who{};
  std::string action{};
  std::optional<SessionId> session{};
  std::string detail{};
};

}  // namespace sixdial::db
