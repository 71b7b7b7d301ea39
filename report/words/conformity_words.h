// What the comparison with a tolerance came to, in words (studies/conformity.h).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "studies/conformity.h"

namespace sixdial::report {

/// "accepted", "rejected", "undecided": in documents.
[[nodiscard]] std::string_view decision_name(studies::Decision decision);
[[nodiscard]] std::optional<studies::Decision> decision_from(std::string_view name);
/// "within tolerance", "outside tolerance", "tolerance not decided", "no tolerance stated".
[[nodiscard]] std::string conformity_title(const std::optional<studies::Conformity>& judged);
/// One or two sentences with tolerance, error and U; without a tolerance: how to state one.
[[nodiscard]] std::string conformity_in_words(const std::optional<studies::Conformity>& judged);

}  // namespace sixdial::report
