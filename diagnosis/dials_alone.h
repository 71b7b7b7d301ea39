// Names held against what dials do by themselves. Within its maker's limit each dial has a
// smooth error curve and, for example, a hysteresis (UnknownKind::kDialCurves, kDialHabits of
// unknown.h: the background of an explanation). While names were added one by one, the
// background only got what the names had left. So each name is asked again: the session is
// fitted without it, with a background that is chosen from scratch. Where that is likelier, the
// name goes.
#pragma once

#include "diagnosis/explanation.h"

namespace sixdial::diagnosis {

/// Leaves out the names that the dials' background makes needless, and exchanges those that
/// have a better rival beside it.
void hold_against_dials(
    const Search& search, const NamingSettings& settings, Explanation& found);

/// `less` is `found` without one name. The first background term (of the dials, unequal masses)
/// that `less` took in to make up for it; null: none.
[[nodiscard]] const UnknownCandidate* stands_in(
    const Explanation& found, const Explanation& less);

}  // namespace sixdial::diagnosis
