#include "geometry/instruments/position.h"

#include <algorithm>

#include "geometry/instruments/places.h"
#include "geometry/rig.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

constexpr std::string_view kAxes = "xyz";

struct Details {
  std::vector<PlaceAt> points;  // beside the tool's own, in the tool's frame
};

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &position;
  const int axes = rig.instrument.dimensions;
  if (axes != 2 && axes != 3) {
    return tl::unexpected(std::string("a position has 2 or 3 dimensions"));
  }
  if (auto fault = fault_of(rig.instrument.tool_points, "a tool point")) {
    return tl::unexpected(*std::move(fault));
  }
  auto details = std::make_shared<Details>();
  const auto add_channels = [&](const std::string& point, double sd_mm) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i) {
      std::string name(1, kAxes[i]);
      if (!point.empty()) name += '_' + point;
      result->channels.push_back({std::move(name), "mm", sd_mm});
    }
  };
  add_channels("", rig.instrument.sd_mm);
  for (const ReferencePoint& point : rig.instrument.tool_points) {
    add_channels(point.name, rig.instrument.sd_mm);
    details->points.push_back(add_place(*result, point, "tool point " + point.name));
  }
  result->details = std::move(details);
  return result;
}

void observe(
    const InstrumentModel& instrument, std::span<const double> x,
    std::span<const double> /*unknowns*/, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  const Eigen::Index axes =
      instrument.channel_count() / (1 + static_cast<Eigen::Index>(is.points.size()));
  clear(instrument, X.size(), say_shown, out);
  out.reading.head(axes) = X[0].p.head(axes);
  out.by_frames.topLeftCorner(axes, axes).setIdentity();
  for (std::size_t k = 0; k < is.points.size(); ++k) {
    const Eigen::Index row = axes * static_cast<Eigen::Index>(k + 1);
    const Eigen::Vector3d lever = X[0].R * is.points[k].at(x);
    out.reading.segment(row, axes) = (X[0].p + lever).head(axes);
    out.by_frames.block(row, 0, axes, axes).setIdentity();
    out.by_frames.block(row, 3, axes, 3) = -skew<double>(lever).topRows(axes);
    if (is.points[k].first >= 0) {
      out.by_x.block(row, is.points[k].first, axes, 3) = X[0].R.topRows(axes);
    }
  }
}

/// Of a point that nobody knows: the mean of where it was seen, in the tool's frame.
void start(
    const InstrumentModel& instrument, std::span<const SeenSample> samples,
    Eigen::VectorXd& x) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  for (std::size_t k = 0; k < is.points.size(); ++k) {
    const int first = is.points[k].first;
    if (first < 0 || std::isfinite(instrument.known_to[first])) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const SeenSample& sample : samples) {
      Eigen::Vector3d seen;
      bool all = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& value = sample.reading[3 * (k + 1) + axis];
        all = all && value.has_value();
        seen[static_cast<Eigen::Index>(axis)] = value.value_or(0.0);
      }
      if (!all) continue;
      sum += sample.X[0].R.transpose() * (seen - sample.X[0].p);
      count += 1.0;
    }
    if (count > 0.0) x.segment<3>(first) = sum / count;
  }
}

}  // namespace

extern constinit const InstrumentKind position{
    .name = "position",
    .in_words = "position of the tool",
    .of_rig = of_rig,
    .observe = observe,
    .sees_tool_only = true,
    .start = start,
};

}  // namespace sixdial::geometry
