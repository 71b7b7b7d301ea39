// The figures of a diagnosis, from the curves that its document carries.
#pragma once

#include <optional>

#include "report/document.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::report {

/// What each sample says of a cause, and the fitted cause; empty where it has no curve.
[[nodiscard]] std::optional<report::Figure> signature_figure(const Json& cause);
/// RMS of what is left by each covariate, before and after, beside the noise.
[[nodiscard]] std::optional<report::Figure> left_figure(const Json& document);
/// Arrows: the shift of the tool that explains each sample's residuals, before and after.
[[nodiscard]] std::optional<report::Figure> shift_figure(const Json& document);

}  // namespace sixdial::report
