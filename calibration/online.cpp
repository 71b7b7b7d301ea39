#include "calibration/online.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "calibration/identifiability.h"
#include "geometry/long_work.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPasses = 10;
constexpr int kHalvings = 6;  // of a step that makes it worse
// A pass that moves nothing by more than this part of its standard deviation is the last.
constexpr double kSettled = 1e-6;
// Linearised anew at every sample up to here, then whenever there are a twentieth more: all
// samples together cost no more than in proportion to their number.
constexpr int kEverySample = 200;
constexpr double kMore = 1.05;

// Of a parameter whose kind does not say: manufacture and mounting as they are.
constexpr double kUsual_mm = 1.0;
constexpr double kUsual_rad = 0.03;

VectorXd prior(const geometry::RobotModel& robot, const OnlineSettings& settings) {
  VectorXd sd(robot.parameter_count());
  for (Eigen::Index i = 0; i < sd.size(); ++i) {
    const geometry::ParameterInfo& info = robot.parameters[static_cast<std::size_t>(i)];
    const double usual = info.unit == "rad" ? kUsual_rad : kUsual_mm;
    sd[i] = settings.times_known * (info.known_to > 0.0 ? info.known_to : usual);
  }
  return sd.cwiseAbs2();
}

}  // namespace

OnlineEstimator::OnlineEstimator(
    geometry::Tool tool, VectorXd nominal, const OnlineSettings& settings)
    : tool_(std::move(tool)),
      nominal_(std::move(nominal)),
      v_(nominal_),
      prior_variance_(prior(tool_.robot(), settings)),
      P_(prior_variance_.asDiagonal()),
      settings_(settings) {}

std::optional<OnlineSample> OnlineEstimator::add(
    const simulation::Trial& trial, const MatrixXd& shared) {
  if (!trial.position_mm || !trial.position_mm->allFinite()) return std::nullopt;
  if (trial.position_mm->size() != tool_.axes()) return std::nullopt;
  auto here = tool_.derivative(v_, trial.q, trial.assembly);
  if (!here) {  // led astray so far that it cannot even be there
    v_ = nominal_;
    P_ = prior_variance_.asDiagonal();
    shared_pull_.setZero();
    here = tool_.derivative(v_, trial.q, trial.assembly);
  }
  if (!here) return std::nullopt;
  Taken taken{trial.q, *trial.position_mm, trial.assembly, trial.covariance_or_zero(), shared,
              false};
  if (shared_pull_.size() == 0) shared_pull_ = MatrixXd::Zero(parameters(), shared.cols());
  if (!(taken.R.trace() > 0.0)) {
    taken.R = settings_.noise_mm * settings_.noise_mm *
              MatrixXd::Identity(tool_.axes(), tool_.axes());
  }
  OnlineSample sample;
  sample.innovation_mm = taken.p_WE - here->p_WE;
  const MatrixXd S = here->J_v * P_ * here->J_v.transpose() + factor_ * taken.R;
  sample.times_usual =
      std::sqrt(sample.innovation_mm.dot(S.ldlt().solve(sample.innovation_mm)) / tool_.axes());
  const Key key{trial.point, trial.repeat};
  const bool again = taken_.contains(key);
  taken.set_aside = samples() >= settings_.trust_after && sample.times_usual > settings_.gate;
  sample.set_aside = taken.set_aside;
  if (again && !taken_.at(key).set_aside) --used_;
  if (!taken.set_aside) ++used_;
  taken_.insert_or_assign(key, taken);
  if (!taken.set_aside && !again) {  // (17)-(22) with a state that stays
    Ekf filter(v_ - nominal_, P_);
    filter.update(sample.innovation_mm, here->J_v, factor_ * taken.R);
    v_ = nominal_ + filter.x();
    P_ = filter.P();
    if (shared.size() > 0) {
      shared_pull_ += here->J_v.transpose() * (factor_ * taken.R).inverse() * shared;
    }
  }
  const int n = samples();
  if (again || n <= kEverySample || n > kMore * linearised_at_) {
    linearised_at_ = n;
    linearise_anew();
    if (factor_ > settings_.suspicious_factor) {
      set_aside_what_spoils();
      sample.set_aside = taken_.at(key).set_aside;
    }
  }
  return sample;
}

/// Prior and samples at v: what a Gauss-Newton step needs. `cost` is infinite where a pose is
/// out of reach.
struct OnlineEstimator::Normal {
  MatrixXd information;
  VectorXd pull;
  double cost = 0.0;
  double chi2 = 0.0;  // of the samples by their own covariances
  int used = 0;
};

OnlineEstimator::Normal OnlineEstimator::normal_at(const VectorXd& v) const {
  Normal normal;
  const VectorXd off = nominal_ - v;
  normal.pull = off.cwiseQuotient(prior_variance_);
  normal.information = prior_variance_.cwiseInverse().asDiagonal();
  normal.cost = off.dot(normal.pull);
  for (const auto& [key, taken] : taken_) {
    if (taken.set_aside) continue;
    const auto here = tool_.derivative(v, taken.q, taken.assembly);
    if (!here) {
      normal.cost = std::numeric_limits<double>::infinity();
      return normal;
    }
    const VectorXd e = taken.p_WE - here->p_WE;
    const MatrixXd W = (factor_ * taken.R).inverse();
    normal.information += here->J_v.transpose() * W * here->J_v;
    normal.pull += here->J_v.transpose() * W * e;
    const double part = e.dot(W * e);
    normal.cost += part;
    normal.chi2 += factor_ * part;
    ++normal.used;
  }
  return normal;
}

/// Where it now stands.
MatrixXd OnlineEstimator::shared_pull() const {
  MatrixXd pull = MatrixXd::Zero(parameters(), shared_pull_.cols());
  for (const auto& [key, taken] : taken_) {
    if (taken.set_aside || taken.shared.size() == 0) continue;
    const auto here = tool_.derivative(v_, taken.q, taken.assembly);
    if (here) pull += here->J_v.transpose() * (factor_ * taken.R).inverse() * taken.shared;
  }
  return pull;
}

MatrixXd OnlineEstimator::shared_covariance() const {
  if (shared_pull_.size() == 0) return MatrixXd::Zero(parameters(), parameters());
  const MatrixXd moved = P_ * shared_pull_;
  return moved * moved.transpose();
}

// The filter over all samples taken so far, every one linearised where the estimate now stands,
// until that stays: the maximum a posteriori of prior and samples.
void OnlineEstimator::linearise_anew() {
  VectorXd v = v_;
  const MatrixXd one = MatrixXd::Identity(parameters(), parameters());
  Normal here = normal_at(v);
  if (!std::isfinite(here.cost)) {
    v = nominal_;
    here = normal_at(v);
  }
  if (!std::isfinite(here.cost)) return;  // keep the filter's own estimate
  for (int pass = 0; pass < kPasses; ++pass) {
    geometry::check_end();
    const VectorXd whole = here.information.ldlt().solve(here.pull);
    const VectorXd sd = here.information.ldlt().solve(one).diagonal().cwiseSqrt();
    double part = 1.0;
    Normal there = normal_at(v + whole);
    for (int halving = 0; halving < kHalvings && !(there.cost <= here.cost); ++halving) {
      part /= 2;
      there = normal_at(v + part * whole);
    }
    const double moved = part * whole.cwiseAbs().cwiseQuotient(sd).maxCoeff();
    if (std::isfinite(there.cost) && (there.cost <= here.cost || moved < kSettled)) {
      v += part * whole;
      here = there;
    }
    const int freedom = tool_.axes() * here.used - parameters();
    const double factor = freedom >= parameters() ? std::max(1.0, here.chi2 / freedom) : 1.0;
    const bool noise_settled = std::abs(factor - factor_) < 1e-3 * factor_;
    factor_ = factor;
    here = normal_at(v);
    if (moved < kSettled && noise_settled) break;
  }
  v_ = v;
  P_ = here.information.ldlt().solve(one);
  if (shared_pull_.size() > 0) shared_pull_ = shared_pull();
}

// A gross error among the first samples pulls the whole estimate to itself, so its residual
// does not give it away: those with the largest are left out in turn.
void OnlineEstimator::set_aside_what_spoils() {
  constexpr std::size_t kTried = 10;
  constexpr double kFalls = 0.1;
  while (factor_ > settings_.suspicious_factor &&
         tool_.axes() * (samples() - 1) - parameters() >= parameters()) {
    std::vector<std::pair<double, Taken*>> suspects;
    for (auto& [key, taken] : taken_) {
      if (taken.set_aside) continue;
      const auto here = tool_.position(v_, taken.q, taken.assembly);
      const double off = here ? (taken.p_WE - *here).squaredNorm() / taken.R.trace()
                              : std::numeric_limits<double>::infinity();
      suspects.emplace_back(off, &taken);
    }
    std::ranges::sort(suspects, std::greater{}, &std::pair<double, Taken*>::first);
    if (suspects.size() > kTried) suspects.resize(kTried);
    const VectorXd v = v_;
    const MatrixXd P = P_;
    const MatrixXd pull = shared_pull_;
    const double factor = factor_;
    Taken* spoiler = nullptr;
    double least = kFalls * factor;
    --used_;  // one at a time, below
    for (const auto& [off, taken] : suspects) {
      taken->set_aside = true;
      v_ = nominal_;  // away from where the error has pulled it
      linearise_anew();
      if (factor_ < least) {
        least = factor_;
        spoiler = taken;
      }
      taken->set_aside = false;
      v_ = v;
      P_ = P;
      shared_pull_ = pull;
      factor_ = factor;
    }
    if (spoiler == nullptr) {
      ++used_;
      return;
    }
    spoiler->set_aside = true;
    v_ = nominal_;
    linearise_anew();
  }
}

int OnlineEstimator::set_aside() const { return static_cast<int>(taken_.size()) - samples(); }

MatrixXd OnlineEstimator::information() const {
  return P_.ldlt().solve(MatrixXd::Identity(parameters(), parameters()));
}

double OnlineEstimator::condition() const {
  const Eigen::Index axes = tool_.axes();
  MatrixXd A(axes * static_cast<Eigen::Index>(taken_.size()), parameters());
  VectorXd scale(parameters());
  for (int i = 0; i < parameters(); ++i) {
    scale[i] = tool_.robot().parameters[static_cast<std::size_t>(i)].change;
  }
  Eigen::Index row = 0;
  for (const auto& [key, taken] : taken_) {
    if (taken.set_aside) continue;
    const auto here = tool_.derivative(v_, taken.q, taken.assembly);
    if (!here) continue;
    const Eigen::LLT<MatrixXd> root(taken.R);  // R = L L', weighted rows L^-1 J
    A.middleRows(row, axes) = root.matrixL().solve(here->J_v) * scale.asDiagonal();
    row += axes;
  }
  if (row < parameters()) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd values = A.topRows(row).jacobiSvd().singularValues();
  const double least = values[parameters() - 1];
  return least * kOpenCondition > values[0] ? values[0] / least
                                            : std::numeric_limits<double>::infinity();
}

std::vector<int> OnlineEstimator::undetermined() const {
  constexpr double kPart = 0.5;
  std::vector<int> open;
  for (int i = 0; i < parameters(); ++i) {
    if (P_(i, i) > kPart * kPart * prior_variance_[i]) open.push_back(i);
  }
  return open;
}

double OnlineEstimator::axis_variance_mm2() const {
  double sum = 0.0;
  for (const auto& [key, taken] : taken_) {
    if (!taken.set_aside) sum += taken.R.trace() / tool_.axes();
  }
  return samples() > 0 ? factor_ * sum / samples() : settings_.noise_mm * settings_.noise_mm;
}

}  // namespace sixdial::calibration
