// Which stored result a request means.
#pragma once

#include <optional>

#include "service/methods/method.h"
#include "service/service.h"

namespace sixdial::service {

/// The result numbered params["result"], else the newest calibration of params["session"].
/// Throws Error: invalid_params (neither is given), not_found, bad_data (the result is of
/// another session).
[[nodiscard]] db::ResultRecord calibration_record(const Call& call);
/// The same for a diagnosis.
[[nodiscard]] db::ResultRecord diagnosis_record(const Call& call);

/// The diagnosis that params["diagnosis"] names, else the newest of params["session"]. Throws
/// Error as above, and bad_data for a result of another kind.
[[nodiscard]] db::ResultRecord extending_record(const Call& call);
/// The newest result of a kind from the same samples as a calibration; empty: there is none.
[[nodiscard]] std::optional<db::ResultRecord> companion_of(
    db::Store& reader, const db::ResultRecord& calibration, const char* kind);
/// Results know their data. Throws Error bad_data where the result is not of the session
/// `wanted`, called `name`.
void check_session(
    const db::ResultRecord& record, db::SessionId wanted, const std::string& name);

}  // namespace sixdial::service
