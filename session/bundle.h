// The session bundle, session.csv + rig.toml (doc/manual/files.md). Required columns: set, one
// for each joint and those of the instrument (dial_<id>_mm; x_mm, y_mm; doc/robots.md). Unknown
// ones are kept. What was read is written back unchanged; a rig that names a URDF without it.
//
// Example:
//   write_bundle(session, folder);  // folder/session.csv and folder/rig.toml
//   const Session again = read_bundle(folder);
//   data_sha256(again);  // -> data_sha256(session)
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "session/data_error.h"
#include "session/sample_layout.h"
#include "session/session.h"

namespace sixdial::session {

struct ReadOptions {
  /// Bad rows go to Session::rejected instead of being an error. A bad header or rig file stays
  /// one.
  bool skip_bad_rows = false;
  std::string name{};  // of the session; empty: the folder's name
};

/// `bundle`: a folder with session.csv and rig.toml, or a CSV file with rig.toml beside it.
/// Throws DataError with up to 20 mistakes.
[[nodiscard]] Session read_bundle(
    const std::filesystem::path& bundle, const ReadOptions& options = {});
[[nodiscard]] Session read_bundle(
    const std::filesystem::path& session_csv, const std::filesystem::path& rig_toml,
    const ReadOptions& options = {});

/// The same from text; `csv_name` and `rig_name` stand in the errors.
[[nodiscard]] Session parse_session(
    std::string_view csv_text, const std::string& csv_name, std::string_view rig_text,
    const std::string& rig_name, const ReadOptions& options = {});

/// session.csv as text: rows as they were read, rows measured here in the columns of the header
/// read, else in the usual ones. A bad reading of such a row is written as no reading.
[[nodiscard]] std::string session_csv(const Session& session);
/// rig.toml as text: as read, else write_rig.
[[nodiscard]] std::string rig_toml(const Session& session);

/// SHA-256 of session_csv: says from which data a result is.
[[nodiscard]] std::string data_sha256(const Session& session);
/// SHA-256 of rig_toml.
[[nodiscard]] std::string rig_sha256(const Session& session);

/// Writes both files into `folder`, which is made if absent. Throws DataError.
void write_bundle(const Session& session, const std::filesystem::path& folder);

/// What is wrong with the values of a sample measured here, in words; empty: nothing. Finite
/// numbers, a set, a value for each joint, a reading for each dial; angles that the nominal
/// robot cannot take are a measurement all the same.
[[nodiscard]] std::string sample_problem(const geometry::Rig& rig, const Sample& sample);
[[nodiscard]] std::string sample_problem(const SampleLayout& layout, const Sample& sample);

}  // namespace sixdial::session
