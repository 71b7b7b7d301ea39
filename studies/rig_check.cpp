#include "studies/rig_check.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/readings.h"
#include "geometry/instruments/contact.h"
#include "geometry/tool.h"
#include "geometry/units.h"
#include "studies/error.h"
#include "studies/measurable_poses.h"
#include "studies/next_plan.h"

namespace sixdial::studies {
namespace {

using diagnosis::PosePoint;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The readings that the nominal robot would show at these poses; `which`: of the poses.
std::vector<simulation::Trial> trials_at(
    const simulation::ForwardModel& model, const std::vector<PosePoint>& poses,
    std::vector<std::size_t>& which) {
  const geometry::Rig& rig = model.rig();
  const simulation::ExtendedModel plain(model, {});
  simulation::Circumstance sample;
  sample.approach.setZero(model.robot().joint_count());
  sample.previous_mm.assign(rig.dials.size(), std::nan(""));
  sample.plunger_direction.assign(rig.dials.size(), 0.0);
  simulation::Scene scene;
  std::vector<simulation::Trial> result;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    simulation::Trial trial;
    trial.sample = trial.point = static_cast<int>(i);
    trial.q = poses[i].q_rad;
    trial.assembly = poses[i].assembly;
    trial.approach.assign(poses[i].approach.begin(), poses[i].approach.end());
    if (!plain.run(model.nominal(), trial, sample, scene)) continue;
    trial.position_mm = scene.p_WE.head<2>();
    trial.gamma_rad = scene.gamma_rad;
    trial.reading.resize(rig.dials.size());
    for (std::size_t d = 0; d < rig.dials.size(); ++d) {
      const auto seen = geometry::touch(
          rig.dials[d].geometry, {scene.p_WE.head<2>(), scene.gamma_rad}, rig.cuboid.side_mm);
      if (seen) trial.reading[d] = scene.reading[d];
    }
    result.push_back(std::move(trial));
    which.push_back(i);
  }
  return result;
}

/// What is unknown: the robot (known to ten times what is plausible, so that the readings
/// decide) and the rig (known to its standard deviations), in units of these.
class Knowledge {
 public:
  Knowledge(const diagnosis::Readings& readings, Index rig) : rig_(rig) {
    const simulation::ForwardModel& model = readings.model();
    robot_ = static_cast<Index>(model.parameters().size());
    scale_.resize(robot_);
    for (Index k = 0; k < robot_; ++k) {
      constexpr double kNotKnown = 10.0;
      scale_[k] = kNotKnown * model.parameters()[static_cast<std::size_t>(k)].change;
    }
    C_.resize(readings.count(), robot_ + rig_);
    C_ << readings.jacobian(model.nominal()) * scale_.asDiagonal(),
        readings.rig_noise_mm() * readings.nuisance().leftCols(rig_);
    for (Index row = 0; row < C_.rows(); ++row) {
      C_.row(row) /= readings.relative_noise()[row] * readings.rig_noise_mm();
      if (!C_.row(row).allFinite()) C_.row(row).setZero();
    }
    P_.setIdentity(robot_ + rig_, robot_ + rig_);
  }

  /// By how much the rig's variance would fall, all quantities together, in their units.
  [[nodiscard]] double gain_of(Index first, Index rows) const {
    const MatrixXd CP = C_.middleRows(first, rows) * P_;
    return solved(first, rows, CP).rightCols(rig_).squaredNorm();
  }
  void measure(Index first, Index rows) {
    const MatrixXd CP = C_.middleRows(first, rows) * P_;
    const MatrixXd half = solved(first, rows, CP);
    P_ -= half.transpose() * half;
  }
  /// Nothing about the rig is in doubt any more.
  void believe_the_rig() {
    P_.rightCols(rig_).setZero();
    P_.bottomRows(rig_).setZero();
  }
  /// Share of its standard deviation that is left of quantity k.
  [[nodiscard]] double left(Index k) const {
    return std::sqrt(std::max(0.0, P_(robot_ + k, robot_ + k)));
  }
  [[nodiscard]] double left() const { return std::sqrt(P_.diagonal().tail(rig_).mean()); }
  /// Of the robot's parameters, in their own units.
  [[nodiscard]] MatrixXd robot_covariance() const {
    return scale_.asDiagonal() * P_.topLeftCorner(robot_, robot_) * scale_.asDiagonal();
  }

 private:
  /// L^-1 C P, with L L' = 1 + C P C'.
  [[nodiscard]] MatrixXd solved(Index first, Index rows, const MatrixXd& CP) const {
    MatrixXd S = CP * C_.middleRows(first, rows).transpose();
    S.diagonal().array() += 1.0;
    return Eigen::LLT<MatrixXd>(S).matrixL().solve(CP);
  }

  Index robot_ = 0, rig_ = 0;
  VectorXd scale_;
  MatrixXd C_;  // readings in units of their noise
  MatrixXd P_;
};

/// Standard deviation of the tool's position, mean over the poses that can be measured.
double position_sd_mm(
    const geometry::Rig& rig, const MatrixXd& covariance,
    const std::vector<simulation::Trial>& trials) {
  const geometry::Tool tool(rig);
  const Index n = rig.robot.nominal.size();
  double sum = 0.0;
  int count = 0;
  for (const simulation::Trial& trial : trials) {
    const auto at = tool.derivative(rig.robot.nominal, trial.q, trial.assembly);
    if (!at) continue;
    const double variance =
        (at->J_v * covariance.topLeftCorner(n, n) * at->J_v.transpose()).trace();
    sum += std::sqrt(std::max(0.0, variance));
    ++count;
  }
  return count > 0 ? sum / count : std::nan("");
}

/// Plans this long, up to the one that is asked for.
std::vector<int> stage_lengths(int points) {
  std::vector<int> result;
  for (int length = 6; length < points; length *= 2) result.push_back(length);
  result.push_back(points);
  return result;
}

[[noreturn]] void refuse_rig(const std::string& message, const std::string& advice) {
  throw StudyError(StudyErrorCode::kBadData, message, {}, advice);
}

}  // namespace

RigCheck rig_check(const geometry::Rig& rig, const RigCheckRequest& request) {
  if (rig.dials.empty()) {
    refuse_rig(
        "this rig has no dials, so that there is no rig of dials to check",
        "An instrument's own frame is found with the robot: sixdial calibrate.");
  }
  geometry::Rig with_dials = rig;
  with_dials.instrument.kind = "dials_on_cuboid";
  const simulation::ForwardModel model(with_dials);
  const std::vector<geometry::WorkingMode> modes =
      request.modes.empty() ? std::vector{rig.robot.working_mode} : request.modes;
  const auto poses = measurable_poses(with_dials, modes, request.rectangle);
  std::vector<std::size_t> which;
  const auto trials = trials_at(model, poses, which);
  if (trials.empty()) {
    refuse_rig(
        "no pose can be measured in these working modes",
        "Try sixdial plan rig-check with another --rectangle or --mode.");
  }
  constexpr double kAsAWorkshop = 1.0;
  const diagnosis::Readings readings =
      diagnosis::Readings(model, trials).allowing_rig(kAsAWorkshop);
  const auto quantities = readings.rig_quantities();
  Knowledge knowledge(readings, std::ssize(quantities));
  Knowledge believed = knowledge;
  believed.believe_the_rig();

  RigCheck result;
  RigCheckFigures& figures = result.figures;
  const std::vector<int> lengths = stage_lengths(request.points);
  std::vector<char> taken(trials.size(), 0);
  while (std::ssize(result.plan.points) < request.points) {
    double most = -1.0;
    std::size_t best = trials.size();
    for (std::size_t t = 0; t < trials.size(); ++t) {
      const Index first = readings.first_row(t);
      const Index rows = readings.first_row(t + 1) - first;
      if (taken[t] || rows == 0) continue;
      const double gain = knowledge.gain_of(first, rows);
      if (gain <= most * (1 + 1e-12)) continue;
      most = gain;
      best = t;
    }
    if (best == trials.size()) break;
    taken[best] = 1;
    const Index first = readings.first_row(best);
    const Index rows = readings.first_row(best + 1) - first;
    knowledge.measure(first, rows);
    believed.measure(first, rows);
    const PosePoint& pose = poses[which[best]];
    result.plan.points.push_back(
        {"G1", 0, 0, pose.target_mm, pose.q_rad, {pose.approach.begin(), pose.approach.end()}});
    const auto points = static_cast<int>(result.plan.points.size());
    if (std::ranges::find(lengths, points) != lengths.end()) {
      figures.stages.push_back(
          {.points = points,
           .left = knowledge.left(),
           .position_mm = position_sd_mm(rig, knowledge.robot_covariance(), trials)});
    }
  }
  figures.points = static_cast<int>(result.plan.points.size());
  figures.exact_rig_mm = position_sd_mm(rig, believed.robot_covariance(), trials);
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const simulation::RigQuantity& each = quantities[k];
    const auto [unit, factor] = geometry::shown_unit(each.unit);
    figures.quantities.push_back(
        {.name = each.name,
         .unit = std::string(unit),
         .stated = each.stated,
         .sd = each.sd * factor,
         .left = knowledge.left(static_cast<Index>(k))});
  }
  order_by_branch(rig, result.plan, 0);
  return result;
}

}  // namespace sixdial::studies
