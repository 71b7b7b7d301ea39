#include "calibration/anfis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "calibration/anfis_kernels.h"
#include "calibration/anfis_rules.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double membership_of(MembershipKind kind, double x, double c, double a, double b) {
  const double z = (x - c) / a;
  if (kind == MembershipKind::kGaussian) return std::exp(-std::min(z * z, 600.0));
  return 1.0 / (1.0 + std::pow(std::abs(z), 2 * b));
}

int power(int base, int exponent) {
  if (!grid_can_be_trained(base, exponent)) {
    throw std::invalid_argument(
        "ANFIS: " + std::to_string(base) + " functions for each of " +
        std::to_string(exponent) + " inputs are more rules than can be trained (" +
        std::to_string(kMostRules) + "); take fewer functions or fewer inputs");
  }
  int result = 1;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

VectorXd clamped(const AnfisModel& model, const Eigen::Ref<const VectorXd>& input) {
  return input.cwiseMax(model.box_low).cwiseMin(model.box_high);
}

/// Normalised memberships of one input at its standardised value.
VectorXd shares(const AnfisModel& model, int input, double x) {
  VectorXd mu(model.functions);
  for (int k = 0; k < model.functions; ++k) {
    mu[k] = membership_of(
        model.kind, x, model.centre(k, input), model.width(k, input),
        model.slope.size() > 0 ? model.slope(k, input) : 0.0);
  }
  return mu / std::max(mu.sum(), 1e-300);
}

/// Normalised rule strengths (36) at a standardised input.
VectorXd strengths(const AnfisModel& model, const VectorXd& x) {
  VectorXd w = VectorXd::Ones(1);
  for (int i = 0; i < model.inputs; ++i) {
    const VectorXd mu = shares(model, i, x[i]);
    VectorXd next(w.size() * mu.size());
    for (Eigen::Index k = 0; k < mu.size(); ++k) {
      next.segment(k * w.size(), w.size()) = mu[k] * w;
    }
    w = std::move(next);
  }
  return w;
}

VectorXd standardised(const AnfisModel& model, const VectorXd& input) {
  return (input - model.input_mean).cwiseQuotient(model.input_scale);
}

/// Samples in the kernels' layout (anfis_kernels.h).
struct KernelSamples {
  Eigen::Index count;
  MatrixXd x;   // padded x (1 + inputs), ones first
  MatrixXd nu;  // padded x (inputs * functions)
  [[nodiscard]] int padded() const { return static_cast<int>(x.rows()); }
};

KernelSamples in_kernel_layout(const AnfisModel& model, const MatrixXd& inputs) {
  const int padded = padded_size(static_cast<int>(inputs.rows()));
  KernelSamples result{
      inputs.rows(), MatrixXd::Zero(padded, model.inputs + 1),
      MatrixXd::Zero(padded, static_cast<Eigen::Index>(model.inputs) * model.functions)};
  for (Eigen::Index a = 0; a < inputs.rows(); ++a) {
    const VectorXd x = standardised(model, clamped(model, inputs.row(a).transpose()));
    result.x(a, 0) = 1.0;
    result.x.row(a).tail(model.inputs) = x.transpose();
    for (int i = 0; i < model.inputs; ++i) {
      result.nu.row(a).segment(
          static_cast<Eigen::Index>(i) * model.functions, model.functions) =
          shares(model, i, x[i]).transpose();
    }
  }
  return result;
}

MatrixXd products_of(const AnfisModel& model, const KernelSamples& samples) {
  MatrixXd K = MatrixXd::Zero(samples.padded(), samples.padded());
  anfis_gram_dual(
      model.inputs, model.functions, samples.padded(), samples.x.data(), samples.nu.data(),
      K.data());
  return K.topLeftCorner(samples.count, samples.count);
}

/// Consequents of few samples by the dual form, (AA' + ridge I) alpha = y, theta = A'alpha,
/// without A; what they answer there.
VectorXd refit_dual(
    AnfisModel& model, const MatrixXd& inputs, const VectorXd& targets, double ridge,
    VectorXd& theta) {
  const KernelSamples samples = in_kernel_layout(model, inputs);
  const Eigen::Index n = samples.count;
  MatrixXd K = products_of(model, samples);
  K.diagonal().array() += ridge;
  const Eigen::LLT<MatrixXd> llt(K);
  VectorXd alpha = VectorXd::Zero(samples.padded());
  alpha.head(n) = llt.solve(targets);
  AnfisRules rules(model.inputs, model.functions, samples.padded());
  rules.set(samples.nu);
  rules.project(samples.x, alpha, theta);
  VectorXd learned(samples.padded());
  rules.answer(samples.x, theta, learned);
  MatrixXd inverse = MatrixXd::Identity(n, n);  // of L: the trace of K^-1 is its squares
  llt.matrixL().solveInPlace(inverse);
  model.effective_parameters = static_cast<double>(n) - ridge * inverse.squaredNorm();
  return learned.head(n);
}

}  // namespace

bool grid_can_be_trained(int functions, int inputs) {
  double rules = 1.0;
  for (int i = 0; i < inputs; ++i) rules *= functions;
  return rules <= kMostRules;
}

int AnfisModel::rules() const { return functions == 0 ? 0 : power(functions, inputs); }

double AnfisModel::predict(const Eigen::Ref<const VectorXd>& input) const {
  if (functions == 0) return 0.0;
  const VectorXd x = standardised(*this, clamped(*this, input));
  const VectorXd w = strengths(*this, x);
  double sum = w.dot(consequents.col(0));
  for (int i = 0; i < inputs; ++i) sum += x[i] * w.dot(consequents.col(i + 1));
  return std::clamp(sum, output_low, output_high);
}

VectorXd AnfisModel::membership(int input, double value) const {
  VectorXd mu(functions);
  const double x = (value - input_mean[input]) / input_scale[input];
  for (int k = 0; k < functions; ++k) {
    mu[k] = membership_of(
        kind, x, centre(k, input), width(k, input), slope.size() > 0 ? slope(k, input) : 0.0);
  }
  return mu;
}

AnfisModel zero_anfis(int inputs) {
  AnfisModel model;
  model.inputs = inputs;
  model.input_mean = VectorXd::Zero(inputs);
  model.input_scale = VectorXd::Ones(inputs);
  model.box_low = VectorXd::Zero(inputs);
  model.box_high = VectorXd::Zero(inputs);
  return model;
}

AnfisModel initial_anfis(const MatrixXd& inputs, MembershipKind kind, int functions) {
  if (inputs.rows() < 1 || inputs.cols() < 1 || functions < 1 || !inputs.allFinite()) {
    throw std::invalid_argument(
        "ANFIS: at least one sample with finite inputs and one function per input are needed");
  }
  AnfisModel model;
  model.kind = kind;
  model.inputs = static_cast<int>(inputs.cols());
  model.functions = functions;
  power(functions, model.inputs);
  model.box_low = inputs.colwise().minCoeff();
  model.box_high = inputs.colwise().maxCoeff();
  model.input_mean = inputs.colwise().mean();
  model.input_scale.resize(model.inputs);
  model.centre.resize(functions, model.inputs);
  model.width.resize(functions, model.inputs);
  if (kind == MembershipKind::kBell) {
    model.slope = MatrixXd::Constant(functions, model.inputs, 2.0);
  }
  for (int i = 0; i < model.inputs; ++i) {
    const double variance = (inputs.col(i).array() - model.input_mean[i]).square().mean();
    model.input_scale[i] = variance > 0.0 ? std::sqrt(variance) : 1.0;
    const double low = (model.box_low[i] - model.input_mean[i]) / model.input_scale[i];
    const double high = (model.box_high[i] - model.input_mean[i]) / model.input_scale[i];
    const double range = high > low ? high - low : 1.0;
    for (int k = 0; k < functions; ++k) {
      const double part = functions > 1 ? static_cast<double>(k) / (functions - 1) : 0.5;
      model.centre(k, i) = low + range * part;
    }
    const double half_gap = range / std::max(functions - 1, 1) / 2;
    model.width.col(i).setConstant(
        kind == MembershipKind::kBell ? half_gap : half_gap / std::sqrt(std::numbers::ln2));
  }
  model.consequents = MatrixXd::Zero(model.rules(), model.inputs + 1);
  return model;
}

MatrixXd design_matrix(const AnfisModel& model, const MatrixXd& inputs) {
  const int rules = model.rules();
  const int per_rule = model.inputs + 1;
  MatrixXd A(inputs.rows(), rules * per_rule);
  for (Eigen::Index a = 0; a < inputs.rows(); ++a) {
    const VectorXd x = standardised(model, clamped(model, inputs.row(a).transpose()));
    const VectorXd w = strengths(model, x);
    for (int r = 0; r < rules; ++r) {
      A(a, r * per_rule) = w[r];
      for (int i = 0; i < model.inputs; ++i) A(a, r * per_rule + 1 + i) = w[r] * x[i];
    }
  }
  return A;
}

MatrixXd design_products(const AnfisModel& model, const MatrixXd& inputs) {
  return products_of(model, in_kernel_layout(model, inputs));
}

AnfisModel refit_consequents(
    const AnfisModel& model, const MatrixXd& inputs, const VectorXd& targets, double ridge,
    double output_margin) {
  AnfisModel result = model;
  if (model.functions == 0) return result;
  result.box_low = inputs.colwise().minCoeff();
  result.box_high = inputs.colwise().maxCoeff();
  const Eigen::Index columns = static_cast<Eigen::Index>(model.rules()) * (model.inputs + 1);
  VectorXd theta(columns);
  VectorXd learned;
  if (inputs.rows() <= columns) {
    learned = refit_dual(result, inputs, targets, ridge, theta);
  } else {
    const MatrixXd A = design_matrix(result, inputs);
    MatrixXd G = A.transpose() * A;
    G.diagonal().array() += ridge;
    const Eigen::LLT<MatrixXd> llt(G);
    theta = llt.solve(A.transpose() * targets);
    result.effective_parameters =
        static_cast<double>(columns) -
        ridge * llt.solve(MatrixXd::Identity(columns, columns)).trace();
    learned = A * theta;
  }
  const int per_rule = model.inputs + 1;
  result.consequents.resize(model.rules(), per_rule);
  for (int r = 0; r < model.rules(); ++r) {
    result.consequents.row(r) = theta.segment(r * per_rule, per_rule).transpose();
  }
  result.ridge = ridge;
  const double range = learned.maxCoeff() - learned.minCoeff();
  result.output_low = learned.minCoeff() - output_margin * range;
  result.output_high = learned.maxCoeff() + output_margin * range;
  return result;
}

}  // namespace sixdial::calibration
