// Positions so far from all others that no unit and no frame explains them: a slip, or what an
// instrument writes for "none". One such value lets every fit fail.
#include <algorithm>
#include <cmath>

#include "session/sample_layout.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kBeyond = 1000.0;  // middle distances from the middle of all
constexpr double kMostOfAll = 0.1;  // of the rows
constexpr std::size_t kFewest = 6;

}  // namespace

void look_for_far_positions(Look& look) {
  const std::size_t dials = look.used.rig.dials.size();
  std::vector<std::size_t> rows;
  std::vector<geometry::Position> at;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    const auto p = session::position_of(sample, dials);
    if (sample.left_out || !p) continue;
    rows.push_back(i);
    at.push_back(*p);
  }
  if (rows.size() < kFewest) return;
  geometry::Position middle(at.front().size());
  for (Eigen::Index axis = 0; axis < middle.size(); ++axis) {
    std::vector<double> values;
    for (const geometry::Position& p : at) values.push_back(p[axis]);
    middle[axis] = geometry::median_of(std::move(values));
  }
  std::vector<double> distance;
  distance.reserve(at.size());
  for (const geometry::Position& p : at) {
    distance.push_back((p - middle).cwiseAbs().maxCoeff());  // no square: it may overflow
  }
  const double usual = geometry::median_of(distance);
  std::vector<std::size_t> far;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (usual > 0.0 && distance[k] > kBeyond * usual) far.push_back(rows[k]);
  }
  if (far.empty() ||
      static_cast<double>(far.size()) > kMostOfAll * static_cast<double>(rows.size())) {
    return;
  }
  const auto first = std::ranges::find(rows, far.front()) - rows.begin();
  look.tell(
      "far_position", Severity::kNote, look.rows(far),
      {{"apart", distance[static_cast<std::size_t>(first)]}, {"usual", usual}});
  for (const std::size_t row : far) {
    session::set_position(look.used.samples[row], dials, std::nullopt);
  }
}

}  // namespace sixdial::studies::plausibility
