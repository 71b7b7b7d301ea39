// Rows of the store as the socket shows them, and back.
#pragma once

#include "db/store.h"
#include "service/job.h"

namespace sixdial::service {

[[nodiscard]] db::Operator to_operator(const Caller& caller);
/// "alice (uid 1000)" as it was stored.
[[nodiscard]] Caller to_caller(const db::Operator& who);

/// A job of an earlier run, or of this one before the board knew it.
[[nodiscard]] Job job_from(const db::JobRecord& record, db::Store& store);

/// name, origin, created_utc, operator, rig_hash, samples, samples_by_set, plan_points, ...
[[nodiscard]] Json to_json(const db::SessionInfo& info);
/// Name of the stored action that says: the computer's clock was changed during a collection.
inline constexpr const char* kClockStep = "clock.step";
/// {median, max} over a session's samples; null: no sample knows its dials' times.
[[nodiscard]] Json readings_within_json(const session::Session& session);
/// result, kind, session, job, created_utc, seed, version; not the document.
[[nodiscard]] Json to_json(const db::ResultRecord& record, const std::string& session);

}  // namespace sixdial::service
