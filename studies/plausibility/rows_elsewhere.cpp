// Single rows whose joint values belong to another pose (a digit, a sign, two joints
// exchanged): target and readings agree with each other, and not with them. Such a row accuses
// all its dials.
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/instruments/contact.h"
#include "geometry/tool.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kLeastApart_mm = 5.0;  // from where a nominal robot may be
constexpr double kUsualTimes = 10.0;
constexpr double kMostOfAll = 0.1;  // of the rows; more are no slip
constexpr double kMuchBetter = 0.25;

/// RMS between a sample's readings (or its position) and what the nominal robot at joint values
/// q would show [mm]; empty: nothing to compare, or no such pose.
std::optional<double> misfit_mm(
    const geometry::Rig& rig, const session::Sample& sample, const Eigen::VectorXd& q,
    geometry::Assembly assembly) {
  if (const auto at = session::position_of(sample, rig.dials.size())) {
    const auto nominal = geometry::Tool(rig).position(rig.robot.nominal, q, assembly);
    if (!nominal) return std::nullopt;
    return (*at - *nominal).norm();
  }
  const auto pose = geometry::planar_pose(
      *rig.robot.model, rig.robot.nominal, q, assembly, geometry::cuboid_link(rig));
  const auto reference = geometry::reference_link_angle(rig);
  if (!pose || !reference) return std::nullopt;
  const geometry::CuboidPose cuboid{
      pose->p_WE, geometry::cuboid_angle(rig, *reference, pose->link_rad, 0.0)};
  double sum = 0.0;
  int readings = 0;
  for (std::size_t i = 0; i < rig.dials.size() && i < sample.channels.size(); ++i) {
    const session::ChannelValue& reading = sample.channels[i];
    if (!reading.value || reading.quality == session::Quality::kBad) continue;
    if (!session::in_contact(rig.dials[i], *reading.value)) continue;
    const geometry::DialGeometry& dial = rig.dials[i].geometry;
    const int face = geometry::face_towards(dial, cuboid.gamma_rad);
    const double off =
        *reading.value -
        geometry::contact_on_face(dial, cuboid, rig.cuboid.side_mm, face).displacement_mm;
    sum += off * off;
    ++readings;
  }
  if (readings < 2) return std::nullopt;
  return std::sqrt(sum / readings);
}

}  // namespace

void look_at_rows_elsewhere(Look& look) {
  const geometry::Rig& rig = look.used.rig;
  const geometry::Tool tool(rig);
  if (!tool.has_inverse()) return;
  std::vector<std::size_t> rows;
  std::vector<double> apart_mm;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out || !sample.target_mm) continue;
    const auto at =
        tool.position(rig.robot.nominal, sample.q, session::assembly_of(rig, sample));
    if (!at) continue;
    rows.push_back(i);
    apart_mm.push_back((*at - *sample.target_mm).norm());
  }
  constexpr std::size_t kLeastRows = 6;  // to say what is usual
  if (rows.size() < kLeastRows) return;
  std::vector<double> sorted = apart_mm;
  std::ranges::nth_element(sorted, sorted.begin() + std::ssize(sorted) / 2);
  const double limit_mm = std::max(kLeastApart_mm, kUsualTimes * sorted[sorted.size() / 2]);
  std::vector<std::size_t> elsewhere;
  double largest_mm = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (apart_mm[k] < limit_mm) continue;
    const session::Sample& sample = look.used.samples[rows[k]];
    const auto q = tool.inverse(rig.robot.nominal, *sample.target_mm, rig.robot.working_mode);
    if (!q) continue;
    const auto as_is = misfit_mm(rig, sample, sample.q, session::assembly_of(rig, sample));
    const auto at_target = misfit_mm(
        rig, sample, *q,
        tool.assembly_at(rig.robot.nominal, *q, *sample.target_mm)
            .value_or(rig.robot.assembly));
    if (!at_target || (as_is && *at_target > kMuchBetter * *as_is)) continue;
    elsewhere.push_back(rows[k]);
    largest_mm = std::max(largest_mm, apart_mm[k]);
  }
  if (elsewhere.empty() ||
      static_cast<double>(elsewhere.size()) > kMostOfAll * static_cast<double>(rows.size())) {
    return;
  }
  std::string columns;
  for (const geometry::JointInfo& joint : rig.robot.model->joints) {
    columns += (columns.empty() ? "" : ", ") + joint.name;
  }
  look.tell(
      "row_elsewhere", Severity::kNote, look.rows(elsewhere, columns), {{"apart", largest_mm}});
  for (const std::size_t row : elsewhere) look.used.samples[row].left_out = true;
}

}  // namespace sixdial::studies::plausibility
