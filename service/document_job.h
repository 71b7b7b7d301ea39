// A job that reads a session, makes a document of it and stores that as a result: calibration,
// comparison, diagnosis.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "service/service.h"
#include "session/session.h"

namespace sixdial::service {

using DocumentMaker = std::function<Json(
    const session::Session&, const studies::ProgressCallback&, std::stop_token)>;

/// Starts the job for the session that the call names, and answers like job.status. `kind`: of
/// the job and of its result. The session is read when the job begins to run: samples stored
/// before that count.
[[nodiscard]] Json start_document_job(
    const Call& call, const std::string& kind, std::uint64_t seed, DocumentMaker make);

/// Stores a document that a job made and gives the number of the result. `data_hash`:
/// "sha256:..." of the samples it was made from.
[[nodiscard]] std::int64_t save_document(
    Service& service, const Job& job, db::SessionId session, const Json& document,
    const Json& settings, const std::string& data_hash, std::uint64_t seed = 0);

}  // namespace sixdial::service
