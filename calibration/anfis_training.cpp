// Hybrid learning of calibration/anfis.h. In one epoch: memberships and rule strengths, the
// consequents by ridge least squares (dual form where there are fewer samples than
// consequents), the errors, and a step of the premises down their gradient.

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "calibration/anfis.h"
#include "calibration/anfis_kernels.h"
#include "calibration/anfis_rules.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Premises are kept from degenerating: standardised width, and slope of a bell.
constexpr double kLeastWidth = 0.02;
constexpr double kLeastSlope = 0.1;
constexpr double kMostSlope = 20.0;

/// Samples in the kernels' layout, with the arrays that an epoch fills.
class Block {
 public:
  Block(const AnfisModel& model, const MatrixXd& inputs, const VectorXd& targets)
      : n_(static_cast<int>(inputs.rows())),
        padded_(padded_size(n_)),
        inputs_(model.inputs),
        functions_(model.functions),
        bell_(model.kind == MembershipKind::kBell),
        x_(MatrixXd::Zero(padded_, inputs_ + 1)),
        y_(VectorXd::Zero(padded_)),
        nu_(padded_, inputs_ * functions_),
        by_centre_(padded_, inputs_ * functions_),
        by_width_(padded_, inputs_ * functions_),
        by_slope_(padded_, bell_ ? inputs_ * functions_ : 0),
        rules_(inputs_, functions_, padded_),
        out_(VectorXd::Zero(padded_)) {
    for (int a = 0; a < n_; ++a) {
      x_(a, 0) = 1.0;
      for (int i = 0; i < inputs_; ++i) {
        const double inside = std::clamp(inputs(a, i), model.box_low[i], model.box_high[i]);
        x_(a, i + 1) = (inside - model.input_mean[i]) / model.input_scale[i];
      }
      y_[a] = targets[a];
    }
  }

  void fuzzify(const AnfisModel& model) {
    for (int i = 0; i < inputs_; ++i) {
      const Eigen::Index at = static_cast<Eigen::Index>(i) * functions_;
      anfis_memberships(
          model.kind, functions_, padded_, x_.col(i + 1).data(), model.centre.col(i).data(),
          model.width.col(i).data(), bell_ ? model.slope.col(i).data() : nullptr,
          {nu_.col(at).data(), by_centre_.col(at).data(), by_width_.col(at).data(),
           bell_ ? by_slope_.col(at).data() : nullptr});
    }
    rules_.set(nu_);
  }

  /// Outputs with consequents B (rule-major); returns the root mean squared error.
  double answer(const VectorXd& B) {
    rules_.answer(x_, B, out_);
    return std::sqrt((y_ - out_).head(n_).squaredNorm() / n_);
  }

  int n_, padded_, inputs_, functions_;
  bool bell_;
  MatrixXd x_;  // padded x (1 + inputs), ones first
  VectorXd y_;
  MatrixXd nu_, by_centre_, by_width_, by_slope_;  // padded x (inputs * functions)
  AnfisRules rules_;
  VectorXd out_;
};

class Trainer {
 public:
  Trainer(const AnfisModel& model, Block& block, double ridge)
      : model_(model),
        block_(block),
        ridge_(ridge),
        rule_count_(model.rules()),
        columns_(rule_count_ * (block.inputs_ + 1)),
        dual_(block.n_ <= columns_),
        ld_(padded_size(dual_ ? block.n_ : columns_)),
        gram_(MatrixXd::Zero(ld_, ld_)),
        right_(VectorXd::Zero(ld_)),
        strength_(dual_ ? 0 : block.padded_, dual_ ? 0 : rule_count_),
        design_(dual_ ? 0 : block.padded_, dual_ ? 0 : columns_),
        B_(VectorXd::Zero(columns_)),
        error_(block.padded_) {}

  /// Consequents by ridge least squares. False if the system cannot be solved.
  [[nodiscard]] bool solve() {
    if (dual_) {
      anfis_gram_dual(
          block_.inputs_, block_.functions_, block_.padded_, block_.x_.data(),
          block_.nu_.data(), gram_.data());
      gram_.diagonal().array() += ridge_;
      right_ = block_.y_;
      if (!cholesky_solve(block_.n_, ld_, gram_.data(), right_.data())) return false;
      block_.rules_.project(block_.x_, right_, B_);
      return true;
    }
    const int per_rule = block_.inputs_ + 1;
    anfis_rules(
        block_.inputs_, block_.functions_, block_.padded_, block_.nu_.data(), strength_.data());
    for (int r = 0; r < rule_count_; ++r) {
      for (int c = 0; c < per_rule; ++c) {
        design_.col(r * per_rule + c) = strength_.col(r).cwiseProduct(block_.x_.col(c));
      }
    }
    gram_primal(columns_, block_.padded_, design_.data(), ld_, gram_.data());
    gram_.diagonal().array() += ridge_;
    right_.head(columns_).noalias() = design_.transpose() * block_.y_;
    if (!cholesky_solve(columns_, ld_, gram_.data(), right_.data())) return false;
    B_ = right_.head(columns_);
    return true;
  }

  [[nodiscard]] const VectorXd& consequents() const { return B_; }

  /// One step of length `step` down the gradient of the squared error.
  void step_premises(AnfisModel& model, double step) {
    error_ = 2.0 * (block_.out_ - block_.y_).cwiseProduct(block_.x_.col(0));
    MatrixXd g_centre(block_.functions_, block_.inputs_);
    MatrixXd g_width = g_centre;
    MatrixXd g_slope = MatrixXd::Zero(g_centre.rows(), g_centre.cols());
    // d out / dp = d ln(mu)/dp (sum of the rules that use mu - nu * out)
    parts_ = -(block_.nu_.array().colwise() * block_.out_.array());
    block_.rules_.add_by_function(block_.x_, B_, parts_);
    for (int i = 0; i < block_.inputs_; ++i) {
      for (int k = 0; k < block_.functions_; ++k) {
        const Eigen::Index at = static_cast<Eigen::Index>(i) * block_.functions_ + k;
        const auto along = [&](const MatrixXd& by) {
          return dot3(block_.padded_, error_.data(), parts_.col(at).data(), by.col(at).data());
        };
        g_centre(k, i) = along(block_.by_centre_);
        g_width(k, i) = along(block_.by_width_);
        if (block_.bell_) g_slope(k, i) = along(block_.by_slope_);
      }
    }
    const double norm =
        std::sqrt(g_centre.squaredNorm() + g_width.squaredNorm() + g_slope.squaredNorm());
    if (!(norm > 0.0) || !std::isfinite(norm)) return;
    model.centre -= step / norm * g_centre;
    model.width = (model.width - step / norm * g_width).cwiseMax(kLeastWidth);
    if (block_.bell_) {
      model.slope =
          (model.slope - step / norm * g_slope).cwiseMax(kLeastSlope).cwiseMin(kMostSlope);
    }
  }

 private:
  const AnfisModel& model_;
  Block& block_;
  double ridge_;
  int rule_count_;
  int columns_;
  bool dual_;
  int ld_;
  MatrixXd gram_;
  VectorXd right_;
  MatrixXd strength_;  // padded x rules
  MatrixXd design_;
  VectorXd B_;
  MatrixXd parts_;  // padded x (inputs * functions)
  VectorXd error_;
};

/// Jang's rule: longer after four falls in a row, shorter after two up-downs.
class StepRule {
 public:
  explicit StepRule(const AnfisSettings& settings)
      : settings_(settings), step_(settings.first_step) {}

  [[nodiscard]] double after(const std::vector<double>& error) {
    const std::size_t n = error.size();
    if (n < changed_ + 5) return step_;
    bool falls[4];
    for (std::size_t k = 0; k < 4; ++k) falls[k] = error[n - 4 + k] < error[n - 5 + k];
    if (falls[0] && falls[1] && falls[2] && falls[3]) {
      step_ *= settings_.step_grows;
      changed_ = n - 1;
    } else if (falls[0] && !falls[1] && falls[2] && !falls[3]) {
      step_ *= settings_.step_shrinks;
      changed_ = n - 1;
    }
    return step_;
  }

 private:
  const AnfisSettings& settings_;
  double step_;
  std::size_t changed_ = 0;
};

}  // namespace

AnfisTraining train_anfis(
    const MatrixXd& inputs, const VectorXd& targets, const MatrixXd& check_inputs,
    const VectorXd& check_targets, const AnfisSettings& settings, std::stop_token stop) {
  if (inputs.rows() != targets.size() || check_inputs.rows() != check_targets.size() ||
      (check_inputs.rows() > 0 && check_inputs.cols() != inputs.cols()) ||
      !targets.allFinite() || settings.ridge <= 0.0) {
    throw std::invalid_argument(
        "train_anfis: one finite target for each sample, inputs of one width and a positive "
        "ridge are needed");
  }
  AnfisTraining result;
  AnfisModel model = initial_anfis(inputs, settings.kind, settings.functions);
  Block train(model, inputs, targets);
  const bool has_check = check_inputs.rows() > 0;
  Block check(
      model, has_check ? check_inputs : inputs.topRows(1),
      has_check ? check_targets : targets.head(1));
  Trainer trainer(model, train, settings.ridge);
  StepRule rule(settings);
  AnfisModel best = model;
  double best_error = std::numeric_limits<double>::infinity();
  double step = settings.first_step;
  for (int epoch = 1; epoch <= std::max(settings.epochs, 1); ++epoch) {
    if (stop.stop_requested()) {
      result.cancelled = true;
      break;
    }
    train.fuzzify(model);
    if (!trainer.solve()) break;
    const double error = train.answer(trainer.consequents());
    result.train_rmse.push_back(error);
    result.step.push_back(step);
    double judged = error;
    if (has_check) {
      check.fuzzify(model);
      judged = check.answer(trainer.consequents());
      result.check_rmse.push_back(judged);
    }
    if (judged < best_error) {
      best_error = judged;
      best = model;
      result.best_epoch = epoch;
    }
    if (result.target_reached == 0 && error * error <= settings.target_mse) {
      result.target_reached = epoch;
      if (settings.stop_at_target) break;
    }
    step = rule.after(result.train_rmse);
    if (epoch < settings.epochs) trainer.step_premises(model, step);
  }
  result.model =
      refit_consequents(best, inputs, targets, settings.ridge, settings.output_margin);
  return result;
}

}  // namespace sixdial::calibration
