// What the weight behind a joint does beyond the sag that equal masses give (Effect: compliance
// under weight). Nobody records the masses of an arm's links, and they are never equal: the
// torque of gravity is linear in the masses and in where their centres lie, and whatever these
// explain needs no name of its own.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "diagnosis/stages.h"
#include "diagnosis/unknown_search.h"
#include "simulation/weight.h"

namespace sixdial::diagnosis {
namespace {

/// d(reading)/d(each mass, and each centre of mass) of a compliance of one rad/m at the joint,
/// readings x any; without those that nothing moves with.
Eigen::MatrixXd columns_of_masses(
    const Readings& readings, const Eigen::VectorXd& by_angle, int joint,
    const std::vector<Eigen::MatrixXd>& moments) {
  Eigen::MatrixXd columns(readings.count(), 0);
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const auto trial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].trial);
    const Eigen::MatrixXd& here = moments[trial];
    if (here.size() == 0 || !std::isfinite(by_angle[row])) continue;
    if (columns.cols() == 0) columns = Eigen::MatrixXd::Zero(readings.count(), here.cols());
    columns.row(row) = by_angle[row] * here.row(joint);
  }
  std::vector<Eigen::Index> moving;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    if (columns.col(k).squaredNorm() > 0.0) moving.push_back(k);
  }
  return columns(Eigen::all, moving);
}

/// Masses may differ from their mean by as much as that is.
double size_of(const simulation::ActiveEffect& weight) {
  double largest = 0.0;
  for (const double each : weight.x) largest = std::max(largest, std::abs(each));
  return largest;
}

bool is_of_weight(const simulation::ActiveEffect& each) {
  return each.effect == simulation::compliance_under_weight();
}

}  // namespace

bool gives_under_weight(const JointFit& fit) {
  return std::ranges::any_of(fit.effects, is_of_weight);
}

void along_masses(
    UnknownSearch& search, const Readings& readings, const JointFit& fit,
    const simulation::ExtendedModel& extended, const Eigen::VectorXd& simulated_mm) {
  if (!gives_under_weight(fit)) return;
  const simulation::ForwardModel& model = readings.model();
  simulation::Weight moment(model.robot(), fit.model.head(model.robot_parameter_count()));
  std::vector<Eigen::MatrixXd> moments;
  for (const simulation::Trial& trial : readings.trials()) {
    moments.push_back(moment.of_each_mass(trial.q, trial.assembly));
  }
  for (const simulation::ActiveEffect& each : fit.effects) {
    if (!is_of_weight(each)) continue;
    const int joint = each.place.joint;
    const Eigen::VectorXd by_angle =
        stage_columns(readings, fit.model, extended, simulated_mm, Stage::kJointAngle, joint)
            .col(0);
    search.masses(
        joint, each.place.name, columns_of_masses(readings, by_angle, joint, moments),
        size_of(each));
  }
}

}  // namespace sixdial::diagnosis
