// Which network, if any: the number of functions and the ridge by leave-one-out errors, which
// ridge least squares gives in closed form. "No network" is a candidate, and keeps its place
// unless another is better beyond chance: a network that learned noise makes the robot worse.
#pragma once

#include <vector>

#include "calibration/anfis.h"

namespace sixdial::calibration {

struct AnfisCandidate {
  int functions = 0;
  double ridge = 0.0;
  double loo_rmse = 0.0;  // leave-one-out root mean squared error
  double effective_parameters = 0.0;
};

struct AnfisSelectionSettings {
  std::vector<int> functions{1, 2, 3, 4, 6};
  std::vector<double> ridges{1e-4, 1e-3, 1e-2, 1e-1, 1.0};
  AnfisCandidate as_printed{6, 1e-6, 0.0, 0.0};
  /// How many standard errors better than no network the best one must be.
  double required_standard_errors = 2.0;
};

struct AnfisSelection {
  AnfisCandidate chosen;  // functions 0: no network
  double gain = 1.0;      // outputs are multiplied by this (0..1): what leave-one-out supports
  double standard_errors = 0.0;  // by which the best candidate beats no network
  double rmse_without = 0.0;     // of the targets themselves
  std::vector<AnfisCandidate> candidates;
  AnfisCandidate as_printed;  // the paper's setting, for comparison; never chosen
};

/// Ridge least squares at one set of samples, each left out in turn. What it rests on is the
/// same for all targets, and is worked out once.
class LeaveOneOut {
 public:
  /// Of the design, samples x columns.
  explicit LeaveOneOut(const Eigen::MatrixXd& A);
  /// Of AA' (its lower triangle), which is the smaller one where there are few samples.
  [[nodiscard]] static LeaveOneOut of_products(const Eigen::MatrixXd& products);

  /// target - prediction without its pose: samples x ridges. `poses`: rows of each pose
  /// (pose_groups.h), which are left out together. `effective`: the trace of the hat matrix for
  /// each ridge.
  [[nodiscard]] Eigen::MatrixXd errors(
      const Eigen::VectorXd& targets, const std::vector<double>& ridges,
      const std::vector<std::vector<int>>& poses, std::vector<double>& effective) const;

 private:
  LeaveOneOut() = default;
  bool of_products_ = true;
  Eigen::MatrixXd vectors_;  // eigenvectors U of AA'; or A V, with those of A'A
  Eigen::VectorXd values_;
};

/// Chooses networks for any number of outputs at the same samples.
class AnfisSelector {
 public:
  /// Inputs: samples x inputs.
  AnfisSelector(
      const Eigen::MatrixXd& inputs, MembershipKind kind, AnfisSelectionSettings settings = {});
  /// Targets: samples.
  [[nodiscard]] AnfisSelection select(const Eigen::VectorXd& targets) const;

 private:
  AnfisSelectionSettings settings_;
  std::vector<std::vector<int>> poses_;
  struct Grid {
    int functions;
    LeaveOneOut without_one;
  };
  std::vector<Grid> grids_;
};

/// Inputs: samples x inputs; targets: samples.
[[nodiscard]] AnfisSelection select_anfis(
    const Eigen::MatrixXd& inputs, const Eigen::VectorXd& targets, MembershipKind kind,
    const AnfisSelectionSettings& settings = {});

/// The network times `gain`, bounds included.
[[nodiscard]] AnfisModel scaled(AnfisModel model, double gain);

}  // namespace sixdial::calibration
