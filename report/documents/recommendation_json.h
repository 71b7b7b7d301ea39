// The document "sixdial.recommendation": which model to command by, and its parameters.
#pragma once

#include "report/documents/json.h"
#include "studies/recommendation.h"

namespace sixdial::report {

inline constexpr int kRecommendationSchemaVersion = 1;

[[nodiscard]] Json to_json(const studies::Recommendation& recommended);

}  // namespace sixdial::report
