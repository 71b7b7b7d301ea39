// A job as everybody sees it: the board that runs it, the database, the socket, the command
// line. Its states are those of the database.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "db/types.h"
#include "service/methods/method.h"
#include "studies/progress.h"

namespace sixdial::service {

using db::JobState;

struct Job {
  std::int64_t id = 0;
  std::string kind{};     // "calibration", "comparison", "diagnosis", "validation"
  std::string session{};  // its name; empty: of none
  Caller caller{};
  Json params{};  // of the method that started it
  JobState state = JobState::kQueued;
  studies::Progress progress{};
  std::string created_utc{};
  std::optional<std::string> started_utc{}, finished_utc{};
  std::optional<std::int64_t> result_id{};
  Json error{};  // error object of a failed or cancelled job
};

/// As job.status answers.
[[nodiscard]] Json to_json(const Job& job);
/// The same read again, by a client: all but `params`, and of the caller only the name. Throws
/// studies::StudyError bad_data that names the key which is missing or of the wrong kind.
[[nodiscard]] Job job_from_json(const Json& json);

/// "progress" of a job: stage, done, total, best_mm, eta_s.
[[nodiscard]] Json to_json(const studies::Progress& progress);
[[nodiscard]] studies::Progress progress_from_json(const Json& json);

}  // namespace sixdial::service
