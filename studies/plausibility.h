// What speaks against a session before any number of it is believed: sets that nobody uses,
// copied rows, wrong dates, a unit, a frame, an exchanged column, the robot's mode ... Every
// study asks here first, so that all commands say the same of the same data. One check a file
// in studies/plausibility/; words for people are made last, in report/words/warning_words.h.
//
// Example:
//   const PlausibleSession judged = plausible(session);
//   const int told = static_cast<int>(judged.warnings.size());
//   is_clean(judged.warnings);  // -> told == 0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "geometry/registration.h"
#include "session/session.h"

namespace sixdial::studies {

enum class Severity {
  kNote,   // told; what was done about it is right, the result stands
  kDoubt,  // nothing is called calibrated before this is settled
  kWrong,  // the same, and no command for the robot is made from it
};

/// A row of the session as people find it again.
struct RowName {
  int line = 0;  // of session.csv; 0: measured here
  std::string set{};
  int point = 0, repeat = 0;
};

/// Where it stands. Of many rows the first kNamedRows, of all rows none.
struct WarningPlace {
  static constexpr std::size_t kNamedRows = 8;
  std::string file{};  // "session.csv", "rig.toml"
  std::string
      field{};   // column or key, several separated by ", "; empty: the whole row or file
  int rows = 0;  // how many, 0: not about rows
  std::vector<RowName> named{};
};

/// What a sentence is made of, by name.
using WarningParts = std::map<std::string, std::variant<double, std::string>>;

struct Warning {
  std::string code{};  // "copied_rows"
  Severity severity = Severity::kNote;
  WarningPlace where{};
  WarningParts parts{};
};

/// True if no warning forbids to call the robot calibrated.
[[nodiscard]] bool is_clean(const std::vector<Warning>& warnings);
/// True if a warning forbids commands to the robot.
[[nodiscard]] bool forbids_commands(const std::vector<Warning>& warnings);

/// The rig file's working mode, or the one that the samples stand in where they all say
/// another.
[[nodiscard]] geometry::WorkingMode working_mode_in_use(
    const std::vector<Warning>& warnings, const geometry::Rig& rig);

/// `session` is what fits and judgements may use: rows that are not to be counted are left out
/// (Sample::left_out), single values that cannot be are emptied. Rows keep their numbers.
struct PlausibleSession {
  session::Session session;
  std::vector<Warning> warnings{};
  /// The instrument has a frame of its own: what brings the rig file's frame, where targets are
  /// meant, into it. `session` is all in the instrument's frame then, nominal robot and targets
  /// included. Empty: both are the same.
  std::optional<geometry::Similarity> frame{};
  /// Dials are exchanged: whose readings each dial's column holds, and `session` has them put
  /// right. Empty: they are not.
  std::vector<int> dial_of_column{};
};
/// `judged.session` with targets and positions transformed back into the rig file's frame, in
/// which plans are made. `filed`: the rig as the file has it.
[[nodiscard]] session::Session in_rig_frame(
    const PlausibleSession& judged, const geometry::Rig& filed);
/// Two dials and no more are exchanged; a diagnosis names that by itself.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> exchanged_pair(
    const PlausibleSession& judged);
/// The code of too few different poses for the parameters that are fitted
/// (plausibility_of_fit.h).
inline constexpr std::string_view kTooFewPoses = "too_few_poses";
/// Judges a session: what every study asks before it believes any number of it.
[[nodiscard]] PlausibleSession plausible(const session::Session& session);

}  // namespace sixdial::studies
