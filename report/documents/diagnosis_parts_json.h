// The parts of "sixdial.diagnosis" that are trees of their own: causes with their curves, and
// what is left along each axis. Only for diagnosis_json.cpp.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "report/documents/fields.h"
#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_words.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {
namespace diagnosis_document {

inline constexpr std::string_view kSchema = "sixdial.diagnosis";
inline constexpr std::string_view kUnknown = "unknown";
inline constexpr std::string_view kNothing = "none";
inline constexpr std::string_view kUnsettled = "unsettled_fit";
inline constexpr std::string_view kLeftOut = "left_out_readings";
inline constexpr std::string_view kOutliers = "outliers";
inline constexpr std::string_view kStale = "stale_reading";
inline constexpr std::string_view kRigGeometry = "rig_geometry";

/// "x, y" as a list.
inline std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find(kBetween));
    parts.emplace_back(one);
    text.remove_prefix(std::min(text.size(), one.size() + kBetween.size()));
  }
  return parts;
}

inline std::string joined(const std::vector<std::string>& parts) {
  return fmt::format("{}", fmt::join(parts, kBetween));
}

/// One of two words for a state.
template <class Fields, class State>
void one_of(
    Fields& at, const char* key, State& state, std::type_identity_t<State> first,
    std::string_view first_name, std::type_identity_t<State> second,
    std::string_view second_name) {
  using Value = std::remove_const_t<State>;
  at.named(
      key, state, [&](Value each) { return each == first ? first_name : second_name; },
      [&](std::string_view text) -> std::optional<Value> {
        if (text == first_name) return first;
        if (text == second_name) return second;
        return std::nullopt;
      });
}

/// A key whose text says more than one member: made by `to_text(value)`, taken apart by
/// `take(text, value)`, which returns false for a text that it does not know.
template <class Fields, class Value, class ToText, class Take>
void as_text(Fields& at, const char* key, Value& value, ToText to_text, Take take) {
  bool known = true;
  at.named(
      key, known, [&](bool) { return to_text(value); },
      [&](std::string_view text) -> std::optional<bool> {
        if constexpr (Fields::kReads) {
          if (take(text, value)) return true;
        }
        return std::nullopt;
      });
}

}  // namespace diagnosis_document

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::HypothesisId>& id) {
  at("cause", id.cause);
  at("where", id.where);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Rival>& rival) {
  at("log_odds", rival.log_odds);
  if constexpr (Fields::kReads) {
    describe_keys(at, rival.id);
    rival.kind = rival.id.cause == diagnosis_document::kUnknown   ? studies::RivalKind::kUnknown
                 : rival.id.cause == diagnosis_document::kNothing ? studies::RivalKind::kNothing
                 : rival.id.cause == diagnosis_document::kUnsettled
                     ? studies::RivalKind::kUnsettled
                 : rival.id.cause == diagnosis_document::kLeftOut ? studies::RivalKind::kLeftOut
                                                                  : studies::RivalKind::kEffect;
    if (rival.kind == studies::RivalKind::kUnknown)
      rival.depends_on = diagnosis_document::split(rival.id.where);
    if (rival.kind != studies::RivalKind::kEffect) rival.id = {};
  } else {
    switch (rival.kind) {
      case studies::RivalKind::kEffect:
        describe_keys(at, rival.id);
        break;
      case studies::RivalKind::kUnknown:
        describe_keys(
            at, studies::HypothesisId{
                    std::string(diagnosis_document::kUnknown),
                    diagnosis_document::joined(rival.depends_on)});
        break;
      case studies::RivalKind::kNothing:
        describe_keys(at, studies::HypothesisId{std::string(diagnosis_document::kNothing), ""});
        break;
      case studies::RivalKind::kUnsettled:
        describe_keys(
            at, studies::HypothesisId{std::string(diagnosis_document::kUnsettled), ""});
        break;
      case studies::RivalKind::kLeftOut:
        describe_keys(at, studies::HypothesisId{std::string(diagnosis_document::kLeftOut), ""});
        break;
    }
  }
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::Estimate>& estimate) {
  at("name", estimate.name);
  at("value", estimate.value);
  at("unit", estimate.unit);
  at("sd", estimate.sd);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CurveGroup>& group) {
  at.named("name", group.of, group_name, group_from);
  at("x", group.x);
  at("measured", group.measured);
  at("model", group.model);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CurvePanel>& panel) {
  diagnosis_document::as_text(at, "title", panel, panel_name, panel_from);
  at("groups", panel.groups);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::SignatureCurve>& curve) {
  diagnosis_document::as_text(at, "quantity", curve, quantity_name, quantity_from);
  at.named("covariate", curve.along, axis_name, axis_from);
  at("is_function", curve.is_function);
  at("panels", curve.panels);
  if constexpr (!Fields::kReads) {
    at("unit", quantity_unit(curve.quantity));
    at("covariate_unit", axis_unit(curve.along));
  }
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::FoundCause>& cause) {
  describe_keys(at, cause.id);
  if constexpr (Fields::kReads) {
    cause.kind =
        cause.id.cause == diagnosis_document::kOutliers ? studies::CauseKind::kOutliers
        : cause.id.cause == diagnosis_document::kStale  ? studies::CauseKind::kStaleReadings
        : cause.id.cause == diagnosis_document::kRigGeometry ? studies::CauseKind::kRigGeometry
                                                             : studies::CauseKind::kEffect;
  } else {
    const CauseTexts texts = texts_of(cause);
    at("certainty", cause.certainty() == studies::Certainty::kCertain ? "certain" : "tied");
    at("signature", texts.signature);
    at("consequence", texts.consequence);
    at("advice", texts.advice);
    at("why_not_learned", texts.why_not_learned);
    at("in_words", named(cause));
    at("size_in_words", size_in_words(cause));
  }
  at("tied_with", cause.tied_with);
  at("estimate", cause.estimate);
  at("delta_bic", cause.delta_bic);
  at("gain", cause.gain_mm);
  diagnosis_document::one_of(
      at, "standing", cause.standing, studies::Standing::kConfirmed, "confirmed",
      studies::Standing::kSuspected, "suspected");
  at("on_g1", cause.on_g1);
  at("g2_log_odds", cause.g2_log_odds);
  at("visible_ratio", cause.visible_ratio);
  at("signature_plot", cause.signature);
}

/// A member of every class as one list.
template <class Fields, class Classes, class Member>
void column(
    Fields& at, const char* key, Classes& classes, Member studies::LeftInClass::*member) {
  std::vector<Member> values;
  for (const studies::LeftInClass& each : classes) values.push_back(each.*member);
  at(key, values);
  if constexpr (Fields::kReads) {
    classes.resize(std::max(classes.size(), values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) classes[i].*member = values[i];
  }
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::LeftAlong>& left) {
  at.named("covariate", left.along, axis_name, axis_from);
  if constexpr (!Fields::kReads) {
    at("unit", axis_unit(left.along));
    at("kind", is_number(left.along.axis) ? "number" : "class");
  }
  column(at, "at", left.classes, &studies::LeftInClass::at);
  column(at, "readings", left.classes, &studies::LeftInClass::readings);
  column(at, "before_mm", left.classes, &studies::LeftInClass::before_mm);
  column(at, "after_mm", left.classes, &studies::LeftInClass::after_mm);
  std::optional<std::vector<double>> smooth_mm;
  std::vector<std::string> labels;
  if constexpr (Fields::kReads) {
    at.maybe("smooth_mm", smooth_mm);
    left.has_smooth = smooth_mm.has_value();
    if (smooth_mm) column(at, "smooth_mm", left.classes, &studies::LeftInClass::smooth_mm);
    at("label", labels);
    for (std::size_t i = 0; i < std::min(labels.size(), left.classes.size()); ++i) {
      if (class_from(left.along.axis, labels[i], left.classes[i])) continue;
      const DocumentPlace top;
      refuse_document(
          diagnosis_document::kSchema, {&top, "by_covariate.label", 0},
          fmt::format("is \"{}\", unknown here", labels[i]));
    }
  } else {
    if (left.has_smooth) {
      column(at, "smooth_mm", left.classes, &studies::LeftInClass::smooth_mm);
    }
    for (const studies::LeftInClass& each : left.classes) {
      labels.push_back(class_name(left.along.axis, each));
    }
    at("label", labels);
  }
}

}  // namespace sixdial::report
