// A diagnosis in sentences: what was found, where, how big, how sure, what to do, what it
// gains, what could not be judged. Everything is read from the numbers of the document.
#pragma once

#include <string>
#include <string_view>

#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

/// "backlash of joint 2", "scale of dial C", "swapped dials C and D".
[[nodiscard]] std::string cause_in_words(std::string_view cause, std::string_view where);
/// "backlash of joint 2" for a {cause, where}.
[[nodiscard]] std::string named(const Json& cause);

/// "0.0340° ± 0.0010°": two digits of the standard deviation; angles in degrees, shares in %.
/// Not finite sd: three digits of the value.
[[nodiscard]] std::string quantity_in_words(double value, double sd, std::string_view unit);
/// Size of a cause from its estimate: "0.0340° ± 0.0010°", "amplitude 0.041° ± 0.001°",
/// "0.0121 mm ± 0.0004 mm from sample 71 on".
[[nodiscard]] std::string size_in_words(const Json& cause);
/// What can be said of a gross reading: handed over twice, at the edge; empty: nothing.
[[nodiscard]] std::string remark_on_gross(const Json& reading);
/// "0.0123 mm", "2.1 µm" are not mixed: millimetres with four decimals, as the dials show.
[[nodiscard]] std::string millimetres(const Json& value);

/// "verdict" of a document: {kind: named | tied | unknown | scatter | nothing, title, headline,
/// found [], to_do [], trust [], not_judged []}.
[[nodiscard]] Json verdict_in_words(const Json& document);

/// What people read on the terminal: a paragraph, then tables.
[[nodiscard]] std::string diagnosis_text(const Json& document);

}  // namespace sixdial::studies
