// What the poses of G1 make of each source of uncertainty: asked again and again by the budgets
// (uncertainty_budget.h).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "calibration/sandwich.h"
#include "simulation/rig_quantities.h"
#include "studies/uncertainty_budget.h"

namespace sixdial::studies {

/// What one unit of a source does to a position [mm^2, mean over the poses].
struct Sensitivities {
  /// Of independent errors of the readings, 1 mm x `sd_mm` by dial.
  std::function<double(const Eigen::VectorXd& sd_mm)> of_scatter;
  /// Of the stated quantities of the rig, then of the shapes of each dial's curve, each off by
  /// the standard deviation known before: what two of them do together.
  Eigen::MatrixXd of_known;
};

class BudgetPoses {
 public:
  /// `in` and what it refers to must outlive this object, and this object its sensitivities.
  explicit BudgetPoses(const BudgetInput& in);

  [[nodiscard]] int places() const { return static_cast<int>(J_v_.size()); }
  [[nodiscard]] const std::vector<simulation::RigQuantity>& quantities() const {
    return quantities_;
  }
  /// Any dial measured a position.
  [[nodiscard]] bool by_dials() const;
  [[nodiscard]] Sensitivities measured() const;
  [[nodiscard]] Sensitivities commanded() const;
  /// Mean trace of the position's covariance for that of the parameters.
  [[nodiscard]] double of_parameters(const Eigen::MatrixXd& covariance) const;
  /// Noise and structure that the fit shows, without what the rig file states of the rig.
  [[nodiscard]] double of_fit() const;
  /// Variance of a measured position by the space itself [mm^2, all coordinates].
  [[nodiscard]] double of_space() const;
  [[nodiscard]] double of_space_in_fit(double sd_mm) const;

 private:
  void set_known();

  const BudgetInput& in_;
  std::vector<Eigen::MatrixXd> by_;
  calibration::Sandwich sandwich_;
  std::vector<simulation::RigQuantity> quantities_;
  // Change of the positions for one of each that Sensitivities::of_known has.
  Eigen::MatrixXd known_;
  std::vector<Eigen::VectorXd> joints_;
  std::vector<Eigen::MatrixXd> J_v_;
  Eigen::MatrixXd JJ_;  // mean of J_v' J_v
};

}  // namespace sixdial::studies
