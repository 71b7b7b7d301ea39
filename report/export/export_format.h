// A calibrated robot as the files that other programs run. A format is one file in this folder
// and one row here: what of the model it holds, and how that is written. What it does not hold
// is told with the error that makes, never dropped in silence; a robot that it cannot hold at
// all is refused with what to use instead.
//
// Example:
//   const auto result = studies::calibrate(session, {.method = "lm"});
//   const Exported code = export_model(studies::exported_model(result, session), "python");
//   code.left_out.size();  // -> 0U
//   code.miss.max_mm;  // -> 0.0
//   show(code.text);  // a module with forward(q) and inverse(p)
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "studies/exported_model.h"

namespace sixdial::report {

/// A part of the model that a format does not hold.
struct LeftOut {
  std::string what{};                 // "backlash of joint 2"
  std::string why{};                  // "this format has joints alone"
  std::string instead{};              // what to do about it
  std::vector<std::string> values{};  // its numbers, to be entered elsewhere: "b = 0.0008 rad"
  studies::MissBetween miss{};        // what leaving it out makes
};

/// What a format holds of a model.
struct HeldModel {
  studies::ExportedModel model{};
  std::vector<LeftOut> left_out{};
  std::vector<std::string> notes{};  // of what it holds
};

struct ExportOptions {
  /// Of "klipper": position_endstop of the three towers as printer.cfg has them now [mm].
  std::vector<double> endstops_mm{};
  /// Of "urdf": the text of the URDF that the arm came from, whose origins are set right;
  /// empty: a new one is written.
  std::string urdf_text{};
};

struct ExportFormat {
  std::string_view name;       // "urdf", as --as has it
  std::string_view in_words;   // "a URDF"
  std::string_view about;      // what it is for, for a list of formats
  std::string_view file_name;  // "robot.urdf"
  /// Throws StudyError invalid_params for a robot that the format cannot hold.
  HeldModel (*hold)(const studies::ExportedModel& full, const ExportOptions& options) = nullptr;
  std::string (*write)(
      const studies::ExportedModel& full, const HeldModel& held,
      const ExportOptions& options) = nullptr;
};
/// In alphabetical order.
[[nodiscard]] std::span<const ExportFormat* const> export_formats();
[[nodiscard]] const ExportFormat* find_export_format(std::string_view name);

struct Exported {
  std::string format{}, file_name{};
  std::string model{};  // "kinematics", "extended"
  std::string text{};
  std::vector<LeftOut> left_out{};
  std::vector<std::string> notes{};
  studies::MissBetween miss{};  // of all that is left out together
};
/// Throws StudyError invalid_params for a format that there is not, a robot that it cannot hold
/// or an option that it does not have.
[[nodiscard]] Exported export_model(
    const studies::ExportedModel& full, std::string_view format,
    const ExportOptions& options = {});

/// One line for each thing that is left out, and notes: for a terminal, and for the comment
/// that a file begins with.
[[nodiscard]] std::vector<std::string> left_out_lines(
    const std::vector<LeftOut>& left_out, const studies::MissBetween& miss);

}  // namespace sixdial::report
