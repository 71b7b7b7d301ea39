// Calibration while the points come in: an extended Kalman filter takes each sample as it
// arrives, and is linearised anew over what it has, because the first estimates are millimetres
// off and a filter that never looks back believes too much. At each moment it says where the
// robot's parameters are, how well they are known, and so how well the tool's position will be.
//
// Only kinematic uncertainty is predicted: what no parameter can explain shows in variance_
// factor(), by which the measurement noise is taken larger than the dials' own.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "calibration/ekf.h"
#include "calibration/workspace.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

struct OnlineSettings {
  /// What is known of each parameter before a sample, in times of what its kind says
  /// (ParameterInfo::known_to).
  double times_known = 1.0;
  /// Standard deviation of an axis where a trial carries no covariance.
  double noise_mm = 0.003;
  /// A sample further off than this many times what the filter expects is set aside, once it
  /// has `trust_after` samples.
  double gate = 8.0;
  int trust_after = 20;
  /// Where variance_factor() is above this, a sample without which it would be a tenth is set
  /// aside too, however early it came.
  double suspicious_factor = 25.0;
};

struct OnlineSample {
  Eigen::VectorXd innovation_mm;  // measured - predicted before it was taken in
  double times_usual = 0.0;       // its length against the standard deviation expected
  bool set_aside = false;
};

class OnlineEstimator {
 public:
  OnlineEstimator(
      geometry::Tool tool, Eigen::VectorXd nominal, const OnlineSettings& settings = {});

  /// Takes a sample in; one of the same set, point and repeat takes the place of the earlier.
  /// Empty: it has no position, or neither the estimate nor the nominal robot reaches its pose.
  /// `shared`: change of the position [mm] for one standard deviation of each thing that puts
  /// all positions off by one law (rig_errors.h), axes x things, the same things each time.
  std::optional<OnlineSample> add(
      const simulation::Trial& trial, const Eigen::MatrixXd& shared = {});

  [[nodiscard]] const geometry::Tool& tool() const { return tool_; }
  [[nodiscard]] const Eigen::VectorXd& v() const { return v_; }
  /// Covariance of v by noise alone, as the residuals show it.
  [[nodiscard]] const Eigen::MatrixXd& P() const { return P_; }
  /// What the samples share gives v besides, which no number of them averages out; zero where
  /// nothing was said of it.
  [[nodiscard]] Eigen::MatrixXd shared_covariance() const;
  [[nodiscard]] bool has_shared() const { return shared_pull_.size() > 0; }
  /// Of v, both together.
  [[nodiscard]] Eigen::MatrixXd covariance() const { return P_ + shared_covariance(); }
  [[nodiscard]] int samples() const { return used_; }  // taken in
  [[nodiscard]] int set_aside() const;                 // gross errors
  /// Residual variance over the dials' own, at least 1.
  [[nodiscard]] double variance_factor() const { return factor_; }
  [[nodiscard]] WorkspaceUncertainty predicted(std::span<const WorkspacePose> where) const {
    return workspace_uncertainty(tool_, v_, covariance(), where);
  }
  /// Inverse of P: what plan next adds to.
  [[nodiscard]] Eigen::MatrixXd information() const;
  /// Condition number of the Jacobian of the samples alone, in units of ParameterInfo::change
  /// and weighted by their noise; infinite where they leave a direction open.
  [[nodiscard]] double condition() const;
  /// Parameters whose standard deviation is above half of what it was without samples.
  [[nodiscard]] std::vector<int> undetermined() const;
  /// Mean variance of one axis of the samples taken in, by their own covariance times
  /// variance_factor() [mm^2]; that of the settings without samples.
  [[nodiscard]] double axis_variance_mm2() const;

 private:
  struct Taken {
    Eigen::VectorXd q;
    geometry::Position p_WE;
    geometry::Assembly assembly;
    Eigen::MatrixXd R;
    Eigen::MatrixXd shared;  // axes x things
    bool set_aside = false;
  };
  using Key = std::tuple<int, int>;  // point, repeat

  struct Normal;
  [[nodiscard]] Normal normal_at(const Eigen::VectorXd& v) const;
  [[nodiscard]] Eigen::MatrixXd shared_pull() const;
  void linearise_anew();
  void set_aside_what_spoils();

  [[nodiscard]] int parameters() const { return static_cast<int>(nominal_.size()); }

  geometry::Tool tool_;
  Eigen::VectorXd nominal_, v_, prior_variance_;
  Eigen::MatrixXd P_;
  Eigen::MatrixXd shared_pull_;  // sum of J' R^-1 shared, parameters x things
  OnlineSettings settings_;
  std::map<Key, Taken> taken_;
  int used_ = 0;           // of these, not set aside
  int linearised_at_ = 0;  // so many of them
  double factor_ = 1.0;
};

}  // namespace sixdial::calibration
