// The document "sixdial.diagnosis": doc/schemas/diagnosis.json. Besides what the result holds
// it has its words (verdict, in_words, size_in_words, reasons), for those who read the document
// alone; the reader takes the values and leaves the words, which are made again when needed.
#pragma once

#include "report/documents/json.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {

inline constexpr int kDiagnosisSchemaVersion = 1;

[[nodiscard]] Json to_json(const studies::DiagnosisResult& result);

/// Throws studies::StudyError bad_data: another schema or version, or it names the key which is
/// missing or of the wrong kind.
[[nodiscard]] studies::DiagnosisResult diagnosis_from_json(const Json& json);

/// What was asked for: "settings" of the document's inputs.
[[nodiscard]] Json settings_json(const studies::DiagnosisResult& result);

}  // namespace sixdial::report
