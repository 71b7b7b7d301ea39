#include "report/words/diagnosis_axes.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <utility>

namespace sixdial::report {
namespace {

using studies::Along;
using studies::CurveAxis;
using studies::CurveGroupOf;
using studies::CurvePanelOf;
using studies::LeftInClass;
using studies::Quantity;

struct AxisWords {
  CurveAxis axis;
  std::string_view name;  // of a joint what stands before its number
  std::string_view unit;
};
constexpr std::array kAxes{
    AxisWords{CurveAxis::kJointAngle, "theta", "deg"},
    AxisWords{CurveAxis::kJointSlide, "slide", "mm"},
    AxisWords{CurveAxis::kToolX, "x", "mm"},
    AxisWords{CurveAxis::kToolY, "y", "mm"},
    AxisWords{CurveAxis::kToolZ, "z", "mm"},
    AxisWords{CurveAxis::kOtherJoint, "the other joint, number ", "deg"},
    AxisWords{CurveAxis::kTime, "time", "min"},
    AxisWords{CurveAxis::kSample, "sample", ""},
    AxisWords{CurveAxis::kTemperature, "temperature", "degC"},
    AxisWords{CurveAxis::kTravel, "direction of the last move", "deg"},
    AxisWords{CurveAxis::kForce, "force of the plungers along the same axis", "N"},
    AxisWords{CurveAxis::kOtherCoordinate, "the other coordinate of the tool", "mm"},
    AxisWords{CurveAxis::kFaceRotation, "rotation of the face", "deg"},
    AxisWords{CurveAxis::kReadingTimesFace, "reading times rotation of the face", "mm rad"},
    AxisWords{CurveAxis::kReading, "reading", "mm"},
    AxisWords{CurveAxis::kAnyReading, "reading of the dial", "mm"},
    AxisWords{CurveAxis::kSimulatedReading, "what the simulation says", "mm"},
    AxisWords{CurveAxis::kJointArrival, "arrival of the joints", ""},
    AxisWords{CurveAxis::kPlungerTravel, "travel of the plunger", ""},
    AxisWords{CurveAxis::kDial, "dial", ""}};

struct QuantityWords {
  Quantity quantity;
  std::string_view name;  // of a joint what stands before its number
  std::string_view unit;
};
constexpr std::array kQuantities{
    QuantityWords{Quantity::kJointAngleError, "angle error of joint ", "deg"},
    QuantityWords{Quantity::kJointSlideError, "travel error of joint ", "mm"},
    QuantityWords{Quantity::kToolShift, "shift of the tool", "mm"},
    QuantityWords{Quantity::kResidual, "residual", "mm"},
    QuantityWords{Quantity::kReading, "reading", "mm"}};

constexpr std::array kGroups{
    std::pair{CurveGroupOf::kSamples, std::string_view("sample")},
    std::pair{CurveGroupOf::kReadings, std::string_view("reading")},
    std::pair{CurveGroupOf::kTurningUp, std::string_view("arrives turning up")},
    std::pair{CurveGroupOf::kTurningDown, std::string_view("arrives turning down")},
    std::pair{CurveGroupOf::kPlungerIn, std::string_view("plunger going in")},
    std::pair{CurveGroupOf::kPlungerOut, std::string_view("plunger coming out")}};

constexpr std::string_view kPanelX = "in x";
constexpr std::string_view kPanelY = "in y";
constexpr std::string_view kPanelZ = "in z";
constexpr std::string_view kDialPanel = "dial ";
constexpr std::string_view kGoingIn = "going in";
constexpr std::string_view kComingOut = "coming out";
constexpr std::string_view kTo = " to ";

const AxisWords& words_of(CurveAxis axis) {
  for (const AxisWords& each : kAxes) {
    if (each.axis == axis) return each;
  }
  return kAxes.front();  // never: the table has every axis
}

const QuantityWords& words_of(Quantity quantity) {
  for (const QuantityWords& each : kQuantities) {
    if (each.quantity == quantity) return each;
  }
  return kQuantities.front();  // never: the table has every quantity
}

template <class Number>
std::optional<Number> number_from(std::string_view text) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [ptr, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || ptr != end) return std::nullopt;
  return value;
}

/// 1 for "theta2", where "theta" is the prefix.
std::optional<int> index_after(std::string_view prefix, std::string_view name) {
  if (!name.starts_with(prefix)) return std::nullopt;
  const auto number = number_from<int>(name.substr(prefix.size()));
  return number && *number > 0 ? std::optional(*number - 1) : std::nullopt;
}

std::string_view arrival_word(int sign) {
  return sign > 0 ? "up" : sign < 0 ? "down" : "unknown";
}

std::string arrival_name(const std::vector<int>& signs) {
  std::string name;
  for (std::size_t joint = 0; joint < signs.size(); ++joint) {
    name += fmt::format(
        "{}joint {} {}", joint == 0 ? "" : ", ", joint + 1, arrival_word(signs[joint]));
  }
  return name;
}

bool arrival_from(std::string_view name, std::vector<int>& signs) {
  while (!name.empty()) {
    const std::string_view one = name.substr(0, name.find(kBetween));
    name.remove_prefix(std::min(name.size(), one.size() + kBetween.size()));
    bool found = false;
    for (const int sign : {-1, 0, 1}) {
      if (one != fmt::format("joint {} {}", signs.size() + 1, arrival_word(sign))) continue;
      signs.push_back(sign);
      found = true;
      break;
    }
    if (!found) return false;
  }
  return !signs.empty();
}

bool range_from(std::string_view name, LeftInClass& each) {
  const std::size_t at = name.find(kTo);
  if (at == std::string_view::npos) return false;
  const auto low = number_from<double>(name.substr(0, at));
  const auto high = number_from<double>(name.substr(at + kTo.size()));
  if (!low || !high) return false;
  each.low = *low;
  each.high = *high;
  return true;
}

bool has_joint(CurveAxis axis) {
  return axis == CurveAxis::kJointAngle || axis == CurveAxis::kJointSlide ||
         axis == CurveAxis::kOtherJoint;
}

bool has_joint(Quantity quantity) {
  return quantity == Quantity::kJointAngleError || quantity == Quantity::kJointSlideError;
}

}  // namespace

std::string axis_name(const Along& along) {
  const std::string name(words_of(along.axis).name);
  return has_joint(along.axis) ? name + std::to_string(along.joint + 1) : name;
}

std::string axis_in_words(const Along& along) {
  if (along.axis == CurveAxis::kJointAngle) {
    return fmt::format("angle of joint {}", along.joint + 1);
  }
  if (along.axis == CurveAxis::kJointSlide) {
    return fmt::format("travel of joint {}", along.joint + 1);
  }
  return axis_name(along);
}

std::optional<Along> axis_from(std::string_view name) {
  for (const AxisWords& each : kAxes) {
    if (has_joint(each.axis)) {
      if (const auto joint = index_after(each.name, name)) return Along{each.axis, *joint};
    } else if (each.name == name) {
      return Along{.axis = each.axis};
    }
  }
  return std::nullopt;
}

std::string_view axis_unit(const Along& along) { return words_of(along.axis).unit; }

bool is_number(CurveAxis axis) {
  return axis != CurveAxis::kJointArrival && axis != CurveAxis::kPlungerTravel &&
         axis != CurveAxis::kDial;
}

std::string quantity_name(const studies::SignatureCurve& curve) {
  const std::string name(words_of(curve.quantity).name);
  return has_joint(curve.quantity) ? name + std::to_string(curve.joint + 1) : name;
}

bool quantity_from(std::string_view name, studies::SignatureCurve& curve) {
  for (const QuantityWords& each : kQuantities) {
    const bool of_joint = has_joint(each.quantity);
    const auto joint = of_joint ? index_after(each.name, name) : std::nullopt;
    if (of_joint ? !joint : each.name != name) continue;
    curve.quantity = each.quantity;
    curve.joint = joint.value_or(-1);
    return true;
  }
  return false;
}

std::string_view quantity_unit(Quantity quantity) { return words_of(quantity).unit; }

std::string panel_name(const studies::CurvePanel& panel) {
  switch (panel.of) {
    case CurvePanelOf::kToolX:
      return std::string(kPanelX);
    case CurvePanelOf::kToolY:
      return std::string(kPanelY);
    case CurvePanelOf::kToolZ:
      return std::string(kPanelZ);
    case CurvePanelOf::kDial:
      return std::string(kDialPanel) + panel.dial;
    case CurvePanelOf::kWhole:
      break;
  }
  return "";
}

bool panel_from(std::string_view name, studies::CurvePanel& panel) {
  if (name.starts_with(kDialPanel)) {
    panel.of = CurvePanelOf::kDial;
    panel.dial = name.substr(kDialPanel.size());
    return true;
  }
  panel.of = name == kPanelX   ? CurvePanelOf::kToolX
             : name == kPanelY ? CurvePanelOf::kToolY
             : name == kPanelZ ? CurvePanelOf::kToolZ
                               : CurvePanelOf::kWhole;
  return panel_name(panel) == name;
}

std::string_view group_name(CurveGroupOf of) {
  for (const auto& [each, name] : kGroups) {
    if (each == of) return name;
  }
  return {};  // never: the table has every group
}

std::optional<CurveGroupOf> group_from(std::string_view name) {
  for (const auto& [each, own] : kGroups) {
    if (own == name) return each;
  }
  return std::nullopt;
}

std::string class_name(CurveAxis axis, const LeftInClass& each) {
  switch (axis) {
    case CurveAxis::kJointArrival:
      return arrival_name(each.signs);
    case CurveAxis::kPlungerTravel:
      return std::string(each.signs.front() > 0 ? kGoingIn : kComingOut);
    case CurveAxis::kDial:
      return each.dial;
    default:
      return fmt::format("{:.3g}{}{:.3g}", each.low, kTo, each.high);
  }
}

bool class_from(CurveAxis axis, std::string_view name, LeftInClass& each) {
  switch (axis) {
    case CurveAxis::kJointArrival:
      return arrival_from(name, each.signs);
    case CurveAxis::kPlungerTravel:
      each.signs = {name == kGoingIn ? 1 : -1};
      return name == kGoingIn || name == kComingOut;
    case CurveAxis::kDial:
      each.dial = name;
      return true;
    default:
      return range_from(name, each);
  }
}

}  // namespace sixdial::report
