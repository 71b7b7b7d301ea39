#include "studies/budget_poses.h"

#include <algorithm>
#include <cmath>

#include "calibration/predicted_position.h"
#include "calibration/reading_errors.h"
#include "calibration/reading_space.h"
#include "calibration/rig_errors.h"
#include "geometry/tool.h"

namespace sixdial::studies {

using calibration::ObservationSpace;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

BudgetPoses::BudgetPoses(const BudgetInput& in)
    : in_(in),
      by_(calibration::by_readings(in.space, in.g1, in.session.rig)),
      sandwich_(calibration::sandwich_of(in.space, in.fit, in.weighting)),
      quantities_(simulation::stated_quantities(in.session.rig)),
      known_(in.space.rows(), 0) {
  set_known();
  const geometry::Tool tool(in.session.rig);
  const Index n = in.session.rig.robot.nominal.size();
  JJ_ = MatrixXd::Zero(n, n);
  std::size_t t = 0;
  for (int i = 0; i < in.space.samples(); ++i) {
    const int sample = in.space.sample[static_cast<std::size_t>(i)];
    while (t < in.g1.size() && in.g1[t].sample != sample) ++t;
    if (t == in.g1.size()) break;
    const auto at = tool.derivative(in.fit.x.head(n), in.g1[t].q, in.g1[t].assembly);
    if (!at) continue;
    JJ_ += at->J_v.transpose() * at->J_v;
    joints_.push_back(in.g1[t].q);
    J_v_.push_back(at->J_v);
  }
  if (!J_v_.empty()) JJ_ /= static_cast<double>(J_v_.size());
}

bool BudgetPoses::by_dials() const {
  return std::ranges::any_of(by_, [](const MatrixXd& each) { return !each.isZero(0.0); });
}

Sensitivities BudgetPoses::measured() const {
  return {
      .of_scatter =
          [this](const VectorXd& sd_mm) {
            double sum = 0.0;
            for (const MatrixXd& by : by_) sum += (by * sd_mm.asDiagonal()).squaredNorm();
            return sum / std::max<double>(1.0, static_cast<double>(by_.size()));
          },
      .of_known = known_.transpose() * known_ / std::max(1, in_.space.samples())};
}

Sensitivities BudgetPoses::commanded() const {
  MatrixXd moved = MatrixXd::Zero(JJ_.rows(), known_.cols());
  for (int i = 0; i < in_.space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    moved += sandwich_.AW[k].topRows(JJ_.rows()) *
             known_.middleRows(in_.space.first_row[k], in_.space.rows(i));
  }
  return {
      .of_scatter =
          [this](const VectorXd& sd_mm) {
            return of_parameters(calibration::scatter_covariance(sandwich_, by_, sd_mm));
          },
      .of_known = moved.transpose() * JJ_ * moved};
}

double BudgetPoses::of_parameters(const MatrixXd& covariance) const {
  const Index n = JJ_.rows();
  return (JJ_ * covariance.topLeftCorner(n, n)).trace();
}

double BudgetPoses::of_fit() const {
  ObservationSpace exact = in_.space;
  exact.rig_mm.resize(exact.rows(), 0);
  const calibration::PredictedPosition predicted(
      exact, in_.fit, in_.weighting, in_.noise.spread_mm, in_.structure);
  double sum = 0.0;
  for (std::size_t i = 0; i < J_v_.size(); ++i) {
    sum += predicted.covariance(joints_[i], J_v_[i]).trace();
  }
  return sum / std::max(1, places());
}

double BudgetPoses::of_space() const {
  const bool poses = calibration::shows_position(in_.space);  // turns may stand behind
  Eigen::VectorXd sigma_mm = in_.space.sigma_mm;
  for (Index row = 0; poses && row < sigma_mm.size(); ++row) {
    const int channel = in_.space.channel[static_cast<std::size_t>(row)];
    if (channel >= in_.space.position_axes) sigma_mm[row] = 0.0;
  }
  return sigma_mm.squaredNorm() / std::max(1, in_.space.samples());
}
double BudgetPoses::of_space_in_fit(double sd_mm) const {
  return sd_mm * sd_mm * of_parameters(sandwich_.noise);
}

void BudgetPoses::set_known() {
  const geometry::Rig& rig = in_.session.rig;
  MatrixXd of_rig = calibration::rig_errors(in_.space, in_.g1, rig);
  if (of_rig.cols() == 0) of_rig.resize(in_.space.rows(), 0);
  const MatrixXd curves = calibration::curve_columns(
      in_.space, in_.g1, rig, by_,
      in_.rig != nullptr ? in_.rig->ranges
                         : calibration::reading_ranges(in_.g1, rig.dials.size()));
  known_.resize(in_.space.rows(), of_rig.cols() + curves.cols());
  known_ << of_rig, curves;
}

}  // namespace sixdial::studies
