// "warnings" of a document: what plausibility found. `message` and `where` are words for
// people, `place` and `parts` what they were made of.
#pragma once

#include "report/documents/fields.h"
#include "report/words/warning_words.h"
#include "studies/plausibility.h"

namespace sixdial::report {

[[nodiscard]] inline std::optional<studies::Severity> severity_from(std::string_view text) {
  using enum studies::Severity;
  for (const studies::Severity each : {kNote, kDoubt, kWrong}) {
    if (severity_name(each) == text) return each;
  }
  return std::nullopt;
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::RowName>& row) {
  at("line", row.line);
  at("set", row.set);
  at("point", row.point);
  at("repeat", row.repeat);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::WarningPlace>& place) {
  at("file", place.file);
  at("field", place.field);
  at("rows", place.rows);
  at("named", place.named);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Warning>& warning) {
  at("code", warning.code);
  at.named(
      "severity", warning.severity, [](studies::Severity each) { return severity_name(each); },
      severity_from);
  if constexpr (!Fields::kReads) {
    at("message", warning_text(warning));
    at("where", where_text(warning.where));
  }
  at("place", warning.where);
  std::map<std::string, Json> parts;
  if constexpr (!Fields::kReads) {
    for (const auto& [name, part] : warning.parts) {
      parts[name] = std::visit([](const auto& value) { return Json(value); }, part);
    }
  }
  at("parts", parts);
  if constexpr (Fields::kReads) {
    for (const auto& [name, part] : parts) {
      if (part.is_string()) warning.parts[name] = part.template get<std::string>();
      if (part.is_number()) warning.parts[name] = part.template get<double>();
    }
  }
}

}  // namespace sixdial::report
