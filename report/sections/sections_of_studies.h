// The report's sections on what the studies found, one source file each.
#pragma once

#include <string>
#include <vector>

#include "report/document.h"
#include "session/session.h"
#include "studies/compare.h"
#include "studies/diagnosis_result.h"
#include "studies/json.h"

namespace sixdial::report {

/// The report's sections: uncertainty with its map and both spaces side by side (`precision`
/// may be null), what the data cannot tell, gross errors.
[[nodiscard]] std::vector<Section> assessment_sections(
    const Json& assessment, const Json& precision, const Json& gross_errors);

/// The report's section with Table 6 of all methods and what each identified.
[[nodiscard]] std::vector<Section> comparison_sections(const studies::ComparisonResult& result);

/// The report's section: size, effective parameters, sizes that were offered, membership
/// functions. `anfis`: {"x": network, "y": network}.
[[nodiscard]] std::vector<Section> anfis_sections(const Json& anfis);

/// The report's sections: causes with their signatures, what is left, gain, parameters, what
/// could not be tested, limits.
[[nodiscard]] std::vector<Section> diagnosis_sections(const studies::DiagnosisResult& result);

/// A page of the diagnosis alone, as HTML.
[[nodiscard]] std::string diagnosis_page(
    const studies::DiagnosisResult& result, const session::Session& session,
    const std::string& operator_name);

}  // namespace sixdial::report
