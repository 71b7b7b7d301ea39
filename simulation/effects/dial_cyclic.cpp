// A periodic error of a dial's scale: a sin(2 pi r / p) + b cos(2 pi r / p).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"a", "mm", 4e-3},
    {"b", "mm", 4e-3},
    {"period", "mm", 5.0},
};

// Frequencies between two waves over what the dial read and the finest that 100 readings can
// hold apart. What does not come again within the readings is not seen to be periodic: one
// wave, with a scale and a shift beside it, describes nearly any smooth curve.
std::vector<double> periods(
    const geometry::Rig& rig, std::span<const Circumstance> samples, const Place& place) {
  const auto dial = static_cast<std::size_t>(place.dial);
  const double travel_mm = rig.dials[dial].geometry.travel_mm;
  constexpr double kShortest_mm = 0.8;
  constexpr double kFewestWaves = 2.0;
  double low_mm = travel_mm;
  double high_mm = 0.0;
  for (const Circumstance& each : samples) {
    const double reading_mm = each.previous_mm[dial];
    if (!std::isfinite(reading_mm)) continue;
    low_mm = std::min(low_mm, reading_mm);
    high_mm = std::max(high_mm, reading_mm);
  }
  const double longest_mm =
      std::clamp((high_mm - low_mm) / kFewestWaves, kShortest_mm, travel_mm);
  const double step = 1.0 / (3.0 * travel_mm);
  std::vector<double> result;
  for (double frequency = 1.0 / longest_mm; frequency <= 1.0 / kShortest_mm;
       frequency += step) {
    result.push_back(1.0 / frequency);
  }
  return result;
}

// Turns the phase at mid travel by about a milliradian.
double small_change(double period_mm) { return 1e-3 * period_mm * period_mm / 150.0; }

void bend_after_reading(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  double& reading_mm = scene.reading[static_cast<std::size_t>(place.dial)];
  const double phase = 2 * std::numbers::pi * reading_mm / x[2];
  reading_mm += x[0] * std::sin(phase) + x[1] * std::cos(phase);
}

}  // namespace

extern constinit const Effect dial_cyclic;
constinit const Effect dial_cyclic{
    .cause = "dial_cyclic",
    .in_words = "cyclic error of a dial",
    .in_words_with_place = "cyclic error of {place}",
    .places = at_each_dial,
    .parameters = kParameters,
    .needs = kDials,
    .searched = periods,
    .searched_change = small_change,
    .after_reading = bend_after_reading,
    .size = "amplitude {a,b}, period {=period}",
    .plot = {Shows::kReading, Against::kReading},
    .twin = "dial_cyclic",
    .signature = "One dial's residual is a wave over its own reading.",
    .consequence = "None on parts; positions that use this dial carry a ripple.",
    .advice =
        "Check the dial's scale against gauge blocks at steps smaller than the period; replace "
        "it or enter the wave.",
    .why_not_learned = "",
    .told_apart =
        "A wrong scale is a straight line over the reading, this is a wave; hysteresis has "
        "two levels at every reading.",
    .helps =
        "Readings spread over many periods of the scale, not a grid whose step is a multiple "
        "of it."};

}  // namespace sixdial::simulation
