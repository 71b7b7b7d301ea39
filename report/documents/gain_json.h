// One row of a diagnosis' "gain": in the diagnosis itself, and in a validation, which quotes
// what the diagnosis predicts of the extended model.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "report/documents/diagnosis_parts_json.h"
#include "report/documents/fields.h"
#include "report/words/diagnosis_words.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {
namespace diagnosis_document {

inline constexpr std::string_view kNetwork = " + ANFIS";

/// "joint_backlash@joint2"; nothing for an empty name.
inline std::optional<studies::HypothesisId> id_from(std::string_view name) {
  const std::size_t at = name.find('@');
  if (at == std::string_view::npos) return std::nullopt;
  return studies::HypothesisId{
      std::string(name.substr(0, at)), std::string(name.substr(at + 1))};
}

inline std::optional<diagnosis::GainModel> gain_model_from(std::string_view name) {
  for (const diagnosis::GainModel model :
       {diagnosis::GainModel::kNominal, diagnosis::GainModel::kCalibrated,
        diagnosis::GainModel::kExtended}) {
    if (name == gain_row_name({.model = model})) return model;
  }
  return name.starts_with("without ") ? std::optional(diagnosis::GainModel::kWithout)
                                      : std::nullopt;
}

}  // namespace diagnosis_document

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::GainRow>& row) {
  diagnosis_document::as_text(
      at, "name", row, gain_row_name, [](std::string_view text, studies::GainRow& into) {
        into.network = text.ends_with(diagnosis_document::kNetwork);
        if (into.network) text.remove_suffix(diagnosis_document::kNetwork.size());
        const auto model = diagnosis_document::gain_model_from(text);
        into.model = model.value_or(diagnosis::GainModel::kNominal);
        return model.has_value();
      });
  diagnosis_document::as_text(
      at, "without", row.without,
      [](const std::optional<studies::HypothesisId>& id) {
        return id ? id->name() : std::string();
      },
      [](std::string_view text, std::optional<studies::HypothesisId>& id) {
        id = diagnosis_document::id_from(text);
        return id.has_value() || text.empty();
      });
  at("mean_mm", row.mean_mm);
  at("std_mm", row.std_mm);
  at("max_mm", row.max_mm);
  at("rms_mm", row.rms_mm);
  at("rms_by_dial_mm", row.rms_by_dial_mm);
  at("difference_mm", row.difference_mm);
  at("low_mm", row.low_mm);
  at("high_mm", row.high_mm);
  at("removed_share", row.removed_share);
}

}  // namespace sixdial::report
