#include "calibration/online.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/position_fit.h"

namespace sixdial::calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using geometry::kParameterCount;
using geometry::ParameterMatrix;
using geometry::ParameterVector;

constexpr int kPasses = 10;
// A pass that moves nothing by more than this part of its standard deviation is the last.
constexpr double kSettled = 1e-6;
// Linearised anew at every sample up to here, then at every tenth.
constexpr int kEverySample = 200;

ParameterVector prior(const OnlineSettings& settings) {
  ParameterVector sd;
  sd.head<5>().setConstant(settings.length_sd_mm);
  sd.segment<2>(geometry::kX0).setConstant(settings.frame_sd_mm);
  sd.tail<3>().setConstant(settings.angle_sd_rad);
  return sd.cwiseAbs2();
}

}  // namespace

OnlineEstimator::OnlineEstimator(const ParameterVector& nominal, const OnlineSettings& settings)
    : nominal_(nominal),
      v_(nominal),
      prior_variance_(prior(settings)),
      P_(prior_variance_.asDiagonal()),
      settings_(settings) {}

std::optional<OnlineSample> OnlineEstimator::add(const simulation::Trial& trial) {
  if (!trial.position_mm || !trial.position_mm->allFinite()) return std::nullopt;
  const auto here = geometry::forward_derivative(v_, trial.q_rad, trial.assembly);
  if (!here) return std::nullopt;
  Taken taken{
      trial.q_rad, *trial.position_mm, trial.assembly, trial.position_covariance, false};
  if (!(taken.R.trace() > 0.0)) {
    taken.R = settings_.noise_mm * settings_.noise_mm * Matrix2d::Identity();
  }
  OnlineSample sample;
  sample.innovation_mm = taken.p_WE - here->pose.p_WE;
  const Matrix2d S = here->J_v * P_ * here->J_v.transpose() + factor_ * taken.R;
  sample.times_usual =
      std::sqrt(sample.innovation_mm.dot(S.ldlt().solve(sample.innovation_mm)) / 2);
  const Key key{trial.point, trial.repeat};
  const bool again = taken_.contains(key);
  taken.set_aside = samples() >= settings_.trust_after && sample.times_usual > settings_.gate;
  sample.set_aside = taken.set_aside;
  taken_.insert_or_assign(key, taken);
  if (!taken.set_aside && !again) {  // (17)-(22) with a state that stays
    Ekf filter(v_ - nominal_, P_);
    filter.update(sample.innovation_mm, here->J_v, factor_ * taken.R);
    v_ = nominal_ + filter.x();
    P_ = filter.P();
  }
  const int n = samples();
  if (again || n <= kEverySample || n % 10 == 0) linearise_anew();
  return sample;
}

// The filter over all samples taken so far, every one linearised where the estimate now stands,
// until that stays: the maximum a posteriori of prior and samples.
void OnlineEstimator::linearise_anew() {
  ParameterVector v = v_;
  ParameterMatrix P = P_;
  ParameterMatrix information;
  for (int pass = 0; pass < kPasses; ++pass) {
    ParameterVector pull = (nominal_ - v).cwiseQuotient(prior_variance_);
    information = prior_variance_.cwiseInverse().asDiagonal();
    double chi2 = 0.0;
    int used = 0;
    for (const auto& [key, taken] : taken_) {
      if (taken.set_aside) continue;
      const auto here = geometry::forward_derivative(v, taken.q_rad, taken.assembly);
      if (!here) return;  // keep the filter's own estimate
      const Vector2d e = taken.p_WE - here->pose.p_WE;
      const Matrix2d W = (factor_ * taken.R).inverse();
      information += here->J_v.transpose() * W * here->J_v;
      pull += here->J_v.transpose() * W * e;
      chi2 += factor_ * e.dot(W * e);
      ++used;
    }
    const ParameterVector step = information.ldlt().solve(pull);
    v += step;
    if (!v.allFinite()) return;
    P = information.ldlt().solve(ParameterMatrix::Identity());
    const double moved = step.cwiseAbs().cwiseQuotient(P.diagonal().cwiseSqrt()).maxCoeff();
    const int freedom = 2 * used - kParameterCount;
    const double factor = freedom >= kParameterCount ? std::max(1.0, chi2 / freedom) : 1.0;
    const bool noise_settled = std::abs(factor - factor_) < 1e-3 * factor_;
    factor_ = factor;
    if (moved < kSettled && noise_settled) break;
  }
  v_ = v;
  P_ = P;
}

int OnlineEstimator::samples() const {
  return static_cast<int>(
      std::ranges::count_if(taken_, [](const auto& each) { return !each.second.set_aside; }));
}

int OnlineEstimator::set_aside() const { return static_cast<int>(taken_.size()) - samples(); }

ParameterMatrix OnlineEstimator::information() const {
  return P_.ldlt().solve(ParameterMatrix::Identity());
}

double OnlineEstimator::condition() const {
  Eigen::MatrixXd A(2 * static_cast<Eigen::Index>(taken_.size()), kParameterCount);
  Eigen::Index row = 0;
  for (const auto& [key, taken] : taken_) {
    if (taken.set_aside) continue;
    const auto here = geometry::forward_derivative(v_, taken.q_rad, taken.assembly);
    if (!here) continue;
    const Eigen::LLT<Matrix2d> root(taken.R);  // R = L L', weighted rows L^-1 J
    A.middleRows<2>(row) = root.matrixL().solve(here->J_v) * parameter_scale().asDiagonal();
    row += 2;
  }
  constexpr double kOpen = 1e10;
  if (row < kParameterCount) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd values = A.topRows(row).jacobiSvd().singularValues();
  const double least = values[kParameterCount - 1];
  return least * kOpen > values[0] ? values[0] / least
                                   : std::numeric_limits<double>::infinity();
}

std::vector<int> OnlineEstimator::undetermined() const {
  constexpr double kPart = 0.5;
  std::vector<int> open;
  for (int i = 0; i < kParameterCount; ++i) {
    if (P_(i, i) > kPart * kPart * prior_variance_[i]) open.push_back(i);
  }
  return open;
}

double OnlineEstimator::axis_variance_mm2() const {
  double sum = 0.0;
  for (const auto& [key, taken] : taken_) {
    if (!taken.set_aside) sum += taken.R.trace() / 2;
  }
  return samples() > 0 ? factor_ * sum / samples() : settings_.noise_mm * settings_.noise_mm;
}

}  // namespace sixdial::calibration
