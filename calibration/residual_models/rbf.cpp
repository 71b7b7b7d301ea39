// Radial basis functions (the paper's [22]): Gaussians around a spread-out choice of the
// measured angles, ridge least squares, width and ridge by leave-one-out errors.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "calibration/anfis_selection.h"
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixX2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostCentres = 60;
constexpr double kWidths[] = {0.3, 0.5, 0.8, 1.2, 2.0};  // standardised angles

/// Farthest-point choice: each next centre is the sample farthest from those chosen.
MatrixX2d centres_of(const MatrixX2d& x) {
  const auto count = std::min<Eigen::Index>(kMostCentres, (x.rows() + 1) / 2);
  MatrixX2d centres(count, 2);
  VectorXd distance = VectorXd::Constant(x.rows(), std::numeric_limits<double>::infinity());
  Eigen::Index next = 0;
  x.rowwise().squaredNorm().minCoeff(&next);
  for (Eigen::Index k = 0; k < count; ++k) {
    centres.row(k) = x.row(next);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      distance[i] = std::min(distance[i], (x.row(i) - x.row(next)).squaredNorm());
    }
    distance.maxCoeff(&next);
  }
  return centres;
}

MatrixXd functions_at(const MatrixX2d& x, const MatrixX2d& centres, double width) {
  MatrixXd A(x.rows(), centres.rows());
  for (Eigen::Index k = 0; k < centres.rows(); ++k) {
    A.col(k) = (-(x.rowwise() - centres.row(k)).rowwise().squaredNorm() / (2 * width * width))
                   .array()
                   .exp();
  }
  return A;
}

struct Net {
  double width = 1.0;
  double ridge = 0.0;
  double effective = 0.0;
  double loo = std::numeric_limits<double>::infinity();
  VectorXd weights;
};

Net fit(const MatrixX2d& x, const MatrixX2d& centres, const VectorXd& y) {
  const std::vector<double> ridges{1e-4, 1e-3, 1e-2, 1e-1, 1.0};
  Net best;
  for (const double width : kWidths) {
    const MatrixXd A = functions_at(x, centres, width);
    std::vector<double> effective;
    const MatrixXd errors = leave_one_out_errors(A, y, ridges, effective);
    for (std::size_t k = 0; k < ridges.size(); ++k) {
      const double loo = errors.col(static_cast<Eigen::Index>(k)).squaredNorm();
      if (loo >= best.loo) continue;
      best.width = width;
      best.ridge = ridges[k];
      best.effective = effective[k];
      best.loo = loo;
    }
  }
  const MatrixXd A = functions_at(x, centres, best.width);
  MatrixXd G = A.transpose() * A;
  G.diagonal().array() += best.ridge;
  best.weights = G.llt().solve(A.transpose() * y);
  return best;
}

TrainedResidual load(const SavedResidual& saved) {
  const Standardiser standard(saved);
  const MatrixX2d centres = saved_matrix(saved, "centres", -1, 2);
  struct Axis {
    double width;
    VectorXd weights;
  };
  const auto axis = [&](const std::string& name) {
    return Axis{
        saved_number(saved, name + ".width"),
        saved_matrix(saved, name + ".weights", centres.rows(), 1)};
  };
  TrainedResidual result;
  result.effective_parameters = {
      saved_number(saved, "x.effective_parameters"),
      saved_number(saved, "y.effective_parameters")};
  result.correction = [standard, centres, x = axis("x"),
                       y = axis("y")](const Eigen::Vector2d& q) {
    const MatrixX2d at = standard(q.transpose());
    const auto answer = [&](const Axis& net) {
      return functions_at(at, centres, net.width).row(0).dot(net.weights);
    };
    return Eigen::Vector2d(answer(x), answer(y));
  };
  return result;
}

void save(const Net& net, const std::string& axis, SavedResidual& saved) {
  saved[axis + ".width"] = MatrixXd::Constant(1, 1, net.width);
  saved[axis + ".weights"] = net.weights;
  saved[axis + ".effective_parameters"] = MatrixXd::Constant(1, 1, net.effective);
}

TrainedResidual train(
    const MatrixX2d& q_rad, const MatrixX2d& residual_mm, const ResidualSettings&,
    const std::stop_token&) {
  const Standardiser standard(q_rad);
  const MatrixX2d x = standard(q_rad);
  const MatrixX2d centres = centres_of(x);
  const Net net_x = fit(x, centres, residual_mm.col(0));
  const Net net_y = fit(x, centres, residual_mm.col(1));
  SavedResidual saved;
  standard.save(saved);
  saved["centres"] = centres;
  save(net_x, "x", saved);
  save(net_y, "y", saved);
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note = fmt::format(
      "{} centres; x: width {}, ridge {:g}; y: width {}, ridge {:g}", centres.rows(),
      net_x.width, net_x.ridge, net_y.width, net_y.ridge);
  return result;
}

}  // namespace

extern constinit const ResidualModel rbf{
    .name = "rbf",
    .title = "RBF",
    .description = "radial basis functions, width and ridge by leave-one-out",
    .train = train,
    .load = load};

}  // namespace sixdial::calibration
