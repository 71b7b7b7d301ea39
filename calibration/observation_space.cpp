#include "calibration/observation_space.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/same_pose.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// W with W'W = C^-1 times the mean variance of all rows, sample by sample; the identity where
/// a sample has no covariance.
std::vector<MatrixXd> whitening(const ObservationSpace& space) {
  double sum_mm2 = 0.0;
  for (const MatrixXd& C : space.covariance_mm2) sum_mm2 += C.trace();
  const double mean_mm2 = sum_mm2 / std::max(space.rows(), 1);
  std::vector<MatrixXd> result;
  for (int i = 0; i < space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Index n = space.rows(i);
    result.emplace_back(MatrixXd::Identity(n, n));
    if (k >= space.covariance_mm2.size() || space.covariance_mm2[k].rows() != n) continue;
    const Eigen::LLT<MatrixXd> llt(space.covariance_mm2[k]);
    if (llt.info() != Eigen::Success || !(llt.matrixLLT().diagonal().array() > 0.0).all()) {
      continue;
    }
    result.back() = std::sqrt(mean_mm2) * llt.matrixL().solve(MatrixXd::Identity(n, n)).eval();
  }
  return result;
}

/// J'J, J'r and r'r summed sample by sample: the large Jacobian is never there.
auto normal_equations(const ObservationSpace& space, const VectorXd& weight) {
  return [&space, weight](const VectorXd& x, MatrixXd& JtJ, VectorXd& Jtr, double& rss) {
    JtJ.setZero();
    Jtr.setZero();
    rss = 0.0;
    MatrixXd block;
    VectorXd e;
    for (int i = 0; i < space.samples(); ++i) {
      const int count = space.rows(i);
      block.resize(count, space.parameters());
      e.resize(count);
      if (!space.evaluate(i, x, e, &block)) return false;
      const auto w = weight.segment(space.first_row[static_cast<std::size_t>(i)], count);
      e.array() *= w.array();
      block.array().colwise() *= w.array();
      JtJ.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
      Jtr.noalias() -= block.transpose() * e;
      rss += e.squaredNorm();
    }
    return true;
  };
}

/// Samples that were measured; what is known of an instrument (reading_space.h) comes behind.
int measured_count(const ObservationSpace& space) {
  int measured = space.samples();
  while (measured > 0 && space.sample[static_cast<std::size_t>(measured - 1)] < 0) --measured;
  return measured;
}

/// A touch always reads the same: what scatters when it is repeated are the joint values.
bool reads_the_same(const ObservationSpace& space) {
  const int rows = space.first_row[static_cast<std::size_t>(measured_count(space))];
  return rows > 0 && (space.measured_mm.head(rows).array() == space.measured_mm[0]).all();
}

/// Squared deviations of values that should be the same, with their degrees of freedom.
struct Pool {
  double sum = 0.0;
  int freedom = 0;
  void add(const std::vector<double>& values) {
    if (values.size() < 2) return;
    double mean = 0.0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    for (const double value : values) sum += (value - mean) * (value - mean);
    freedom += static_cast<int>(values.size()) - 1;
  }
};

}  // namespace

int ObservationSpace::block() const {
  return rows_belong_together ? std::max(position_axes, 1) : 1;
}

VectorXd ObservationSpace::scale() const {
  VectorXd result(parameters());
  for (int i = 0; i < parameters(); ++i) {
    result[i] = parameter_info[static_cast<std::size_t>(i)].change;
  }
  return result;
}

std::vector<std::string_view> ObservationSpace::parameter_names() const {
  std::vector<std::string_view> names;
  for (const ParameterInfo& each : parameter_info) names.emplace_back(each.name);
  return names;
}

std::vector<MatrixXd> ObservationSpace::weights(Weighting weighting) const {
  if (weighting == Weighting::kByCovariance) return whitening(*this);
  std::vector<MatrixXd> result;
  if (weighting == Weighting::kAlike) return result;
  const VectorXd weight = mean_sigma() * sigma_mm.cwiseInverse();
  for (int i = 0; i < samples(); ++i) {
    const int first = first_row[static_cast<std::size_t>(i)];
    result.emplace_back(weight.segment(first, rows(i)).asDiagonal());
  }
  return result;
}

LeastSquaresProblem ObservationSpace::problem(Weighting weighting) const {
  if (kernels && kernels->problem.evaluate && weighting == Weighting::kAlike) {
    return kernels->problem;
  }
  LeastSquaresProblem result;
  result.parameters = parameters();
  result.residuals = rows();
  const VectorXd weight = weighting == Weighting::kBySigma
                              ? VectorXd(mean_sigma() * sigma_mm.cwiseInverse())
                              : VectorXd::Ones(rows());
  const std::vector<MatrixXd> whiten =
      weighting == Weighting::kByCovariance ? whitening(*this) : std::vector<MatrixXd>{};
  result.evaluate = [this, weight, whiten](const VectorXd& x, VectorXd& r, MatrixXd* J) {
    MatrixXd block;
    for (int i = 0; i < samples(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const int first = first_row[k];
      const int count = rows(i);
      auto part = r.segment(first, count);
      if (J != nullptr) block.resize(count, parameters());
      if (!evaluate(i, x, part, J != nullptr ? &block : nullptr)) return false;
      const auto w = weight.segment(first, count);
      part = -part.cwiseProduct(w).eval();
      if (J != nullptr) J->middleRows(first, count) = w.asDiagonal() * block;
      if (whiten.empty()) continue;
      part = (whiten[k] * part).eval();
      if (J != nullptr) J->middleRows(first, count) = whiten[k] * block;
    }
    return true;
  };
  if (!kernels && whiten.empty()) result.normal = normal_equations(*this, weight);
  return result;
}

double ObservationSpace::rmse(const VectorXd& x) const {
  if (samples() == 0) return 0.0;
  VectorXd e(rows());
  for (int i = 0; i < samples(); ++i) {
    const int first = first_row[static_cast<std::size_t>(i)];
    if (!evaluate(i, x, e.segment(first, rows(i)), nullptr)) {
      return std::numeric_limits<double>::infinity();
    }
  }
  const double sum = e.squaredNorm();
  return std::isfinite(sum) ? std::sqrt(sum / samples())
                            : std::numeric_limits<double>::infinity();
}

double ObservationSpace::mean_sigma() const {
  return sigma_mm.size() > 0
             ? std::sqrt(sigma_mm.squaredNorm() / static_cast<double>(sigma_mm.size()))
             : 0.0;
}

std::optional<int> ObservationSpace::find(std::string_view parameter) const {
  for (int i = 0; i < parameters(); ++i) {
    if (parameter_info[static_cast<std::size_t>(i)].name == parameter) return i;
  }
  return std::nullopt;
}

MatrixXd position_errors(const ObservationSpace& space, const VectorXd& x) {
  const int measured = measured_count(space);
  MatrixXd result(space.position_axes, measured);
  for (int i = 0; i < measured; ++i) {
    if (!space.position_error(i, x, result.col(i))) {
      result.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return result;
}

double position_rmse(const ObservationSpace& space, const VectorXd& x) {
  if (space.samples() == 0) return 0.0;
  const MatrixXd errors = position_errors(space, x);
  const double sum = errors.squaredNorm();
  if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
  return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(errors.cols(), 1)));
}

std::optional<RepeatNoise> repeat_noise(const ObservationSpace& space) {
  if (reads_the_same(space)) return std::nullopt;
  std::map<int, std::vector<int>> by_point;
  for (int i = 0; i < space.samples(); ++i) {
    by_point[space.point[static_cast<std::size_t>(i)]].push_back(i);
  }
  Pool pool;
  for (const auto& [point, members] : by_point) {
    const auto first = space.joints.col(members.front());
    const bool same_pose = std::ranges::all_of(members, [&](int i) {
      for (Eigen::Index joint = 0; joint < space.joints.rows(); ++joint) {
        const auto& info = space.joint_info[static_cast<std::size_t>(joint)];
        if (std::abs(space.joints(joint, i) - first[joint]) > geometry::same_pose(info.unit)) {
          return false;
        }
      }
      return true;
    });
    if (!same_pose) continue;
    std::map<int, std::vector<double>> values;  // by channel
    for (const int i : members) {
      const auto k = static_cast<std::size_t>(i);
      for (int row = space.first_row[k]; row < space.first_row[k + 1]; ++row) {
        values[space.channel[static_cast<std::size_t>(row)]].push_back(space.measured_mm[row]);
      }
    }
    for (const auto& [channel, same] : values) pool.add(same);
  }
  if (pool.freedom == 0) return std::nullopt;
  return RepeatNoise{std::sqrt(pool.sum / pool.freedom), pool.freedom};
}

tl::expected<std::vector<char>, std::string> fixed_by_name(
    const ObservationSpace& space, std::span<const std::string> names) {
  std::vector<char> fixed(static_cast<std::size_t>(space.parameters()), 0);
  for (const std::string& name : names) {
    const auto index = space.find(name);
    if (!index) return tl::unexpected(name);
    fixed[static_cast<std::size_t>(*index)] = 1;
  }
  return fixed;
}

bool is_fixed(const std::vector<char>& fixed, int parameter) {
  const auto i = static_cast<std::size_t>(parameter);
  return i < fixed.size() && fixed[i] != 0;
}

}  // namespace sixdial::calibration
