// A diagnosis on the terminal: a paragraph, then tables.
#pragma once

#include <string>

#include "studies/diagnosis_result.h"

namespace sixdial::report {

[[nodiscard]] std::string diagnosis_text(const studies::DiagnosisResult& result);

}  // namespace sixdial::report
