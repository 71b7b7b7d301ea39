#include "studies/seen_rig.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/rig_errors.h"
#include "simulation/moved_rig.h"

namespace sixdial::studies {
namespace {

using diagnosis::RigSeen;
using Eigen::MatrixXd;
using simulation::RigQuantity;

bool same(const geometry::DialGeometry& a, const geometry::DialGeometry& b) {
  return a.position_mm == b.position_mm && a.axis == b.axis &&
         a.tip_radius_mm == b.tip_radius_mm;
}

/// Both files say the same of the part that this quantity is of.
bool same_part(const RigQuantity& quantity, const geometry::Rig& a, const geometry::Rig& b) {
  if (quantity.place.dial < 0) return a.cuboid.side_mm == b.cuboid.side_mm;
  const auto d = static_cast<std::size_t>(quantity.place.dial);
  return d < a.dials.size() && d < b.dials.size() &&
         same(a.dials[d].geometry, b.dials[d].geometry);
}

/// By name: whatever else a file states does not matter.
std::vector<RigQuantity> all_quantities(const geometry::Rig& file) {
  std::vector<RigQuantity> quantities = simulation::stated_quantities(file);
  for (RigQuantity& each : simulation::claimed_quantities(file)) {
    quantities.push_back(std::move(each));
  }
  return quantities;
}

/// By how much it is off, in its unit; empty: the table does not say.
std::optional<double> off_of(const RigQuantity& quantity, const std::vector<RigSeen>& seen) {
  const auto found = std::ranges::find(seen, quantity.name, &RigSeen::name);
  if (found == seen.end() || !std::isfinite(found->off)) return std::nullopt;
  return found->off;
}

}  // namespace

std::vector<simulation::ActiveEffect> rig_effects(
    const geometry::Rig& file, const std::optional<std::vector<RigSeen>>& seen) {
  std::vector<simulation::ActiveEffect> effects;
  if (!seen) return effects;
  for (const RigQuantity& each : all_quantities(file)) {
    if (const auto off = off_of(each, *seen)) {
      effects.push_back({each.effect, each.place, {*off}});
    }
  }
  return effects;
}

std::vector<RigSeen> seen_of(const diagnosis::RigFit& fit) {
  std::vector<RigSeen> result;
  for (std::size_t k = 0; k < fit.quantities.size(); ++k) {
    const RigQuantity& each = fit.quantities[k];
    const auto i = static_cast<Eigen::Index>(k);
    result.push_back(
        {.name = each.name,
         .unit = each.unit,
         .off = fit.off[i] * each.sd,
         .sd = std::sqrt(fit.covariance(i, i)) * each.sd,
         .known_sd = each.sd,
         .stated = true});
  }
  return result;
}

geometry::Rig rig_as_seen(
    const geometry::Rig& other, const geometry::Rig& file,
    const std::optional<std::vector<RigSeen>>& seen) {
  if (!seen) return other;
  const std::vector<RigQuantity> quantities = all_quantities(file);
  Eigen::VectorXd off = Eigen::VectorXd::Zero(std::ssize(quantities));
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const auto found = off_of(quantities[k], *seen);
    if (!found || !same_part(quantities[k], other, file)) continue;
    off[static_cast<Eigen::Index>(k)] = *found / quantities[k].sd;
  }
  return simulation::moved_rig(other, quantities, off);
}

geometry::Rig rig_as_seen(
    const geometry::Rig& file, const std::optional<std::vector<RigSeen>>& seen) {
  return rig_as_seen(file, file, seen);
}

MatrixXd root_of_open(const diagnosis::RigFit& fit) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(fit.open);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

calibration::ObservationSpace with_rig_as_seen(
    calibration::ObservationSpace space, std::span<const simulation::Trial> trials,
    const diagnosis::RigFit& fit, const MatrixXd& root) {
  if (space.rig_mm.cols() != std::ssize(fit.quantities)) return space;
  const MatrixXd curves = calibration::curve_columns(
      space, trials, fit.rig, calibration::by_readings(space, trials, fit.rig), fit.ranges);
  MatrixXd columns(space.rows(), space.rig_mm.cols() + curves.cols());
  columns << space.rig_mm, curves;
  space.rig_mm = columns * root;
  return space;
}

calibration::ObservationSpace with_rig_as_seen(
    calibration::ObservationSpace space, std::span<const simulation::Trial> trials,
    const std::optional<diagnosis::RigFit>& fit) {
  if (!fit) return space;
  return with_rig_as_seen(std::move(space), trials, *fit, root_of_open(*fit));
}

}  // namespace sixdial::studies
