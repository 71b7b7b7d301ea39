#include "studies/diagnosis_result.h"

#include <algorithm>
#include <cmath>

namespace sixdial::studies {

VerdictKind verdict_kind(const DiagnosisResult& result) {
  if (result.unexplained.significant) {
    return result.unexplained.depends_on.empty() ? VerdictKind::kScatter
                                                 : VerdictKind::kUnknown;
  }
  if (result.causes.empty()) return VerdictKind::kNothing;
  const bool tied = std::ranges::any_of(result.causes, [](const FoundCause& cause) {
    return cause.certainty() == Certainty::kTied;
  });
  return tied ? VerdictKind::kTied : VerdictKind::kNamed;
}

double left_out(const DiagnosisResult& result) {
  const auto all = static_cast<double>(result.residuals.good.size());
  const auto out = static_cast<double>(std::ranges::count(result.residuals.good, false));
  return all > 0 ? out / all : 0.0;
}

bool names_an_effect(const DiagnosisResult& result) {
  return !std::ranges::all_of(result.causes, &FoundCause::is_data_fault);
}

const GainRow* gain_row(
    const DiagnosisResult& result, diagnosis::GainModel model, bool network) {
  const auto found = std::ranges::find_if(result.gain, [&](const GainRow& row) {
    return row.model == model && row.network == network;
  });
  return found == result.gain.end() ? nullptr : &*found;
}

const Limit* limit_of(const DiagnosisResult& result, const HypothesisId& id) {
  const auto found = std::ranges::find(result.limits, id, &Limit::id);
  return found == result.limits.end() ? nullptr : &*found;
}

double moved(const diagnosis::ParameterChange& change) {
  return change.extended - change.baseline;
}

double moved_sigma(const diagnosis::ParameterChange& change) {
  return change.baseline_sd > 0.0 ? moved(change) / change.baseline_sd : std::nan("");
}

}  // namespace sixdial::studies
