// What a check is given and how it tells what it found. A new check is a file in this folder, a
// row in checks.cpp and its words in report/words/warning_words.cpp.
//
//   void look_for_copies(Look& look) {
//     std::vector<std::size_t> copies = ...;
//     for (const std::size_t row : copies) look.used.samples[row].left_out = true;
//     if (!copies.empty()) look.tell("copied_rows", Severity::kNote, look.rows(copies));
//   }
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/registration.h"
#include "studies/plausibility.h"

namespace sixdial::studies::plausibility {

struct Look {
  const session::Session& measured;  // as it was read
  session::Session& used;            // the same less what earlier checks took away
  std::vector<Warning>& found;
  // Of PlausibleSession.
  std::optional<geometry::Similarity>& frame;
  std::vector<int>& dial_of_column;

  void tell(
      std::string_view code, Severity severity, WarningPlace where = {},
      WarningParts parts = {}) {
    found.push_back({std::string(code), severity, std::move(where), std::move(parts)});
  }
  /// These rows of session.csv, in one of its columns.
  [[nodiscard]] WarningPlace rows(
      std::span<const std::size_t> rows, std::string field = {}) const;
  /// A key of the rig file.
  [[nodiscard]] static WarningPlace rig_key(std::string key);
  /// Whether an earlier check told this.
  [[nodiscard]] bool told(std::string_view code) const;
};

struct PlausibilityCheck {
  std::string_view name;
  std::vector<std::string_view> codes;  // that it may tell
  void (*look)(Look& look) = nullptr;
};

/// "A, B and C".
[[nodiscard]] std::string listed(const std::vector<std::string>& names);
/// "dial A", "dials A, B and C".
[[nodiscard]] std::string dials_in_words(const std::vector<std::string>& ids);

/// In the order in which they look.
[[nodiscard]] const std::vector<PlausibilityCheck>& checks();

// One a file.
void look_at_sets(Look& look);
void look_at_clock(Look& look);
void look_at_temperatures(Look& look);
void look_at_angles(Look& look);
void look_for_copies(Look& look);
void look_at_columns(Look& look);
void look_at_travel(Look& look);
void look_at_resolution(Look& look);
void look_at_modes(Look& look);
void look_at_rows_elsewhere(Look& look);
void look_at_cuboid_angle(Look& look);
void look_at_two_instruments(Look& look);
void look_at_turns(Look& look);
void look_at_joints(Look& look);
void look_at_dials(Look& look);
void look_at_sides(Look& look);
void look_for_far_positions(Look& look);
void look_at_frame(Look& look);
void look_for_moved_frame(Look& look);
void look_at_tool_turn(Look& look);
void look_at_targets(Look& look);
void look_at_joint_values(Look& look);
void look_at_certificates(Look& look);

inline constexpr std::string_view kWrongMode = "wrong_mode";

}  // namespace sixdial::studies::plausibility
