// Which model is recommended, and why, in words.
#pragma once

#include <string>
#include <vector>

#include "studies/recommendation.h"

namespace sixdial::report {

/// "identified parameters", "robot and named causes + residual model".
[[nodiscard]] std::string model_name(studies::CompensateBy by);

/// "robot and backlash of joint 2 + residual model (ANFIS)": with the causes that belong to it.
[[nodiscard]] std::string recommended_name(const studies::Recommendation& recommended);

/// One sentence or two, with the figures that decided.
[[nodiscard]] std::string why_recommended(const studies::Recommendation& recommended);

/// How to use it, the first advice of a report. `session`: its name, for commands.
[[nodiscard]] std::vector<std::string> how_to_use(
    const studies::Recommendation& recommended, const std::string& session);

}  // namespace sixdial::report
