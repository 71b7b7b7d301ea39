// How the rig file has the cuboid turned against how the readings have it: a reference pose (or
// a mount) that is not that of the rig turns it at all poses by the same angle, and good
// readings look like gross errors.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "geometry/instruments/contact.h"
#include "geometry/tool.h"
#include "geometry/units.h"
#include "session/trials.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kLeastTurn_deg = 3.0;  // a clamp is set by eye to better than that
constexpr double kMostTurn_deg = 180.0;
constexpr double kStep_deg = 0.5;
constexpr double kBetter = 0.6;         // what is left over what was before: told
constexpr double kMuchBetter = 0.25;    // and so much that it cannot be left
constexpr double kWellLeft_mm = 3.0;    // of a nominal robot that was never calibrated
constexpr std::size_t kMostPoses = 40;  // are enough to see an angle

struct Seen {
  geometry::CuboidPose pose;  // of the nominal robot, as the rig file turns the cuboid
  std::vector<std::pair<std::size_t, double>> readings;  // dial, displacement
};

std::vector<Seen> poses_of(const geometry::Rig& rig, const session::Session& session) {
  std::vector<Seen> poses;
  const auto reference = geometry::reference_link_angle(rig);
  if (!reference) return poses;
  const std::size_t every = std::max<std::size_t>(1, session.samples.size() / kMostPoses);
  for (std::size_t i = 0; i < session.samples.size(); i += every) {
    const session::Sample& sample = session.samples[i];
    if (sample.left_out) continue;
    const auto pose = geometry::planar_pose(
        *rig.robot.model, rig.robot.nominal, sample.q, session::assembly_of(rig, sample),
        geometry::cuboid_link(rig));
    if (!pose) continue;
    Seen seen{{pose->p_WE, geometry::cuboid_angle(rig, *reference, pose->link_rad, 0.0)}, {}};
    for (std::size_t dial = 0; dial < rig.dials.size() && dial < sample.channels.size();
         ++dial) {
      const session::ChannelValue& reading = sample.channels[dial];
      if (!reading.value || reading.quality == session::Quality::kBad) continue;
      if (session::in_contact(rig.dials[dial], *reading.value)) {
        seen.readings.emplace_back(dial, *reading.value);
      }
    }
    constexpr std::size_t kLeastReadings = 3;  // place and angle
    if (seen.readings.size() >= kLeastReadings) poses.push_back(std::move(seen));
  }
  return poses;
}

/// Median over the poses of the RMS between readings and what the turned cuboid would show
/// [mm].
double misfit_mm(const geometry::Rig& rig, const std::vector<Seen>& poses, double turn_rad) {
  std::vector<double> left;
  for (const Seen& seen : poses) {
    geometry::CuboidPose turned = seen.pose;
    turned.gamma_rad += turn_rad;
    double sum = 0.0;
    for (const auto& [dial, displacement_mm] : seen.readings) {
      const geometry::DialGeometry& at = rig.dials[dial].geometry;
      const int face = geometry::face_towards(at, turned.gamma_rad);
      const double off =
          displacement_mm -
          geometry::contact_on_face(at, turned, rig.cuboid.side_mm, face).displacement_mm;
      sum += off * off;
    }
    left.push_back(std::sqrt(sum / static_cast<double>(seen.readings.size())));
  }
  std::ranges::nth_element(left, left.begin() + std::ssize(left) / 2);
  return left[left.size() / 2];
}

struct Turn {
  double deg = 0.0, left_mm = 0.0;
};

Turn best_turn(const geometry::Rig& rig, const std::vector<Seen>& poses) {
  Turn best{0.0, misfit_mm(rig, poses, 0.0)};
  for (double deg = -kMostTurn_deg; deg < kMostTurn_deg; deg += kStep_deg) {
    const double left_mm = misfit_mm(rig, poses, deg / geometry::kDegPerRad);
    // A cuboid is square: of four turns that fit alike the smallest is meant.
    const bool alike = left_mm < 1.0001 * best.left_mm && std::abs(deg) < std::abs(best.deg);
    if (left_mm < 0.9999 * best.left_mm || alike) best = {deg, left_mm};
  }
  return best;
}

}  // namespace

void look_at_cuboid_angle(Look& look) {
  const geometry::Rig& rig = look.used.rig;
  if (rig.dials.empty()) return;
  const std::vector<Seen> poses = poses_of(rig, look.used);
  constexpr std::size_t kLeastPoses = 3;
  if (poses.size() < kLeastPoses) return;
  const double before_mm = misfit_mm(rig, poses, 0.0);
  const Turn turn = best_turn(rig, poses);
  if (turn.left_mm < kWellLeft_mm && turn.left_mm < kBetter * before_mm &&
      std::abs(turn.deg) >= kLeastTurn_deg) {
    // A small turn does no harm to a fit: every pose says how the cuboid stands. A large one
    // takes one face for another.
    const bool harmless = turn.left_mm > kMuchBetter * before_mm;
    look.tell(
        "reference_pose", harmless ? Severity::kNote : Severity::kWrong,
        Look::rig_key("[cuboid] reference_pose_mm"),
        {{"turn", turn.deg},
         {"before", before_mm},
         {"after", turn.left_mm},
         {"x", rig.cuboid.reference_pose_mm.x()},
         {"y", rig.cuboid.reference_pose_mm.y()}});
    return;
  }
  for (const geometry::Mount mount :
       {geometry::Mount::kDistal1, geometry::Mount::kDistal2, geometry::Mount::kFree}) {
    if (mount == rig.cuboid.mount) continue;
    geometry::Rig other = rig;
    other.cuboid.mount = mount;
    const Turn with = best_turn(other, poses_of(other, look.used));
    if (with.left_mm > kWellLeft_mm || with.left_mm > kBetter * turn.left_mm) continue;
    look.tell(
        "mount", Severity::kWrong, Look::rig_key("[cuboid] mount"),
        {{"before", before_mm}, {"after", with.left_mm}});
    return;
  }
}

}  // namespace sixdial::studies::plausibility
