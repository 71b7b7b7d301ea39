#include "geometry/instruments/distance.h"

#include <Eigen/QR>
#include <cmath>

#include "geometry/instruments/places.h"
#include "geometry/rig.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

struct Details {
  std::vector<PlaceAt> anchors;
};

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  const auto& anchors = rig.instrument.anchors;
  if (anchors.empty()) {
    return tl::unexpected(std::string("a distance needs an [[anchor]]"));
  }
  if (auto fault = fault_of(anchors, "an anchor")) return tl::unexpected(*std::move(fault));
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &distance;
  auto details = std::make_shared<Details>();
  for (const ReferencePoint& anchor : anchors) {
    result->channels.push_back({"distance_" + anchor.name, "mm", rig.instrument.sd_mm});
    details->anchors.push_back(add_place(*result, anchor, "anchor " + anchor.name));
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
  for (std::size_t i = 0; i < is.anchors.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const Vector3d along = X[0].p - is.anchors[i].at(x);
    out.reading[row] = along.norm();
    // Of a wire without length nobody knows the direction.
    const Vector3d unit = along.norm() > 0.0 ? Vector3d(along.normalized()) : Vector3d::Zero();
    out.by_frames.row(row).head<3>() = unit.transpose();
    if (is.anchors[i].first >= 0) {
      out.by_x.block<1, 3>(row, is.anchors[i].first) = -unit.transpose();
    }
  }
}

/// Of an anchor that nobody knows: |p|^2 - d^2 = 2 p.a - |a|^2, linear in a and |a|^2.
void start(
    const InstrumentModel& instrument, std::span<const SeenSample> samples,
    Eigen::VectorXd& x) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  for (std::size_t i = 0; i < is.anchors.size(); ++i) {
    const int first = is.anchors[i].first;
    if (first < 0 || std::isfinite(instrument.known_to[first])) continue;
    std::vector<Eigen::RowVector4d> rows;
    std::vector<double> right;
    Vector3d middle = Vector3d::Zero();
    for (const SeenSample& sample : samples) middle += sample.X[0].p;
    middle /= static_cast<double>(samples.size());
    for (const SeenSample& sample : samples) {
      if (!sample.reading[i]) continue;
      const Vector3d p = sample.X[0].p - middle;
      rows.push_back({2 * p.x(), 2 * p.y(), 2 * p.z(), -1.0});
      right.push_back(p.squaredNorm() - *sample.reading[i] * *sample.reading[i]);
    }
    if (rows.size() < 4) continue;
    Eigen::MatrixXd A(std::ssize(rows), 4);
    for (Index k = 0; k < A.rows(); ++k) A.row(k) = rows[static_cast<std::size_t>(k)];
    const Eigen::Vector4d found = A.completeOrthogonalDecomposition().solve(
        Eigen::Map<const Eigen::VectorXd>(right.data(), A.rows()));
    x.segment<3>(first) = middle + found.head<3>();
  }
}

}  // namespace

extern constinit const InstrumentKind distance{
    .name = "distance",
    .in_words = "distance from anchors",
    .of_rig = of_rig,
    .observe = observe,
    .sees_tool_only = true,
    .start = start,
};

}  // namespace sixdial::geometry
