// A dial's scale is uneven all along, worn, bent or dirty: r += c(r), a smooth curve of the
// dial's own reading, wider than its maker allows.
#include "simulation/effect.h"
#include "simulation/smooth_function.h"

namespace sixdial::simulation {
namespace {

/// As a finding says its size, and what accuracy_mm allows; what a fit has is in
/// smooth_function.h.
constexpr EffectParameter kParameters[] = {
    {"half_span", "mm", 0.02},
    {"rms", "mm", 0.012},
    {"limit", "mm", 0.006},
};

void bend_after_reading(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  double& reading_mm = scene.reading[static_cast<std::size_t>(place.dial)];
  reading_mm += smooth_value(x, reading_mm);
}

}  // namespace

extern constinit const Effect dial_curve;
constinit const Effect dial_curve{
    .cause = "dial_curve",
    .in_words = "uneven scale of a dial",
    .in_words_with_place = "uneven scale of {place}",
    .places = at_each_dial,
    .parameters = kParameters,
    .needs = kDials,
    .is_curve = true,
    .after_reading = bend_after_reading,
    .size =
        "accuracy_mm allows {=limit:.4f}; the curve is {=rms:.4f} rms, up to {half_span} "
        "either way over the readings that were taken",
    .plot = {Shows::kReading, Against::kReading},
    .twin = "dial_curve",
    .signature =
        "One dial's residual follows a smooth curve over its own reading, wider than "
        "accuracy_mm of the rig file allows. No wave that repeats within the readings, no "
        "scale "
        "and no lean describes it as well.",
    .consequence =
        "None on parts. Positions that are computed from the rig file and use this dial are "
        "off "
        "by as much as its curve; this diagnosis, its gain and a validation by it take the "
        "curve into account, a calibration does not.",
    .advice =
        "Check the dial against gauge blocks over its whole travel and compare with its "
        "certificate; clean it, have it repaired, or replace it; then measure again. If its "
        "maker allows more, enter that as accuracy_mm.",
    .why_not_learned = "",
    .told_apart =
        "A wrong scale is a straight line over the reading, a cyclic error a wave that comes "
        "again at least twice within what was read: where these suffice they are named.",
    .helps = "Readings of that dial all over its travel, while the other dials read anything."};

}  // namespace sixdial::simulation
