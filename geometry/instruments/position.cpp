#include "geometry/instruments/position.h"

#include <algorithm>

#include "geometry/rig.h"

namespace sixdial::geometry {
namespace {

constexpr std::string_view kAxes = "xyz";

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &position;
  const int axes = rig.instrument.dimensions;
  if (axes != 2 && axes != 3) {
    return tl::unexpected(std::string("a position has 2 or 3 dimensions"));
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i) {
    result->channels.push_back({std::string(1, kAxes[i]), "mm", rig.instrument.sd_mm});
  }
  return result;
}

void observe(
    const InstrumentModel& instrument, std::span<const double> /*x*/,
    std::span<const double> /*unknowns*/, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  const Eigen::Index axes = instrument.channel_count();
  out.reading = X[0].p.head(axes);
  out.by_frames.setZero(axes, 6 * static_cast<Eigen::Index>(X.size()));
  out.by_frames.leftCols(axes).setIdentity();
  out.by_x.resize(axes, 0);
  out.by_unknowns.resize(axes, 0);
  if (say_shown) out.shows.assign(static_cast<std::size_t>(axes), true);
}

}  // namespace

extern constinit const InstrumentKind position{
    .name = "position",
    .in_words = "position of the tool",
    .of_rig = of_rig,
    .observe = observe,
};

}  // namespace sixdial::geometry
