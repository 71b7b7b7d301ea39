// What a result was made from: enough to find the same data again and to compute every figure
// of it once more. Calibration, comparison and diagnosis carry it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "session/session.h"

namespace sixdial::studies {

struct Inputs {
  std::string session{};  // its name
  std::string rig_name{};
  std::string rig_hash{};   // "sha256:...", of the rig file's content
  std::string data_hash{};  // "sha256:...", of session.csv as it is exported
  int samples = 0;
  int rejected_rows = 0;  // of session.csv, that could not be read
  std::uint64_t seed = 1;
  std::string version{};  // of this program
};

[[nodiscard]] Inputs inputs_of(const session::Session& session, std::uint64_t seed);

/// Results know their data. Throws StudyError bad_data where a result (`what`: "calibration",
/// "diagnosis") was made from other data than the session holds; `hint`: what else there is to
/// do.
void check_same_data(
    const Inputs& inputs, const session::Session& session, std::string_view what,
    std::string_view hint);

/// "sha256:" stands before a hash in documents, not in the database.
inline constexpr std::string_view kHashPrefix = "sha256:";

}  // namespace sixdial::studies
