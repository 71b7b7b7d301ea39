// Two dials' readings are exchanged: cables or channels mixed up.
#include <utility>

#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

void bend_after_reading(
    std::span<const double>, const Place& place, const Circumstance&, Scene& scene) {
  std::swap(
      scene.reading[static_cast<std::size_t>(place.dial)],
      scene.reading[static_cast<std::size_t>(place.other_dial)]);
}

}  // namespace

extern constinit const Effect dial_swap;
constinit const Effect dial_swap{
    .cause = "dial_swap",
    .in_words = "swapped dials",
    .in_words_with_place = "swapped dials {place}",
    .places = at_each_pair_of_dials,
    .needs = kDials,
    .exchanges_dials = true,
    .after_reading = bend_after_reading,
    .size = "they differ by {=difference_rms:.2f} rms",
    .plot = {Shows::kReading, Against::kSimulatedReading},
    .twin = "dial_swap",
    .signature = "Two dials are off by large amounts of opposite course.",
    .consequence = "Positions are wrong by millimetres.",
    .advice = "Exchange the two connections in the rig file, or the plugs.",
    .why_not_learned = "",
    .told_apart =
        "No other cause is so large; two dials exchange their courses, which no smooth effect "
        "does.",
    .helps = "None needed; any session over more than a few millimetres shows it."};

}  // namespace sixdial::simulation
