// A session's samples as the methods see them: which assembly the robot was in, where an
// instrument or, without one, the dials put the tool, how well that is known.
#pragma once

#include <string_view>
#include <vector>

#include "session/session.h"
#include "simulation/trial.h"

namespace sixdial::session {

/// The samples of one set as trials, in order, except samples marked left_out. A sample whose
/// contacts allow no position becomes a trial without one. Repeats stay trials of their own. A
/// reading counts when it is not bad and the plunger is off both ends of its travel (a free
/// plunger rests at its end stop and shows a valid value near 0). sigma of a reading:
/// reading_sigma_mm(). `set_name` empty: all sets. Trial::sample indexes session.samples;
/// time_s counts from the session's first sample.
[[nodiscard]] std::vector<simulation::Trial> trials_of(
    const Session& session, std::string_view set_name);

/// One sample; `index` is its row in the session, `start` the time that time_s counts from.
[[nodiscard]] simulation::Trial trial_of(
    const geometry::Rig& rig, const Sample& sample, int index = 0,
    std::optional<TimePoint> start = std::nullopt);

/// Whether a plunger at this displacement is pushed in at all and not at its inner end: further
/// than 3 x accuracy + 3 x repeatability from both ends.
[[nodiscard]] bool in_contact(const geometry::Dial& dial, double displacement_mm);

/// Standard deviation of one reading [mm]: repeatability, at least that of rounding to the
/// resolution.
[[nodiscard]] double reading_sigma_mm(const geometry::Dial& dial);

/// The assembly that a sample was taken in: judged by its target, else by its measured
/// position, else by which assembly predicts its readings better, else the rig's.
[[nodiscard]] geometry::Assembly assembly_of(const geometry::Rig& rig, const Sample& sample);

}  // namespace sixdial::session
