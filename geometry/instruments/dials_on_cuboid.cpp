#include "geometry/instruments/dials_on_cuboid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "geometry/rig.h"
#include "geometry/units.h"

namespace sixdial::geometry {
namespace {

constexpr double kClampKnown_rad = 1.0 * kRadPerDeg;  // a clamp is set by eye
constexpr double kClampChange_rad = 1.0 / 60.0;

struct Details {
  std::vector<DialGeometry> dials;
  double side_mm = 0.0;
  std::optional<std::size_t> link;  // frame that the cuboid turns with; empty: held freely
  double reference_rad = 0.0;       // that link's angle at the reference pose
};

double reading_sd_mm(const Dial& dial) {
  return std::hypot(dial.repeatability_mm, dial.resolution_mm / std::sqrt(12.0));
}

/// Angle of a frame's x axis in the plane of W.
double heading_rad(const Pose<double>& X) { return std::atan2(X.R(1, 0), X.R(0, 0)); }

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  auto details = std::make_shared<Details>();
  details->dials = rig.dial_geometries();
  details->side_mm = rig.cuboid.side_mm;
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &dials_on_cuboid;
  for (const Dial& dial : rig.dials) {
    result->channels.push_back({dial.id, "mm", reading_sd_mm(dial)});
  }
  ParameterInfo clamp{"clamp", "", "deg", kDegPerRad, "rad", kClampChange_rad};
  clamp.meaning = "clamp angle of the cuboid";
  result->parameters = {std::move(clamp)};
  result->nominal = Eigen::VectorXd::Zero(1);
  result->known_to = Eigen::VectorXd::Constant(1, kClampKnown_rad);
  if (rig.cuboid.mount == Mount::kFree) {
    result->unknowns = {{"gamma", "rad"}};
  } else {
    const auto frame = cuboid_link(rig);
    if (!frame) {
      const auto* name = rig.cuboid.mount == Mount::kDistal1 ? "distal1" : "distal2";
      return tl::unexpected("the robot has no link '" + std::string(name) + "' for the cuboid");
    }
    const auto reference = reference_link_angle(rig);
    if (!reference) {
      return tl::unexpected(
          "reference_pose_mm of the cuboid cannot be used: " +
          std::string(describe(reference.error())));
    }
    details->link = static_cast<std::size_t>(*frame);
    details->reference_rad = *reference;
  }
  result->details = std::move(details);
  return result;
}

/// gamma: given, or the link's turn since the reference (within +-pi) plus the clamp angle, or,
/// held freely, the clamp angle alone.
double gamma_of(
    const Details& is, std::span<const double> x, std::span<const double> unknowns,
    std::span<const Pose<double>> X) {
  if (!unknowns.empty()) return unknowns[0];
  if (!is.link) return x[0];
  const double turned = heading_rad(X[*is.link]) - is.reference_rad;
  return std::remainder(turned, 2 * std::numbers::pi) + x[0];
}

void observe(
    const InstrumentModel& instrument, std::span<const double> x,
    std::span<const double> unknowns, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  const auto& is = *static_cast<const Details*>(instrument.details.get());
  const CuboidPose cuboid{X[0].p.head<2>(), gamma_of(is, x, unknowns, X)};
  out.gamma_rad = cuboid.gamma_rad;
  const Eigen::Index count = instrument.channel_count();
  out.reading.resize(count);
  out.by_frames.setZero(count, 6 * static_cast<Eigen::Index>(X.size()));
  out.by_x.setZero(count, 1);
  out.by_unknowns.resize(count, 1);
  if (say_shown) out.shows.resize(is.dials.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const DialGeometry& dial = is.dials[static_cast<std::size_t>(i)];
    const int face = face_towards(dial, cuboid.gamma_rad);
    const Contact contact = contact_on_face(dial, cuboid, is.side_mm, face);
    out.reading[i] = contact.displacement_mm;
    out.by_frames.row(i).head<2>() = contact.J.head<2>();
    out.by_unknowns(i, 0) = contact.J[2];
    if (is.link) {  // gamma follows the link even where a sample's own gamma was given
      out.by_frames(i, 6 * static_cast<Eigen::Index>(*is.link) + 5) = contact.J[2];
      out.by_x(i, 0) = contact.J[2];
    } else if (unknowns.empty()) {
      out.by_x(i, 0) = contact.J[2];
    }
    if (say_shown) {
      out.shows[static_cast<std::size_t>(i)] = touch(dial, cuboid, is.side_mm).has_value();
    }
  }
}

}  // namespace

extern constinit const InstrumentKind dials_on_cuboid{
    .name = "dials_on_cuboid",
    .in_words = "dial indicators on a cuboid",
    .of_rig = of_rig,
    .observe = observe,
};

}  // namespace sixdial::geometry
