// What the smooth functions of an explanation are: what the makers of the dials allow, a dial
// whose scale is uneven by more than that, a joint that errs by its own angle, or something
// that has no name.
#pragma once

#include "diagnosis/explanation.h"

namespace sixdial::diagnosis {

/// Sorts `found.unknown` into background, dial_curves, joint_curves, unknown and unknown_rivals
/// of `result`. A function of one dial's own reading is a curve of the dial if its span is for
/// sure beyond accuracy_mm; within it, it stays without a name. A function of one joint's own
/// value, that enters there, is that joint's curve.
void tell_smooth_apart(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, NamedCauses& result);

/// The curve of a joint that these smooth functions of an explanation are, by number.
[[nodiscard]] JointCurve curve_of_joint(
    const Readings& readings, const Explanation& found, const simulation::Place& place,
    const std::vector<std::size_t>& group);

/// Half of its span is more than two of its standard deviations.
[[nodiscard]] bool is_for_sure(const JointCurve& curve);

/// A curve of the same size drawn against another joint's value is what flexibility alone
/// gains: the name has to do clearly better, or is tied with that. `without`: a fit without the
/// curve.
void hold_against_sham(
    const Readings& readings, const JointFit& without, const NamingSettings& settings,
    JointCurve& curve);

/// What stands at a dial beside a smooth function of the same dial's reading may be a part of
/// it: tied with it.
void doubt_beside_curves(
    const Readings& readings, const Explanation& found, NamedCauses& names);

}  // namespace sixdial::diagnosis
