#include "calibration/rig_errors.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/instruments/contact.h"
#include "simulation/circumstances.h"
#include "simulation/extended_model.h"
#include "simulation/rig_quantities.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::RigQuantity;
using simulation::Trial;

/// d(readings of these dials)/d(x, y, gamma) where the dials saw the cuboid.
MatrixXd by_pose(const Trial& trial, const geometry::Rig& rig, const std::vector<int>& dials) {
  const geometry::CuboidPose pose{trial.position_mm->head<2>(), *trial.gamma_rad};
  MatrixXd J(std::ssize(dials), 3);
  for (std::size_t k = 0; k < dials.size(); ++k) {
    const geometry::DialGeometry& dial = rig.dials[static_cast<std::size_t>(dials[k])].geometry;
    const int face = geometry::face_towards(dial, pose.gamma_rad);
    J.row(static_cast<Index>(k)) =
        geometry::contact_on_face(dial, pose, rig.cuboid.side_mm, face).J;
  }
  return J;
}

/// The nominal robot with the cuboid clamped as the dials saw it: a degree of turn is what
/// places across the axes act by.
simulation::ModelVector as_clamped(
    const simulation::ForwardModel& model, const simulation::ExtendedModel& plain,
    std::span<const Trial> trials, std::span<const simulation::Circumstance> circumstances) {
  simulation::ModelVector at = model.nominal();
  const Index robot = model.robot_parameter_count();
  if (at.size() == robot) return at;  // it turns freely: seen sample by sample
  double sum = 0.0;
  int count = 0;
  simulation::Scene scene;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    if (!trials[t].gamma_rad || !plain.run(at, trials[t], circumstances[t], scene)) continue;
    sum += *trials[t].gamma_rad - scene.gamma_rad;
    ++count;
  }
  if (count > 0) at[robot] += sum / count;
  return at;
}

/// d(rows)/d(readings of all dials) of one sample.
MatrixXd by_readings_of(
    const ObservationSpace& space, int sample, const Trial& trial, const geometry::Rig& rig) {
  const Index rows = space.rows(sample);
  const int first = space.first_row[static_cast<std::size_t>(sample)];
  MatrixXd result = MatrixXd::Zero(rows, std::ssize(rig.dials));
  if (space.position_axes > 0) {
    const std::vector<int>& three = trial.position_channels;
    if (three.size() != 3 || !trial.position_mm || !trial.gamma_rad || rows != 2) {
      return result;  // an instrument's: no dial stands there
    }
    const MatrixXd J = by_pose(trial, rig, three);
    result(Eigen::all, three) = J.fullPivLu().inverse().topRows(rows);
    return result;
  }
  std::vector<int> dials;
  for (Index row = 0; row < rows; ++row) {
    dials.push_back(space.channel[static_cast<std::size_t>(first + row)]);
    result(row, dials.back()) = 1.0;
  }
  if (space.unknowns_per_sample > 0 && trial.position_mm && trial.gamma_rad) {
    // The cuboid turns freely: what a turn takes over is no row's any more.
    const VectorXd g = by_pose(trial, rig, dials).col(2).normalized();
    result -= (g * (g.transpose() * result)).eval();
  }
  return result;
}

double if_finite(double value) { return std::isfinite(value) ? value : 0.0; }

/// The trial of each sample of the space; null: it is not among them.
std::vector<const Trial*> trials_of_space(
    const ObservationSpace& space, std::span<const Trial> trials) {
  std::vector<const Trial*> result(static_cast<std::size_t>(space.samples()), nullptr);
  std::size_t t = 0;
  for (std::size_t k = 0; k < result.size(); ++k) {
    while (t < trials.size() && trials[t].sample != space.sample[k]) ++t;
    if (t == trials.size()) break;
    result[k] = &trials[t];
  }
  return result;
}

}  // namespace

MatrixXd rig_errors(
    const ObservationSpace& space, std::span<const Trial> trials, const geometry::Rig& rig) {
  const std::vector<RigQuantity> quantities = simulation::stated_quantities(rig);
  if (quantities.empty() || rig.dials.empty()) return {};
  geometry::Rig with_dials = rig;
  with_dials.instrument.kind = "dials_on_cuboid";
  const simulation::ForwardModel model(with_dials);
  const simulation::ExtendedModel plain(model, {});
  const auto circumstances = simulation::circumstances_of(model, model.nominal(), trials);
  const simulation::ModelVector at = as_clamped(model, plain, trials, circumstances);
  const auto dials = static_cast<Index>(rig.dials.size());
  const auto count = static_cast<Index>(quantities.size());
  MatrixXd result = MatrixXd::Zero(space.rows(), count);
  simulation::Scene scene;
  const std::vector<const Trial*> trial = trials_of_space(space, trials);
  for (int i = 0; i < space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (trial[k] == nullptr) break;
    const auto t = static_cast<std::size_t>(trial[k] - trials.data());
    const auto seen = [&](const simulation::ActiveEffect* off) -> VectorXd {
      if (!plain.run(at, trials[t], circumstances[t], scene, off)) {
        return VectorXd::Constant(dials, std::nan(""));
      }
      return Eigen::Map<const VectorXd>(scene.reading.data(), dials);
    };
    const VectorXd there = seen(nullptr);
    MatrixXd readings(dials, count);
    for (Index j = 0; j < count; ++j) {
      const RigQuantity& quantity = quantities[static_cast<std::size_t>(j)];
      constexpr double kStep = 1e-3;  // standard deviations: small against what bends
      const simulation::ActiveEffect off{
          quantity.effect, quantity.place, {kStep * quantity.sd}};
      readings.col(j) = (seen(&off) - there) / kStep;
    }
    // Dials that do not touch there read nothing, and are in no row.
    result.middleRows(space.first_row[k], space.rows(i)) =
        by_readings_of(space, i, *trial[k], rig) * readings.unaryExpr(&if_finite);
  }
  return result.unaryExpr(&if_finite);
}

std::vector<MatrixXd> by_readings(
    const ObservationSpace& space, std::span<const Trial> trials, const geometry::Rig& rig) {
  std::vector<MatrixXd> result;
  const std::vector<const Trial*> trial = trials_of_space(space, trials);
  for (int i = 0; i < space.samples(); ++i) {
    const Trial* at = trial[static_cast<std::size_t>(i)];
    result.push_back(
        at != nullptr ? by_readings_of(space, i, *at, rig)
                      : MatrixXd::Zero(space.rows(i), std::ssize(rig.dials)));
    result.back() = result.back().unaryExpr(&if_finite);
  }
  return result;
}

MatrixXd moved_by_rig(const ObservationSpace& space, const Sandwich& sandwich) {
  MatrixXd moved = MatrixXd::Zero(sandwich.noise.rows(), space.rig_mm.cols());
  if (moved.cols() == 0) return moved;
  for (int i = 0; i < space.samples(); ++i) {
    const int first = space.first_row[static_cast<std::size_t>(i)];
    moved += sandwich.AW[static_cast<std::size_t>(i)] *
             space.rig_mm.middleRows(first, space.rows(i));
  }
  return moved;
}

MatrixXd rig_covariance(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting) {
  const MatrixXd moved = moved_by_rig(space, sandwich_of(space, fit, weighting));
  return moved * moved.transpose();
}

}  // namespace sixdial::calibration
