// Parts of a document of whatever schema: without its long lists, as `--json` and result.get
// give it, and its settings one by one.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "report/documents/json.h"

namespace sixdial::report {

/// Without points, convergence, traces, networks and the curves of a diagnosis.
[[nodiscard]] Json document_summary(const Json& document);

/// Every leaf by its dotted name, "anfis.epochs", with its value as text.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> settings_rows(
    const Json& settings);

}  // namespace sixdial::report
