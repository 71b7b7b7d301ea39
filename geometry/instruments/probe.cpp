#include "geometry/instruments/probe.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>

#include "geometry/instruments/places.h"
#include "geometry/rig.h"
#include "geometry/robots/parameter_row.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kLever_mm = 100.0;  // a tilt of one over this is a millimetre at its edge

struct Side {
  Surface surface{};
  PlaceAt centre{};     // of a sphere
  int first = -1;       // of a plane's parameters: height, tilt towards u, towards w
  Vector3d u{1, 0, 0};  // axes in the plane
  Vector3d w{0, 1, 0};
};
struct Details {
  std::vector<Side> sides;
};

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  const auto& surfaces = rig.instrument.surfaces;
  if (surfaces.empty()) return tl::unexpected(std::string("a probe needs a [[surface]]"));
  std::vector<ReferencePoint> places;
  for (const Surface& each : surfaces) places.push_back(each.place);
  if (auto fault = fault_of(places, "a surface")) return tl::unexpected(*std::move(fault));
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &probe;
  auto details = std::make_shared<Details>();
  for (const Surface& surface : surfaces) {
    const std::string& name = surface.place.name;
    result->channels.push_back({"probe_" + name, "mm", rig.instrument.sd_mm});
    Side side{.surface = surface};
    if (surface.radius_mm) {
      side.centre = add_place(*result, surface.place, "centre of " + name);
    } else {
      if (!(std::abs(surface.normal.norm() - 1.0) < 1e-6)) {
        return tl::unexpected("the normal of surface '" + name + "' is no unit vector");
      }
      side.u = surface.normal.unitOrthogonal();
      side.w = surface.normal.cross(side.u);
      if (!surface.place.at_mm || surface.place.sd_mm > 0.0) {
        const double sd = surface.place.at_mm ? surface.place.sd_mm : HUGE_VAL;
        side.first = add_parameter(
            *result, length_row(name + "_height", "height of surface " + name), 0.0, sd);
        for (const char* const tilt : {"_tilt1", "_tilt2"}) {
          add_parameter(
              *result, angle_row(name + tilt, kLever_mm, "tilt of surface " + name), 0.0,
              sd / kLever_mm);
        }
      }
    }
    details->sides.push_back(std::move(side));
  }
  result->details = std::move(details);
  return result;
}

/// Small tilts: the normal is n + tilt1 u + tilt2 w, of unit length to second order of them.
void observe_plane(
    const Side& side, std::span<const double> x, const Vector3d& p, Index row,
    Observation& out) {
  const Vector3d from = p - side.surface.place.at_mm.value_or(Vector3d::Zero());
  Vector3d normal = side.surface.normal;
  if (side.first >= 0) {
    const auto i = static_cast<std::size_t>(side.first);
    normal += x[i + 1] * side.u + x[i + 2] * side.w;
    out.reading[row] = -x[i];
    out.by_x(row, side.first) = -1.0;
    out.by_x(row, side.first + 1) = side.u.dot(from);
    out.by_x(row, side.first + 2) = side.w.dot(from);
  }
  out.reading[row] += normal.dot(from);
  out.by_frames.row(row).head<3>() = normal.transpose();
}

void observe(
    const InstrumentModel& instrument, std::span<const double> x,
    std::span<const double> /*unknowns*/, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  clear(instrument, X.size(), say_shown, out);
  for (std::size_t i = 0; i < is.sides.size(); ++i) {
    const Side& side = is.sides[i];
    const auto row = static_cast<Index>(i);
    if (!side.surface.radius_mm) {
      observe_plane(side, x, X[0].p, row, out);
      continue;
    }
    const Vector3d along = X[0].p - side.centre.at(x);
    const double away = along.norm();
    out.reading[row] = away - *side.surface.radius_mm;
    const Vector3d unit = away > 0.0 ? Vector3d(along / away) : Vector3d::Zero();
    out.by_frames.row(row).head<3>() = unit.transpose();
    if (side.centre.first >= 0) {
      out.by_x.block<1, 3>(row, side.centre.first) = -unit.transpose();
    }
  }
}

/// Of a plane that nobody knows: the one through the touches; of a sphere: their centre by the
/// linear equations of their distances.
void start(
    const InstrumentModel& instrument, std::span<const SeenSample> samples,
    Eigen::VectorXd& x) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  for (std::size_t i = 0; i < is.sides.size(); ++i) {
    const Side& side = is.sides[i];
    const int first = side.surface.radius_mm ? side.centre.first : side.first;
    if (first < 0 || std::isfinite(instrument.known_to[first])) continue;
    std::vector<Vector3d> touches;
    std::vector<double> reading;
    for (const SeenSample& sample : samples) {
      if (!sample.reading[i]) continue;
      touches.push_back(sample.X[0].p);
      reading.push_back(*sample.reading[i]);
    }
    const auto n = std::ssize(touches);
    if (n < 4) continue;
    const bool plane = !side.surface.radius_mm;
    Eigen::MatrixXd A(n, plane ? 3 : 4);
    Eigen::VectorXd b(n);
    for (Index k = 0; k < n; ++k) {
      const Vector3d& p = touches[static_cast<std::size_t>(k)];
      const double seen = reading[static_cast<std::size_t>(k)];
      if (plane) {
        const Vector3d from = p - side.surface.place.at_mm.value_or(Vector3d::Zero());
        A.row(k) << 1.0, -side.u.dot(from), -side.w.dot(from);
        b[k] = side.surface.normal.dot(from) - seen;
      } else {
        const double away = seen + *side.surface.radius_mm;
        A.row(k) << 2 * p.x(), 2 * p.y(), 2 * p.z(), -1.0;
        b[k] = p.squaredNorm() - away * away;
      }
    }
    x.segment<3>(first) = A.completeOrthogonalDecomposition().solve(b).head<3>();
  }
}

}  // namespace

extern constinit const InstrumentKind probe{
    .name = "probe",
    .in_words = "contact with a surface",
    .of_rig = of_rig,
    .observe = observe,
    .sees_tool_only = true,
    .start = start,
};

}  // namespace sixdial::geometry
