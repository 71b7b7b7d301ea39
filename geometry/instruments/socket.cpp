#include "geometry/instruments/socket.h"

#include <cmath>

#include "geometry/instruments/places.h"
#include "geometry/rig.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

struct Details {
  std::vector<PlaceAt> sockets;
};

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  const auto& sockets = rig.instrument.sockets;
  if (auto fault = fault_of(sockets, "a socket")) return tl::unexpected(*std::move(fault));
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &socket;
  auto details = std::make_shared<Details>();
  for (const ReferencePoint& each : sockets) {
    for (const char* const axis : {"x", "y", "z"}) {
      result->channels.push_back(
          {"socket_" + each.name + '_' + axis, "mm", rig.instrument.sd_mm});
    }
    details->sockets.push_back(add_place(*result, each, "socket " + each.name));
  }
  for (const SocketDistance& known : rig.instrument.socket_distances) {
    KnownDistance distance{.mm = known.mm, .sd_mm = known.sd_mm};
    for (std::size_t i = 0; i < sockets.size(); ++i) {
      if (sockets[i].name == known.first) distance.first = details->sockets[i].first;
      if (sockets[i].name == known.second) distance.second = details->sockets[i].first;
    }
    if (distance.first < 0 || distance.second < 0) {
      return tl::unexpected(
          "a distance of sockets '" + known.first + "' and '" + known.second +
          "' needs both as [[socket]] without an exact place");
    }
    if (!(known.mm > 0.0) || !(known.sd_mm > 0.0)) {
      return tl::unexpected(
          "the distance of sockets '" + known.first + "' and '" + known.second +
          "' and its deviation must be positive");
    }
    result->distances.push_back(distance);
  }
  result->details = std::move(details);
  return result;
}

void observe(
    const InstrumentModel& instrument, std::span<const double> x,
    std::span<const double> /*unknowns*/, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  clear(instrument, X.size(), say_shown, out);
  for (std::size_t i = 0; i < is.sockets.size(); ++i) {
    const auto row = static_cast<Index>(3 * i);
    out.reading.segment<3>(row) = X[0].p - is.sockets[i].at(x);
    out.by_frames.block<3, 3>(row, 0).setIdentity();
    if (is.sockets[i].first >= 0) {
      out.by_x.block<3, 3>(row, is.sockets[i].first) = -Eigen::Matrix3d::Identity();
    }
  }
}

/// Where the nominal robot believes each socket, in the mean.
void start(
    const InstrumentModel& instrument, std::span<const SeenSample> samples,
    Eigen::VectorXd& x) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  for (std::size_t i = 0; i < is.sockets.size(); ++i) {
    const int first = is.sockets[i].first;
    if (first < 0 || std::isfinite(instrument.known_to[first])) continue;
    Vector3d sum = Vector3d::Zero();
    double count = 0.0;
    for (const SeenSample& sample : samples) {
      if (!sample.reading[3 * i]) continue;
      sum += sample.X[0].p;
      count += 1.0;
    }
    if (count > 0.0) x.segment<3>(first) = sum / count;
  }
}

}  // namespace

extern constinit const InstrumentKind socket{
    .name = "socket",
    .in_words = "a ball in sockets",
    .of_rig = of_rig,
    .observe = observe,
    .sees_tool_only = true,
    .start = start,
};

}  // namespace sixdial::geometry
