// The pieces of which sentences about a diagnosis are made: names of causes, sizes, figures.
// The sentences: diagnosis_verdict.h. What the terminal shows: diagnosis_text.h.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// "backlash of joint 2", "scale of dial C", "swapped dials C and D".
[[nodiscard]] std::string named(const studies::HypothesisId& id);
[[nodiscard]] std::string named(const studies::FoundCause& cause);
[[nodiscard]] std::string named(const studies::Rival& rival);
/// An effect that is a curve of any form.
[[nodiscard]] bool is_curve(const studies::HypothesisId& id);
/// "the rig's own geometry": what is no effect of the catalogue, at no place; else empty.
[[nodiscard]] std::string kind_in_words(studies::CauseKind kind);

/// What can be said of a cause wherever it is found; views of constant text.
struct CauseTexts {
  std::string_view signature{};    // how it shows
  std::string_view consequence{};  // what it does to parts
  std::string_view advice{};
  std::string_view why_not_learned{};  // by a network on joint angles; may be empty
};
[[nodiscard]] CauseTexts texts_of(const studies::FoundCause& cause);

/// "0.0340° ± 0.0020°": expanded uncertainty, k = 2, with two digits; angles in degrees, shares
/// in %. Not finite sd: three digits of the value.
[[nodiscard]] std::string quantity_in_words(double value, double sd, std::string_view unit);
/// Size of a cause from its estimate: "0.0340° ± 0.0020° (k = 2)",
/// "0.0121 mm ± 0.0008 mm from sample 71 on (k = 2)".
[[nodiscard]] std::string size_in_words(const studies::FoundCause& cause);
/// What can be said of a gross reading: handed over twice, at the edge; empty: nothing.
[[nodiscard]] std::string remark_on_gross(const studies::GrossReading& reading);
/// "0.0123 mm": millimetres with four decimals, as the dials show; "-" if not known.
[[nodiscard]] std::string millimetres(double value_mm);
/// "0.0020 mm, measured: 50 degrees of freedom from repeats".
[[nodiscard]] std::string noise_in_words(const studies::DiagnosisResult& result);

/// "robot alone", "with the causes + ANFIS", "without backlash of joint 2".
[[nodiscard]] std::string gain_row_in_words(const studies::GainRow& row);
/// "calibrated", "extended + ANFIS", "without joint_backlash@joint2": its name in documents.
[[nodiscard]] std::string gain_row_name(const studies::GainRow& row);

/// "the value of joint 2", "the reading of dial E", "the side that joint 2 arrives from".
[[nodiscard]] std::string covariate_in_words(const std::string& covariate);
/// "x, y and time". Of many that do about as well, the likeliest three: "x, y, time or one of
/// 12 other quantities".
[[nodiscard]] std::string covariates_in_words(
    const std::vector<std::string>& covariates, std::string_view last = "and");

struct NotTestableWords {
  std::string reason{};
  std::string needs{};  // what would be needed
};
[[nodiscard]] NotTestableWords not_testable_in_words(
    const studies::DiagnosisResult& result, const studies::NotTestable& each);
/// The same without figures, so that places with the same reason have the same words.
[[nodiscard]] std::string why_not_testable(diagnosis::WhyNotTestable why);
/// A limit that is so many times the size to expect that no rig has it: the session cannot show
/// the cause.
inline constexpr std::string_view kAtNoPlausibleSize = "at no plausible size";
[[nodiscard]] bool is_beyond_plausible(const studies::Limit& limit, double size);
/// Why a limit has no size; empty where it has both.
[[nodiscard]] std::string reason_without_limit(const studies::Limit& limit);

/// "a, b and c".
[[nodiscard]] std::string list_of(
    const std::vector<std::string>& items, std::string_view last = "and");
/// Begins with a capital letter.
[[nodiscard]] std::string capital(std::string text);

}  // namespace sixdial::report
