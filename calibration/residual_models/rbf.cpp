// Radial basis functions (the paper's [22]): Gaussians around a spread-out choice of the
// measured angles, ridge least squares, width and ridge by leave-one-out errors.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "calibration/anfis_selection.h"
#include "calibration/pose_groups.h"
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostCentres = 60;
constexpr double kWidths[] = {0.3, 0.5, 0.8, 1.2, 2.0};  // standardised angles

/// Farthest-point choice: each next centre is the sample farthest from those chosen.
MatrixXd centres_of(const MatrixXd& x) {
  const auto count = std::min<Eigen::Index>(kMostCentres, (x.rows() + 1) / 2);
  MatrixXd centres(count, x.cols());
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

MatrixXd functions_at(const MatrixXd& x, const MatrixXd& centres, double width) {
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

Net fit(
    const MatrixXd& x, const MatrixXd& centres, const VectorXd& y,
    const std::vector<std::vector<int>>& poses) {
  const std::vector<double> ridges{1e-4, 1e-3, 1e-2, 1e-1, 1.0};
  Net best;
  for (const double width : kWidths) {
    const MatrixXd A = functions_at(x, centres, width);
    std::vector<double> effective;
    const MatrixXd errors = LeaveOneOut(A).errors(y, ridges, poses, effective);
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

void save(const Net& net, const std::string& prefix, SavedResidual& saved) {
  saved[prefix + "width"] = number_to_save(net.width);
  saved[prefix + "weights"] = net.weights;
  saved[prefix + "effective_parameters"] = number_to_save(net.effective);
}

TrainedResidual load(const SavedResidual& saved) {
  const Standardiser standard(saved);
  const MatrixXd centres = saved_matrix(saved, "centres", -1, standard.mean.size());
  const Eigen::Index outputs = saved_outputs(saved);
  std::vector<Net> nets;
  TrainedResidual result;
  result.effective_parameters.resize(outputs);
  for (Eigen::Index k = 0; k < outputs; ++k) {
    const std::string prefix = output_prefix(k);
    Net net;
    net.width = saved_number(saved, prefix + "width");
    net.weights = saved_matrix(saved, prefix + "weights", centres.rows(), 1);
    result.effective_parameters[k] = saved_number(saved, prefix + "effective_parameters");
    nets.push_back(std::move(net));
  }
  result.correction = [standard, centres, nets = std::move(nets)](const VectorXd& q) {
    const MatrixXd at = standard(q.transpose());
    VectorXd answer(std::ssize(nets));
    for (std::size_t k = 0; k < nets.size(); ++k) {
      answer[static_cast<Eigen::Index>(k)] =
          functions_at(at, centres, nets[k].width).row(0).dot(nets[k].weights);
    }
    return answer;
  };
  return result;
}

TrainedResidual train(
    const MatrixXd& joints, const MatrixXd& residual_mm, const ResidualSettings& settings,
    const std::stop_token&) {
  const Standardiser standard(joints);
  const MatrixXd x = standard(joints);
  const MatrixXd centres = centres_of(x);
  const std::vector<std::vector<int>> poses = rows_by_group(pose_groups(joints));
  std::vector<Net> nets;
  SavedResidual saved;
  standard.save(saved);
  saved["centres"] = centres;
  save_outputs(residual_mm.cols(), saved);
  for (Eigen::Index k = 0; k < residual_mm.cols(); ++k) {
    nets.push_back(fit(x, centres, residual_mm.col(k), poses));
    save(nets.back(), output_prefix(k), saved);
  }
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note = fmt::format("{} centres; ", centres.rows()) +
                by_output(settings, residual_mm.cols(), [&](Eigen::Index k) {
                  const Net& net = nets[static_cast<std::size_t>(k)];
                  return fmt::format("width {}, ridge {:g}", net.width, net.ridge);
                });
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
