// Single rows whose joint values are written in degrees: everything else of such a row is
// right, and without this all its dials would be accused.
#include <algorithm>
#include <cmath>

#include "geometry/units.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kMostOfAll = 0.2;     // of the rows; more are no slip
constexpr double kBeyond_rad = 0.35;   // outside of the others' range, in radians
constexpr double kLeastOutside = 3.0;  // times that range away, as it was read

struct Range {
  double low = 0.0, high = 0.0;
  [[nodiscard]] bool holds(double value, double beyond) const {
    return value > low - beyond && value < high + beyond;
  }
};

/// The middle nine tenths of a joint's values: slips are in neither end.
Range usual_range(const session::Session& session, Eigen::Index joint) {
  std::vector<double> values;
  for (const session::Sample& sample : session.samples) values.push_back(sample.q[joint]);
  std::ranges::sort(values);
  const auto cut = static_cast<std::size_t>(0.1 * static_cast<double>(values.size()));
  return {values[cut], values[values.size() - 1 - cut]};
}

}  // namespace

void look_at_angles(Look& look) {
  const auto& joints = look.used.rig.robot.model->joints;
  const std::size_t samples = look.used.samples.size();
  constexpr std::size_t kLeastRows = 6;  // to say what is usual
  if (samples < kLeastRows) return;
  std::vector<Range> usual_of_joint;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    usual_of_joint.push_back(usual_range(look.used, static_cast<Eigen::Index>(j)));
  }
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < samples; ++i) {
    const session::Sample& sample = look.used.samples[i];
    bool outside = false;
    bool fits_in_degrees = true;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].unit() != "rad") continue;
      const auto k = static_cast<Eigen::Index>(j);
      const Range& usual = usual_of_joint[j];
      const double width = usual.high - usual.low + kBeyond_rad;
      const bool here = !usual.holds(sample.q[k], kLeastOutside * width);
      const bool as_degrees = usual.holds(sample.q[k] / geometry::kDegPerRad, width);
      outside = outside || here;
      // The other joint may well be in radians, as it should.
      fits_in_degrees =
          fits_in_degrees && (as_degrees || (!here && usual.holds(sample.q[k], width)));
    }
    if (outside && fits_in_degrees) rows.push_back(i);
  }
  if (rows.empty() ||
      static_cast<double>(rows.size()) > kMostOfAll * static_cast<double>(samples)) {
    return;
  }
  std::string columns;
  for (const geometry::JointInfo& joint : joints) {
    columns += (columns.empty() ? "" : ", ") + joint.name;
  }
  look.tell(
      "row_in_degrees", Severity::kNote, look.rows(rows, columns),
      {{"value", look.used.samples[rows.front()].q[0]}});
  for (const std::size_t row : rows) look.used.samples[row].left_out = true;
}

}  // namespace sixdial::studies::plausibility
