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

constexpr double kMostOfAll = 0.1;  // of the rows; more are no slip
constexpr double kBeyond = 10.0;    // robust standard deviations from what is usual
constexpr double kLeastBeyond_mm = 0.5;

/// What is usual of a figure, and from where on it is not.
struct Usual {
  double middle = 0.0, limit = 0.0;
};
Usual usual_of(std::vector<double> values) {
  constexpr double kSdOverMad = 1.4826;
  const auto median = [](std::vector<double>& of) {
    std::ranges::nth_element(of, of.begin() + std::ssize(of) / 2);
    return of[of.size() / 2];
  };
  const double middle = median(values);
  for (double& each : values) each = std::abs(each - middle);
  const double sd = kSdOverMad * median(values);
  return {middle, middle + std::max(kBeyond * sd, kLeastBeyond_mm)};
}

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
  std::vector<double> apart_mm, left_mm;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out || !sample.target_mm) continue;
    const geometry::Assembly assembly = session::assembly_of(rig, sample);
    const auto at = tool.position(rig.robot.nominal, sample.q, assembly);
    const auto left = misfit_mm(rig, sample, sample.q, assembly);
    if (!at || !left) continue;
    rows.push_back(i);
    apart_mm.push_back((*at - *sample.target_mm).norm());
    left_mm.push_back(*left);
  }
  constexpr std::size_t kLeastRows = 6;  // to say what is usual
  if (rows.size() < kLeastRows) return;
  const Usual apart = usual_of(apart_mm);
  const Usual left = usual_of(left_mm);
  std::vector<std::size_t> elsewhere;
  double largest_mm = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (apart_mm[k] < apart.limit || left_mm[k] < left.limit) continue;
    const session::Sample& sample = look.used.samples[rows[k]];
    const auto q = tool.inverse(rig.robot.nominal, *sample.target_mm, rig.robot.working_mode);
    if (!q) continue;
    const auto assembly = tool.assembly_at(rig.robot.nominal, *q, *sample.target_mm);
    const auto at_target = misfit_mm(rig, sample, *q, assembly.value_or(rig.robot.assembly));
    // At the target the row is like all others.
    if (!at_target || *at_target > left.limit) continue;
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
