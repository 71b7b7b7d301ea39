#include "diagnosis/absorbers.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstddef>

namespace sixdial::diagnosis {

std::vector<std::string> absorbers(
    std::span<const geometry::ParameterInfo> parameters, const Eigen::VectorXd& raw,
    const Eigen::MatrixXd& J) {
  const Eigen::MatrixXd A =
      J.leftCols(std::min(J.cols(), static_cast<Eigen::Index>(parameters.size())));
  Eigen::VectorXd norm = A.colwise().norm();
  norm = norm.cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = A * norm.cwiseInverse().asDiagonal();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod;
  cod.setThreshold(1e-9);
  cod.compute(scaled);
  const Eigen::VectorXd share = cod.solve(raw).cwiseAbs();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(share.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return share[a] != share[b] ? share[a] > share[b] : a < b;
  });
  constexpr double kWorthNaming = 0.25;  // of the largest
  constexpr std::size_t kMost = 4;
  std::vector<std::string> result;
  for (const Eigen::Index i : order) {
    if (result.size() == kMost || !(share[i] > kWorthNaming * share[order[0]])) break;
    const std::string& name = parameters[static_cast<std::size_t>(i)].name;
    result.push_back(name == "clamp" ? "clamp angle" : name);
  }
  return result;
}

}  // namespace sixdial::diagnosis
