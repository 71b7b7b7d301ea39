#include "calibration/joint_curves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/long_work.h"
#include "geometry/tool.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::Trial;

constexpr double kFree = 1e-8;           // precision of the robot's parameters, per change^2
constexpr double kFirstSize_rad = 1e-3;  // of a curve, before the data have said one
constexpr double kLeastSize_rad = 1e-9;
constexpr double kStandsOut = 2.5;  // robust standard deviations
constexpr double kSettled = 1e-3;   // of the logarithm of a size

/// Share of each wave in a curve's variance: flat up to 1 / smoothness, then falling fast.
VectorXd spectrum(int waves, double smoothness) {
  VectorXd share(waves);
  for (int k = 0; k < waves; ++k) {
    const double at = (k + 1) * smoothness;
    share[k] = 1.0 / ((1.0 + at * at) * (1.0 + at * at));
  }
  return share / share.sum();
}

void waves_at(double q, Eigen::Ref<VectorXd> cosines, Eigen::Ref<VectorXd> sines) {
  for (Index k = 0; k < cosines.size(); ++k) {
    cosines[k] = std::cos(static_cast<double>(k + 1) * q);
    sines[k] = std::sin(static_cast<double>(k + 1) * q);
  }
}

/// The linear problem at hand: columns of the robot's parameters (per change), then of each
/// turning joint's waves.
struct Equations {
  MatrixXd G;  // columns' products, lower triangle
  VectorXd b;  // products with what is left, the curves' own part added
  double rr = 0.0;
  Index rows = 0;
};

class Fitter {
 public:
  Fitter(
      std::span<const Trial> trials, const geometry::Rig& rig, const VectorXd& start,
      const JointCurveSettings& settings)
      : tool_(rig), settings_(settings), v_(start) {
    const geometry::RobotModel& robot = tool_.robot();
    for (const Trial& trial : trials) {
      const bool usable = trial.position_mm && trial.position_mm->size() == tool_.axes() &&
                          trial.q.size() == robot.joint_count() &&
                          trial.position_mm->allFinite() && trial.q.allFinite();
      if (usable) trials_.push_back(&trial);
    }
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      if (robot.joints[j].kind == geometry::JointKind::kRevolute) {
        turning_.push_back(static_cast<Index>(j));
      }
    }
    scale_.resize(v_.size());
    for (std::size_t i = 0; i < robot.parameters.size(); ++i) {
      scale_[static_cast<Index>(i)] = robot.parameters[i].change;
    }
    curves_.waves = settings.waves;
    curves_.coefficients.setZero(robot.joint_count(), 2 * settings.waves);
    prior_rad_ = VectorXd::Constant(std::ssize(turning_), kFirstSize_rad);
    told_ = VectorXd::Zero(std::ssize(turning_));
  }

  std::optional<JointCurveFit> fit() {
    if (turning_.empty() || std::ssize(trials_) * tool_.axes() <= v_.size() + 1) {
      return std::nullopt;
    }
    for (int round = 0; round < settings_.rounds; ++round) {
      if (!linearise()) return std::nullopt;
      if (round == 0) {
        choose_smoothness();
      } else {
        settle(smoothness_);
      }
      take();
    }
    return result();
  }

 private:
  [[nodiscard]] Index waves() const { return settings_.waves; }
  [[nodiscard]] Index columns() const { return v_.size() + 2 * waves() * std::ssize(turning_); }
  [[nodiscard]] Index first_of(Index turning) const {
    return v_.size() + 2 * waves() * turning;
  }

  bool linearise() {
    const Index axes = tool_.axes();
    MatrixXd A(axes * std::ssize(trials_), columns());
    VectorXd r(A.rows());
    VectorXd size(std::ssize(trials_));
    for (Index i = 0; i < size.size(); ++i) {
      const Trial& trial = *trials_[static_cast<std::size_t>(i)];
      const auto at = tool_.derivative(v_, trial.q + curves_.at(trial.q), trial.assembly);
      if (!at) return false;
      const VectorXd e = *trial.position_mm - at->p_WE;
      size[i] = e.norm();
      auto rows = A.middleRows(axes * i, axes);
      rows.leftCols(v_.size()) = at->J_v * scale_.asDiagonal();
      VectorXd cosines(waves());
      VectorXd sines(waves());
      VectorXd own = VectorXd::Zero(axes);  // what the curves so far do
      for (Index t = 0; t < std::ssize(turning_); ++t) {
        const Index joint = turning_[static_cast<std::size_t>(t)];
        waves_at(trial.q[joint], cosines, sines);
        rows.middleCols(first_of(t), waves()) = at->J_q.col(joint) * cosines.transpose();
        rows.middleCols(first_of(t) + waves(), waves()) =
            at->J_q.col(joint) * sines.transpose();
        own +=
            at->J_q.col(joint) * (curves_.coefficients.row(joint).head(waves()).dot(cosines) +
                                  curves_.coefficients.row(joint).tail(waves()).dot(sines));
      }
      r.segment(axes * i, axes) = e + own;
    }
    weigh(size, axes, A, r);
    equations_.G.setZero(A.cols(), A.cols());
    equations_.G.selfadjointView<Eigen::Lower>().rankUpdate(A.transpose());
    equations_.b = A.transpose() * r;
    equations_.rr = r.squaredNorm();
    return true;
  }

  /// Rows that stand out of the rest count less (Cauchy's weights).
  void weigh(const VectorXd& size, Index axes, MatrixXd& A, VectorXd& r) {
    std::vector<double> sizes(size.begin(), size.end());
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::ranges::nth_element(sizes, middle);
    const double to_sigma = axes == 3 ? 1.538 : 1.177;  // median length of a unit normal vector
    const double limit = std::max(kStandsOut * *middle / to_sigma, 1e-9);
    double counted = 0.0;
    for (Index i = 0; i < size.size(); ++i) {
      const double weight = 1.0 / (1.0 + std::pow(size[i] / limit, 2));
      A.middleRows(axes * i, axes) *= std::sqrt(weight);
      r.segment(axes * i, axes) *= std::sqrt(weight);
      counted += weight * static_cast<double>(axes);
    }
    equations_.rows = static_cast<Index>(std::llround(counted));
    if (sigma_mm_ == 0.0) sigma_mm_ = std::max(*middle / to_sigma, 1e-6);
  }

  /// Root of the prior variance of each column.
  [[nodiscard]] VectorXd roots(const VectorXd& share, const VectorXd& size_rad) const {
    VectorXd root(columns());
    root.head(v_.size()).setConstant(1.0);
    for (Index t = 0; t < size_rad.size(); ++t) {
      // A cosine's mean square is a half, and so is a sine's.
      const VectorXd of_wave = size_rad[t] * share.cwiseSqrt();
      root.segment(first_of(t), waves()) = of_wave;
      root.segment(first_of(t) + waves(), waves()) = of_wave;
    }
    return root;
  }

  /// MacKay's steps for noise and sizes at one smoothness; the coefficients that go with them.
  void settle(double smoothness) {
    smoothness_ = smoothness;
    const VectorXd share = spectrum(settings_.waves, smoothness);
    for (int step = 0; step < settings_.evidence_steps; ++step) {
      geometry::check_end();
      const VectorXd root = roots(share, prior_rad_);
      const double noise2 = sigma_mm_ * sigma_mm_;
      MatrixXd M = root.asDiagonal() * equations_.G * root.asDiagonal();
      M.diagonal().head(v_.size()).array() += kFree * noise2;
      M.diagonal().tail(columns() - v_.size()).array() += noise2;
      const Eigen::LLT<MatrixXd> llt(M);
      const VectorXd right = root.cwiseProduct(equations_.b);
      const VectorXd u = llt.solve(right);
      solution_ = root.cwiseProduct(u);
      // Diagonal of the inverse: squared columns of L^-1.
      MatrixXd inverse = MatrixXd::Identity(columns(), columns());
      llt.matrixL().solveInPlace(inverse);
      const VectorXd diagonal = inverse.colwise().squaredNorm().transpose();
      double told_in_all = static_cast<double>(v_.size());
      double change = 0.0;
      for (Index t = 0; t < prior_rad_.size(); ++t) {
        const auto part = u.segment(first_of(t), 2 * waves());
        const double told = static_cast<double>(2 * waves()) -
                            noise2 * diagonal.segment(first_of(t), 2 * waves()).sum();
        told_[t] = std::max(told, 0.0);
        told_in_all += told_[t];
        const double grown = told_[t] > 1e-6 ? std::sqrt(part.squaredNorm() / told_[t]) : 0.0;
        const double next = std::max(prior_rad_[t] * grown, kLeastSize_rad);
        change = std::max(change, std::abs(std::log(next / prior_rad_[t])));
        prior_rad_[t] = next;
      }
      const double left = std::max(
          equations_.rr - 2.0 * solution_.dot(equations_.b) +
              solution_.dot(equations_.G.selfadjointView<Eigen::Lower>() * solution_),
          0.0);
      const double freedom = std::max(static_cast<double>(equations_.rows) - told_in_all, 1.0);
      sigma_mm_ = std::max(std::sqrt(left / freedom), 1e-9);
      // Of the data: rows, determinant, fit; at the sizes that this step began with.
      const double log_det = 2.0 * llt.matrixLLT().diagonal().array().log().sum() -
                             static_cast<double>(columns() - v_.size()) * std::log(noise2);
      log_evidence_ = -0.5 * (static_cast<double>(equations_.rows) * std::log(noise2) +
                              log_det + (equations_.rr - right.dot(u)) / noise2);
      if (change < kSettled) break;
    }
  }

  void choose_smoothness() {
    struct Kept {
      double smoothness, evidence, sigma;
      VectorXd prior;
    };
    std::optional<Kept> best;
    const double first_sigma = sigma_mm_;
    for (const double smoothness : settings_.smoothness) {
      sigma_mm_ = first_sigma;
      prior_rad_.setConstant(kFirstSize_rad);
      settle(smoothness);
      if (!best || log_evidence_ > best->evidence) {
        best = Kept{smoothness, log_evidence_, sigma_mm_, prior_rad_};
      }
    }
    sigma_mm_ = best->sigma;
    prior_rad_ = best->prior;
    settle(best->smoothness);
  }

  void take() {
    v_ += scale_.cwiseProduct(solution_.head(v_.size()));
    for (Index t = 0; t < std::ssize(turning_); ++t) {
      curves_.coefficients.row(turning_[static_cast<std::size_t>(t)]) =
          solution_.segment(first_of(t), 2 * waves()).transpose();
    }
  }

  [[nodiscard]] JointCurveFit result() const {
    JointCurveFit fit{
        v_,
        curves_,
        sigma_mm_,
        smoothness_,
        VectorXd::Zero(tool_.robot().joint_count()),
        VectorXd::Zero(tool_.robot().joint_count()),
        log_evidence_};
    for (Index t = 0; t < std::ssize(turning_); ++t) {
      fit.prior_rad[turning_[static_cast<std::size_t>(t)]] = prior_rad_[t];
      fit.told[turning_[static_cast<std::size_t>(t)]] = told_[t];
    }
    return fit;
  }

  geometry::Tool tool_;
  JointCurveSettings settings_;
  VectorXd v_;
  std::vector<const Trial*> trials_;
  std::vector<Index> turning_;  // joints
  VectorXd scale_;
  JointCurves curves_;
  Equations equations_;
  VectorXd solution_;
  VectorXd prior_rad_, told_;  // by turning joint
  double sigma_mm_ = 0.0;
  double smoothness_ = 0.0;
  double log_evidence_ = -std::numeric_limits<double>::infinity();
};

}  // namespace

VectorXd JointCurves::at(const VectorXd& q) const {
  VectorXd c = VectorXd::Zero(q.size());
  VectorXd cosines(waves);
  VectorXd sines(waves);
  for (Index j = 0; j < q.size() && j < coefficients.rows(); ++j) {
    if (coefficients.row(j).isZero(0.0)) continue;
    waves_at(q[j], cosines, sines);
    c[j] = coefficients.row(j).head(waves).dot(cosines) +
           coefficients.row(j).tail(waves).dot(sines);
  }
  return c;
}

double JointCurves::size_rad(Index joint) const {
  return coefficients.row(joint).norm() / std::sqrt(2.0);
}

std::optional<JointCurveFit> fit_joint_curves(
    std::span<const Trial> trials, const geometry::Rig& rig, const VectorXd& start,
    const JointCurveSettings& settings) {
  return Fitter(trials, rig, start, settings).fit();
}

}  // namespace sixdial::calibration
