// What the curves of a diagnosis are drawn along, in words. The document keeps these words as
// its names of axes, panels, groups and classes: its reader finds them again in the same
// tables (the functions `..._from`; empty: no such name).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// Between the names of a list: "x, y".
inline constexpr std::string_view kBetween = ", ";

/// "theta2", "slide3", "the other coordinate of the tool": as the document has it.
[[nodiscard]] std::string axis_name(const studies::Along& along);
/// The same for people: "angle of joint 2", whatever the robot calls its joints.
[[nodiscard]] std::string axis_in_words(const studies::Along& along);
[[nodiscard]] std::optional<studies::Along> axis_from(std::string_view name);
/// "deg", "mm"; empty for kinds and for the number of a sample.
[[nodiscard]] std::string_view axis_unit(const studies::Along& along);
/// A number, not a kind of arrival, travel or dial.
[[nodiscard]] bool is_number(studies::CurveAxis axis);

/// "angle error of joint 2", "shift of the tool".
[[nodiscard]] std::string quantity_name(const studies::SignatureCurve& curve);
/// False for a name that no quantity has.
[[nodiscard]] bool quantity_from(std::string_view name, studies::SignatureCurve& curve);
[[nodiscard]] std::string_view quantity_unit(studies::Quantity quantity);

/// "in x", "dial C"; empty: the only panel.
[[nodiscard]] std::string panel_name(const studies::CurvePanel& panel);
[[nodiscard]] bool panel_from(std::string_view name, studies::CurvePanel& panel);
/// "arrives turning up", "reading".
[[nodiscard]] std::string_view group_name(studies::CurveGroupOf of);
[[nodiscard]] std::optional<studies::CurveGroupOf> group_from(std::string_view name);

/// "-12.3 to 4.56", "joint 1 up, joint 2 down", "going in", "C".
[[nodiscard]] std::string class_name(studies::CurveAxis axis, const studies::LeftInClass& each);
[[nodiscard]] bool class_from(
    studies::CurveAxis axis, std::string_view name, studies::LeftInClass& each);

}  // namespace sixdial::report
