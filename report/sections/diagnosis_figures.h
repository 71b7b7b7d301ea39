// The figures of a diagnosis, from the curves that it carries.
#pragma once

#include <cstddef>
#include <optional>

#include "report/document.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// Series::style of what the robot alone leaves, and of what the causes leave.
inline constexpr int kMeasuredStyle = 0;
inline constexpr int kAfterStyle = 3;
inline constexpr std::size_t kRowsOnPage = 24;  // of a table under a figure

/// What each sample says of a cause, and the fitted cause; empty where it has no curve.
[[nodiscard]] std::optional<report::Figure> signature_figure(const studies::FoundCause& cause);
/// RMS of what is left by each covariate, before and after, beside the noise.
[[nodiscard]] std::optional<report::Figure> left_figure(const studies::DiagnosisResult& result);
/// Arrows: the shift of the tool that explains each sample's residuals, before and after.
[[nodiscard]] std::optional<report::Figure> shift_figure(
    const studies::DiagnosisResult& result);

}  // namespace sixdial::report
