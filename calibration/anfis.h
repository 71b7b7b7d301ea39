// ANFIS, equations (34)-(40): a first-order Sugeno fuzzy system that learns what kinematics
// cannot explain. Any number of inputs, a grid of membership functions, one output. Trained by
// the hybrid rule: consequents by ridge least squares, premises by gradient descent with Jang's
// step rule.
//
// Outside the trained region the inputs are clamped to its box and the output to the range of
// what was learned: a learned residual that extrapolates does harm.
#pragma once

#include <Eigen/Core>
#include <stop_token>
#include <vector>

#include "calibration/anfis_kernels.h"

namespace sixdial::calibration {

/// The whole network as numbers: save these and it can be used again.
struct AnfisModel {
  MembershipKind kind = MembershipKind::kGaussian;
  int inputs = 0;
  int functions = 0;           // per input; 0: no network, the output is 0 everywhere
  Eigen::VectorXd input_mean;  // inputs; standardised x = (input - mean) / scale
  Eigen::VectorXd input_scale;
  Eigen::MatrixXd centre;  // functions x inputs, standardised
  Eigen::MatrixXd width;
  Eigen::MatrixXd slope;        // bell only, else empty
  Eigen::MatrixXd consequents;  // rules x (1 + inputs), rule = k0 + functions * k1 + ...
  Eigen::VectorXd box_low;      // trained region, in the inputs' units
  Eigen::VectorXd box_high;
  double output_low = 0.0;  // bound of the output
  double output_high = 0.0;
  double effective_parameters = 0.0;  // trace of the matrix that maps targets to outputs
  double ridge = 0.0;

  [[nodiscard]] int rules() const;
  /// Output at `input` (inputs x 1), in the units it was trained in.
  [[nodiscard]] double predict(const Eigen::Ref<const Eigen::VectorXd>& input) const;
  /// Membership of each function at one input's value (its units): functions x 1.
  [[nodiscard]] Eigen::VectorXd membership(int input, double value) const;
};

struct AnfisSettings {
  MembershipKind kind = MembershipKind::kGaussian;
  int functions = 6;
  int epochs = 500;
  double ridge = 1e-6;
  double target_mse = 1e-5;  // of the training samples; the epoch that reaches it is reported
  bool stop_at_target = false;  // as the paper does; else on to the best of all epochs
  double first_step = 0.01;     // length of a premise step, standardised
  double step_grows = 1.1;      // after four falls of the error in a row
  double step_shrinks = 0.9;    // after two up-downs
  double output_margin = 0.1;   // of the learned range, allowed beyond it
};

struct AnfisTraining {
  AnfisModel model;                // of the best epoch
  std::vector<double> train_rmse;  // by epoch
  std::vector<double> check_rmse;  // by epoch; empty without checking samples
  std::vector<double> step;        // by epoch
  int best_epoch = 0;              // from 1; 0: not trained
  int target_reached = 0;          // first epoch with train MSE <= target; 0: never
  bool cancelled = false;
};

/// Inputs: samples x inputs; targets: samples. Keeps the epoch with the least checking error
/// (training error if there are no checking samples).
[[nodiscard]] AnfisTraining train_anfis(
    const Eigen::MatrixXd& inputs, const Eigen::VectorXd& targets,
    const Eigen::MatrixXd& check_inputs, const Eigen::VectorXd& check_targets,
    const AnfisSettings& settings = {}, std::stop_token stop = {});

/// The same premises with consequents by ridge least squares on other samples; the trained
/// region, bounds and effective parameters become those of the new samples.
[[nodiscard]] AnfisModel refit_consequents(
    const AnfisModel& model, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& targets,
    double ridge, double output_margin = 0.1);

/// A network before training: functions evenly over each input's range, crossing at one half.
[[nodiscard]] AnfisModel initial_anfis(
    const Eigen::MatrixXd& inputs, MembershipKind kind, int functions);

/// No network: 0 everywhere.
[[nodiscard]] AnfisModel zero_anfis(int inputs);

/// Rows of normalised rule strengths times (1, x): samples x consequents, consequent = rule *
/// (1 + inputs) + input.
[[nodiscard]] Eigen::MatrixXd design_matrix(
    const AnfisModel& model, const Eigen::MatrixXd& inputs);
/// A A' of that matrix, samples x samples, of which the lower triangle is meant; without making
/// A, which is large where many inputs make many rules.
[[nodiscard]] Eigen::MatrixXd design_products(
    const AnfisModel& model, const Eigen::MatrixXd& inputs);

/// Largest grid that is trained; above it the number of rules is refused.
inline constexpr int kMostRules = 4096;
/// functions^inputs rules are not more than that.
[[nodiscard]] bool grid_can_be_trained(int functions, int inputs);

}  // namespace sixdial::calibration
