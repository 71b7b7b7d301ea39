// What formats share: taking parts out of a model, each with the error that makes, and the
// lines that a file begins with.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "report/export/export_format.h"

namespace sixdial::report {

/// Takes parts out of a model one by one.
class Holding {
 public:
  using Change = std::function<void(studies::ExportedModel&)>;

  explicit Holding(const studies::ExportedModel& full) : full_(full), held_{.model = full} {}

  /// `change` takes the part out of a model; `item.miss` is worked out here.
  void leave_out(LeftOut item, const Change& change);
  void note(std::string words) { held_.notes.push_back(std::move(words)); }

  /// Parameters that keep their nominal values, told as one; nothing where they all have them.
  void leave_nominal(
      LeftOut item, const std::function<bool(const geometry::ParameterInfo&)>& which);
  /// Effects that move the robot and that `holds` does not say yes to. Those that move only
  /// what an instrument shows are told in a note.
  void leave_out_effects(
      std::string_view why, std::string_view instead,
      const std::function<bool(const simulation::ActiveEffect&)>& holds);
  /// What a residual model learned beside the model.
  void leave_out_learned();

  [[nodiscard]] HeldModel done() { return std::move(held_); }

 private:
  const studies::ExportedModel& full_;
  HeldModel held_;
};

/// What to do about effects in a format of geometry alone.
inline constexpr std::string_view kBetterWithoutCauses =
    "The formats c, python and json hold most causes. In this format export the calibrated "
    "robot (kinematics) instead: it was fitted without causes.";

/// A shift of a joint that has come and stays [rad or mm]: its encoder's zero is another one.
[[nodiscard]] bool is_settled_shift(
    const simulation::ActiveEffect& effect, const studies::ExportedModel& model);

/// Whether an effect at its place moves joint values or the tool, not only readings.
[[nodiscard]] bool acts_on_robot(const simulation::ActiveEffect& effect);

[[noreturn]] void refuse_robot(
    const studies::ExportedModel& model, std::string_view format, const std::string& why);

/// What a file says first of itself, without marks of a comment: from which data it was made,
/// what it holds and what not.
[[nodiscard]] std::vector<std::string> heading(
    const studies::ExportedModel& full, const HeldModel& held, std::string_view format);
/// The same lines, each behind `mark`; nothing in them ends a comment or breaks a line.
/// `xml`: nor stand two dashes together, which a comment of XML must not have.
[[nodiscard]] std::string commented(
    const std::vector<std::string>& lines, std::string_view mark, bool xml = false);

/// Shortest text that is read back as the same number: "0.5", "1e-05", "60.0".
[[nodiscard]] std::string exactly(double value);
[[nodiscard]] std::string exactly(const Eigen::Vector3d& value, std::string_view between);

/// What an effect has by name: "b = 0.0008 rad".
[[nodiscard]] std::vector<std::string> sizes_of(const simulation::ActiveEffect& effect);
[[nodiscard]] std::string words_of(const simulation::ActiveEffect& effect);

}  // namespace sixdial::report
