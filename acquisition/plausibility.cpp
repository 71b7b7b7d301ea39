#include "acquisition/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tool.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using session::Quality;

void lower(Reading& reading, Quality quality, std::string_view why, std::string detail) {
  reading.quality = quality;
  reading.reason = why;
  reading.detail = std::move(detail);
}

}  // namespace

Plausibility::Plausibility(const geometry::Rig& rig, double limit_mm)
    : rig_(rig), limit_mm_(limit_mm) {
  // What another instrument should show rests on where the robot stands, which nobody knows
  // before the first calibration.
  if (!rig.on_cuboid() || rig.cuboid.mount == geometry::Mount::kFree) return;
  if (const auto angle = geometry::reference_link_angle(rig)) reference_angle_rad_ = *angle;
}

std::vector<ExpectedDial> Plausibility::expected_at(
    const Eigen::VectorXd& q, std::optional<geometry::Assembly> assembly) const {
  std::vector<ExpectedDial> expected(rig_.dials.size());
  if (!reference_angle_rad_) return expected;
  const auto pose = geometry::planar_pose(
      *rig_.robot.model, rig_.robot.nominal, q, assembly.value_or(rig_.robot.assembly),
      geometry::cuboid_link(rig_));
  if (!pose) return expected;
  const geometry::CuboidPose cuboid{
      pose->p_WE, geometry::cuboid_angle(rig_, *reference_angle_rad_, pose->link_rad, 0.0)};
  const double half_mm = rig_.cuboid.side_mm / 2;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const geometry::DialGeometry& dial = rig_.dials[i].geometry;
    const auto touch = geometry::touch(dial, cuboid, rig_.cuboid.side_mm);
    if (!touch && touch.error() == geometry::ContactTrouble::kAlongFace) continue;
    const geometry::Contact contact = geometry::contact_on_face(
        dial, cuboid, rig_.cuboid.side_mm, geometry::face_towards(dial, cuboid.gamma_rad));
    const double beyond_edge_mm = std::abs(contact.along_mm) - half_mm;
    if (beyond_edge_mm > limit_mm_) {
      expected[i].off_face = true;
    } else if (beyond_edge_mm < -limit_mm_) {
      expected[i].displacement_mm = contact.displacement_mm;
    }
  }
  return expected;
}

void Plausibility::judge(
    std::span<Reading> readings, std::span<const ExpectedDial> expected) const {
  std::vector<std::size_t> far_off;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    Reading& reading = readings[i];
    if (reading.quality == Quality::kBad) continue;
    const std::optional<double>& there = expected[i].displacement_mm;
    if (!reading.value_mm) {
      if (there && *there > limit_mm_) {
        lower(
            reading, Quality::kUncertain, reading.reason,
            fmt::format("{:.1f} mm are expected here", *there));
      }
      continue;
    }
    if (expected[i].off_face) {
      lower(
          reading, Quality::kUncertain, session::reason::kImplausible,
          "the tip should miss the cuboid here, but it touches something");
    } else if (there && std::abs(*reading.value_mm - *there) > limit_mm_) {
      lower(
          reading, Quality::kUncertain, session::reason::kImplausible,
          fmt::format(
              "{:.3f} mm where the nominal robot gives {:.1f}", *reading.value_mm, *there));
      far_off.push_back(i);
    }
  }
  for (const std::size_t i : far_off) {
    for (const std::size_t j : far_off) {
      if (i == j) continue;
      if (std::abs(*readings[i].value_mm - *expected[j].displacement_mm) < limit_mm_ &&
          std::abs(*readings[j].value_mm - *expected[i].displacement_mm) < limit_mm_) {
        readings[i].detail +=
            fmt::format("; it would fit dial {}: are the two swapped?", rig_.dials[j].id);
      }
    }
  }
}

void Plausibility::judge_frozen(
    std::span<Reading> readings, std::span<const ExpectedDial> expected,
    std::span<const Reading> before, std::span<const ExpectedDial> expected_before) {
  const std::size_t count = std::min(readings.size(), before.size());
  for (std::size_t i = 0; i < count; ++i) {
    Reading& reading = readings[i];
    if (!reading.value_mm || !before[i].value_mm || reading.quality == Quality::kBad) continue;
    if (!expected[i].displacement_mm || !expected_before[i].displacement_mm) continue;
    const double change_mm =
        std::abs(*expected[i].displacement_mm - *expected_before[i].displacement_mm);
    if (change_mm > kFrozenChange_mm && *reading.value_mm == *before[i].value_mm) {
      lower(
          reading, Quality::kBad, session::reason::kFrozen,
          fmt::format(
              "{:.3f} mm as at the point before, although {:.1f} mm of change are expected",
              *reading.value_mm, change_mm));
    }
  }
}

}  // namespace sixdial::acquisition
