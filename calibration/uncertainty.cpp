#include "calibration/uncertainty.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "calibration/predicted_position.h"

namespace sixdial::calibration {
namespace {

using simulation::Trial;

/// Radius that holds all axes at once over the interval of one, 95 %.
double circle_over_interval(int axes) {
  return std::sqrt(boost::math::quantile(boost::math::chi_squared(axes), 0.95)) / kNormal_95;
}

}  // namespace

std::vector<ParameterEstimate> estimates_with_noise(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    const NoiseEstimate& noise, const Structure& structure, Eigen::MatrixXd& covariance) {
  covariance = fit_covariance(space, fit, weighting, noise.spread_mm, structure);
  auto result = parameter_estimates(fit, space.nominal, covariance, space.parameter_names());
  const double quantile = quantile_95(noise);
  for (ParameterEstimate& each : result) {
    if (!noise.known && !each.fixed) each.sd = std::numeric_limits<double>::quiet_NaN();
    each.low_95 = each.value - quantile * each.sd;
    each.high_95 = each.value + quantile * each.sd;
  }
  return result;
}

Eigen::MatrixXd held_covariance(
    const LeastSquaresFit& fit, std::span<const geometry::ParameterInfo> infos) {
  const auto n = static_cast<Eigen::Index>(infos.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  if (fit.held == 0 || fit.directions.rows() != n) return covariance;
  Eigen::VectorXd variance(n);  // before any sample, in scaled parameters
  for (Eigen::Index i = 0; i < n; ++i) {
    const geometry::ParameterInfo& info = infos[static_cast<std::size_t>(i)];
    const double known_to = info.known_to > 0.0 ? info.known_to : info.change;
    variance[i] = std::pow(known_to / fit.scale[i], 2);
  }
  // P = S D D' V D D' S, D the held directions
  const Eigen::MatrixXd D = fit.directions.rightCols(fit.held);
  const Eigen::MatrixXd SD = fit.scale.asDiagonal() * D;
  covariance = SD * (D.transpose() * variance.asDiagonal() * D) * SD.transpose();
  return covariance;
}

std::optional<Workspace> workspace_of(std::span<const Trial> trials) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Workspace box;
  for (const Trial& trial : trials) {
    const auto& at = trial.position_mm ? trial.position_mm : trial.target_mm;
    if (!at || !at->allFinite()) continue;
    if (box.low_mm.size() == 0) {
      box.low_mm.setConstant(at->size(), kFar);
      box.high_mm.setConstant(at->size(), -kFar);
    }
    if (at->size() != box.low_mm.size()) continue;
    box.low_mm = box.low_mm.cwiseMin(*at);
    box.high_mm = box.high_mm.cwiseMax(*at);
  }
  if (box.low_mm.size() == 0) return std::nullopt;
  if (!(box.low_mm.head(2).array() < box.high_mm.head(2).array()).all()) return std::nullopt;
  return box;
}

namespace {

/// Covariance of the position at joint values with the derivative J_v there [mm^2].
using CovarianceThere =
    std::function<Eigen::MatrixXd(const Eigen::VectorXd& joints, const Eigen::MatrixXd& J_v)>;

PositionUncertainty map_of(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const CovarianceThere& covariance,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, int columns, int rows) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  PositionUncertainty map;
  map.columns = columns;
  map.rows = rows;
  const auto at = [](double low, double high, int i, int n) {
    return n > 1 ? low + (high - low) * i / (n - 1) : 0.5 * (low + high);
  };
  for (int i = 0; i < columns; ++i) {
    map.x_mm.push_back(at(workspace.low_mm.x(), workspace.high_mm.x(), i, columns));
  }
  for (int i = 0; i < rows; ++i) {
    map.y_mm.push_back(at(workspace.low_mm.y(), workspace.high_mm.y(), i, rows));
  }
  const double radius_of = circle_over_interval(tool.axes()) * quantile;
  geometry::Position p = 0.5 * (workspace.low_mm + workspace.high_mm);
  map.held_effect_mm.assign(static_cast<std::size_t>(fit.held), 0.0);
  double sum = 0.0;
  int count = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      p[0] = map.x_mm[static_cast<std::size_t>(column)];
      p[1] = map.y_mm[static_cast<std::size_t>(row)];
      const auto q = tool.inverse(v, p, mode);
      const auto d = q.and_then([&](const Eigen::VectorXd& joints) {
        return tool.assembly_at(v, joints, p).and_then([&](geometry::Assembly assembly) {
          return tool.derivative(v, joints, assembly);
        });
      });
      if (!d) {
        map.sd_mm.emplace_back(Eigen::VectorXd::Constant(tool.axes(), kNone));
        map.radius_95_mm.push_back(kNone);
        continue;
      }
      const Eigen::MatrixXd P = covariance(*q, d->J_v);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(P);
      const double longest = std::sqrt(std::max(axes.eigenvalues()[tool.axes() - 1], 0.0));
      map.sd_mm.push_back(P.diagonal().cwiseMax(0.0).cwiseSqrt());
      map.radius_95_mm.push_back(radius_of * longest);
      const double sd = map.sd_mm.back().norm();
      sum += sd * sd;
      ++count;
      if (sd >= map.max_sd_mm) {
        map.max_sd_mm = sd;
        map.worst_mm = p;
      }
      map.max_radius_95_mm = std::max(map.max_radius_95_mm, map.radius_95_mm.back());
      for (int k = 0; k < fit.held; ++k) {
        const Eigen::VectorXd direction =
            fit.scale.cwiseProduct(fit.directions.col(fit.directions.cols() - fit.held + k));
        double& effect = map.held_effect_mm[static_cast<std::size_t>(k)];
        effect = std::max(effect, (d->J_v * direction.head(v.size())).norm());
      }
    }
  }
  map.mean_sd_mm = count > 0 ? std::sqrt(sum / count) : kNone;
  return map;
}

}  // namespace

PositionUncertainty position_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& covariance,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, double structure_mm, int columns, int rows) {
  const Eigen::MatrixXd C = covariance.topLeftCorner(v.size(), v.size());
  const auto there = [&](const Eigen::VectorXd&, const Eigen::MatrixXd& J_v) {
    Eigen::MatrixXd P = J_v * C * J_v.transpose();
    P.diagonal().array() += structure_mm * structure_mm;
    return P;
  };
  return map_of(tool, v, there, fit, mode, workspace, quantile, columns, rows);
}

PositionUncertainty position_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const PredictedPosition& predicted,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, int columns, int rows) {
  const auto there = [&](const Eigen::VectorXd& joints, const Eigen::MatrixXd& J_v) {
    return predicted.covariance(joints, J_v);
  };
  return map_of(tool, v, there, fit, mode, workspace, quantile, columns, rows);
}

}  // namespace sixdial::calibration
