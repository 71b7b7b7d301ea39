// The service's hold on the database: one writing connection behind a mutex, opened at start.
// Everything is stored when a call returns. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/error.h"
#include "service/job_board.h"
#include "session/plan.h"
#include "session/session.h"

namespace sixdial::service {

struct SessionInfo {
  std::string name;
  std::string created_utc;
  std::string operator_name;
  std::string rig_name;
  std::string rig_hash;
  std::int64_t samples = 0;
  std::map<std::string, std::int64_t> samples_by_set;
  std::int64_t plan_points = 0;
  std::int64_t rejected_rows = 0;
};
[[nodiscard]] Json to_json(const SessionInfo& info);

struct StoredResult {
  std::int64_t id = 0;
  std::string kind;  // "calibration"
  std::string session;
  std::int64_t job = 0;  // 0: none
  std::string created_utc;
  std::string operator_name;
  Json document;
};

class Store {
 public:
  /// Throws Error storage: another service has it, newer schema, no rights.
  explicit Store(const std::filesystem::path& database);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  /// Throws Error already_exists, bad_data. `session.samples` may be empty (a new session).
  void add_session(const session::Session& session, const std::string& operator_name);
  /// Newest first.
  [[nodiscard]] std::vector<SessionInfo> sessions();
  /// Throws Error not_found with the nearest name.
  [[nodiscard]] SessionInfo session_info(const std::string& name);
  [[nodiscard]] session::Session session(const std::string& name);

  /// Replaces the plan only where no point of the old one was measured (else wrong_state),
  /// unless the new one is the same.
  void set_plan(
      const std::string& session, const session::Plan& plan, const std::string& operator_name);
  [[nodiscard]] session::Plan plan(const std::string& session);
  /// On disk when it returns.
  void add_sample(
      const std::string& session, const session::Sample& sample, const std::string& operator_name);

  [[nodiscard]] std::int64_t add_job(const Job& job);
  void update_job(const Job& job);
  [[nodiscard]] std::optional<Job> job(std::int64_t id);
  [[nodiscard]] std::vector<Job> jobs(const std::string& session, std::int64_t limit);

  [[nodiscard]] std::int64_t add_result(const StoredResult& result);
  /// Throws Error not_found.
  [[nodiscard]] StoredResult result(std::int64_t id);
  /// Without documents, newest first; `session` empty: of all.
  [[nodiscard]] std::vector<StoredResult> results(const std::string& session, std::int64_t limit);

  /// Moves the write-ahead log into the database file.
  void checkpoint();

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace sixdial::service
