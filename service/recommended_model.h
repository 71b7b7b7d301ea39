// The model that is recommended for a session, with the stored results that say so: what
// `compensate` takes by default, what the report and the live page tell.
#pragma once

#include <cstdint>
#include <optional>

#include "db/store.h"
#include "studies/recommendation.h"

namespace sixdial::service {

struct RecommendedModel {
  studies::CalibrationResult calibration;
  std::optional<studies::DiagnosisResult> diagnosis{};    // the newest of the same samples
  std::optional<studies::ValidationResult> validation{};  // the newest of this calibration
  std::int64_t calibration_number = 0;                    // in the database
  std::optional<std::int64_t> diagnosis_number{}, validation_number{};

  [[nodiscard]] studies::Recommendation recommendation() const;
};

/// What speaks against the data of a stored calibration or diagnosis; an early version's is
/// judged now. `document`: the record's, parsed.
[[nodiscard]] std::vector<studies::Warning> warnings_of(
    db::Store& reader, const db::ResultRecord& record, const Json& document);

/// A validation counts if it commanded this calibration: the same method, residual model and
/// parameters. What it measured of a diagnosis' model counts only for that same diagnosis.
[[nodiscard]] RecommendedModel recommended_model(
    db::Store& reader, const db::ResultRecord& calibration);

}  // namespace sixdial::service
