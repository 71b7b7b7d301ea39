// Names and words of an uncertainty budget.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "studies/uncertainty_budget.h"

namespace sixdial::report {

/// In documents: "repeatability", "dial_curve", ...
[[nodiscard]] std::string_view budget_source_name(studies::BudgetSource source);
[[nodiscard]] std::optional<studies::BudgetSource> budget_source_from(std::string_view name);
/// "counted", "exact", "not_stated", "contained", "part".
[[nodiscard]] std::string_view budget_state_name(studies::BudgetState state);
[[nodiscard]] std::optional<studies::BudgetState> budget_state_from(std::string_view name);
/// "measured", "commanded".
[[nodiscard]] std::string_view measurand_name(studies::Measurand measurand);
[[nodiscard]] std::optional<studies::Measurand> measurand_from(std::string_view name);

/// "Error curve of dial A".
[[nodiscard]] std::string source_in_words(
    const studies::BudgetRow& row, studies::Measurand measurand);
/// "A position, measured once".
[[nodiscard]] std::string_view measurand_in_words(studies::Measurand measurand);

}  // namespace sixdial::report
