// What was measured, kept: sessions with their rig, plans, raw samples, jobs and results in one
// SQLite file. Raw rows are never changed; a sample is on the disk when append_sample returns.
// One Store writes a file at a time (others are refused), any number read it. Every function
// may be called from any thread and throws StoreError.
//
// Example:
//   Store store = Store::open(folder / "sixdial.db");
//   const SessionId id = store.create_session("monday", rig_text);
//   store.append_sample(id, session.samples[0]);  // on the disk when it returns
//   store.load_session(id).samples.size();  // -> 1U
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "db/store_error.h"
#include "db/types.h"
#include "session/plan.h"
#include "session/sample_layout.h"
#include "session/session.h"

namespace sixdial::db {

class Database;
class WriterLock;

class Store {
 public:
  /// Opens for writing; makes the file or brings its schema up to date. ":memory:" works.
  /// `vfs`: SQLite's name of a file system, for tests of faults.
  [[nodiscard]] static Store open(const std::string& path, const std::string& vfs = "");
  [[nodiscard]] static Store open_read_only(const std::string& path);
  ~Store();
  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;

  // Sessions
  /// Throws DataError for a bad rig file, StoreError kNameTaken for a name in use.
  SessionId create_session(
      const std::string& name, const std::string& rig_text, const Operator& who = {},
      const std::string& note = "");
  /// A whole session with its samples and rejected rows in one transaction.
  SessionId import_session(
      const session::Session& session, const Operator& who = {}, const std::string& note = "");
  /// Live samples only; gives back the bytes of an imported bundle.
  [[nodiscard]] session::Session load_session(SessionId id);
  [[nodiscard]] std::vector<SessionInfo> list_sessions();
  [[nodiscard]] SessionInfo session_info(SessionId id);
  /// By name, else by number; kNotFound names the nearest name.
  [[nodiscard]] SessionId find_session(const std::string& name_or_id);
  [[nodiscard]] geometry::Rig load_rig(SessionId id);

  // Samples
  /// On the disk when it returns. kAlreadyThere if the key is measured; kRefused for values
  /// without sense (session::sample_problem).
  SampleId append_sample(SessionId id, const session::Sample& sample);
  /// Takes the place of the live sample of the same set, point and repeat.
  SampleId retake_sample(SessionId id, const session::Sample& sample);
  /// Takes a live sample out; what it had replaced counts again.
  void withdraw_sample(SampleId id, const std::string& reason, const Operator& who = {});
  /// The same for the newest live sample; empty: there is none.
  std::optional<SampleId> undo_last(
      SessionId id, const std::string& reason = "undo", const Operator& who = {});
  /// Live and other samples with their ids, in order.
  [[nodiscard]] std::vector<StoredSample> list_samples(SessionId id);

  // Plans
  PlanId save_plan(SessionId id, const session::Plan& plan);
  /// The newest plan; empty if there is none.
  [[nodiscard]] std::optional<session::Plan> load_plan(SessionId id);
  [[nodiscard]] std::vector<PointKey> done_points(SessionId id);
  /// Points of the newest plan without a live sample, in the plan's order.
  [[nodiscard]] std::vector<session::PlanPoint> open_points(SessionId id);

  // Jobs
  JobId save_job(const NewJob& job);
  void update_job(JobId id, const JobUpdate& update);
  [[nodiscard]] JobRecord load_job(JobId id);
  [[nodiscard]] std::vector<JobRecord> list_jobs(std::optional<SessionId> session = {});
  /// Jobs that a crash left queued or running; returns how many there were.
  int fail_unfinished_jobs(const std::string& reason);

  // Results
  ResultId save_result(const NewResult& result);
  [[nodiscard]] ResultRecord load_result(ResultId id);
  /// Newest last; `kind` empty: all kinds.
  [[nodiscard]] std::vector<ResultRecord> load_results(
      SessionId id, std::string_view kind = "");

  // The record of who did what
  void record_action(
      const Operator& who, const std::string& action, std::optional<SessionId> session = {},
      const std::string& detail = "");
  [[nodiscard]] std::vector<ActionRecord> list_actions(int most = 1000);

  // The file
  /// A copy by SQLite's backup, complete and in one file. The target must not exist.
  void backup(const std::string& path);
  /// Moves the write-ahead log into the file.
  void checkpoint();
  /// Empty: sound. Else what integrity_check and foreign_key_check found.
  [[nodiscard]] std::vector<std::string> check();
  [[nodiscard]] int schema_version();
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  Store(std::string path, std::unique_ptr<Database> database, std::unique_ptr<WriterLock> lock);

  /// Runs a step in one transaction, alone. After a disk failure it refuses.
  template <typename Step>
  auto writing(Step step);
  /// Runs queries that see one state of the file.
  template <typename Step>
  auto reading(Step step);

  struct KnownRig {
    geometry::Rig rig;
    session::SampleLayout layout;
  };

  // Within a step
  const KnownRig& known_rig(SessionId id);
  const geometry::Rig& rig_of(SessionId id);
  const session::SampleLayout& layout_of(SessionId id);
  session::Session session_of(SessionId id);
  SessionInfo info_of(SessionId id);
  SessionId insert_session(
      const session::Session& session, const char* origin, const Operator& who,
      const std::string& note);
  void refuse_bad_sample(SessionId id, const session::Sample& sample);
  std::optional<SampleId> live_sample(SessionId id, const session::Sample& sample);
  void refuse_bad_json(const std::string& what, const std::string& json);
  void insert_withdrawal(SampleId id, const std::string& reason, const Operator& who);
  /// `missing`: the kind of row, "session".
  [[noreturn]] void not_found(
      std::string_view missing, const std::string& what, const std::string& hint = "") const;

  std::string path_;
  std::unique_ptr<WriterLock> lock_;  // outlives the connection; empty: read-only or in memory
  std::unique_ptr<Database> database_;
  std::unique_ptr<std::mutex> mutex_;
  bool read_only_ = false;
  std::string failed_;  // the disk failure after which nothing more is written
  std::unordered_map<std::int64_t, KnownRig> rigs_;  // by session: a session keeps its rig
};

}  // namespace sixdial::db
