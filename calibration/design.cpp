#include "calibration/design.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Known {
  std::size_t candidate;
  MatrixXd J;
  MatrixXd R;
  int taken = 0;
};

}  // namespace

std::string_view to_string(Criterion criterion) {
  return criterion == Criterion::kD ? "D" : "I";
}

std::optional<Criterion> criterion_from(std::string_view text) {
  for (const Criterion each : {Criterion::kD, Criterion::kI}) {
    if (to_string(each) == text) return each;
  }
  return std::nullopt;
}

std::vector<DesignStep> greedy_design(
    const geometry::Tool& tool, const VectorXd& v, const MatrixXd& information,
    std::span<const DesignCandidate> candidates, std::span<const WorkspacePose> workspace,
    int count, Criterion criterion, int most_each) {
  std::vector<Known> known;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const WorkspacePose& pose = candidates[i].pose;
    const auto d = tool.derivative(v, pose.q, pose.assembly);
    if (d) known.push_back({i, d->J_v, candidates[i].covariance_mm2});
  }
  // Mean of J_w' J_w: the mean position variance is trace(mean P).
  const MatrixXd one = MatrixXd::Identity(v.size(), v.size());
  MatrixXd mean = MatrixXd::Zero(v.size(), v.size());
  int poses = 0;
  for (const WorkspacePose& pose : workspace) {
    const auto d = tool.derivative(v, pose.q, pose.assembly);
    if (!d) continue;
    mean += d->J_v.transpose() * d->J_v;
    ++poses;
  }
  if (poses > 0) mean /= poses;

  MatrixXd M = information;
  std::vector<DesignStep> steps;
  while (static_cast<int>(steps.size()) < count) {
    const MatrixXd P = M.ldlt().solve(one);
    const MatrixXd PmeanP = P * mean * P;
    Known* best = nullptr;
    double best_gain = 0.0;
    for (Known& each : known) {
      if (each.taken >= most_each) continue;
      const MatrixXd S = each.J * P * each.J.transpose() + each.R;
      // Matrix determinant lemma, and Woodbury's identity inside the trace.
      const double gain = criterion == Criterion::kD
                              ? std::log(S.determinant() / each.R.determinant())
                              : (S.inverse() * (each.J * PmeanP * each.J.transpose())).trace();
      if (best == nullptr || gain > best_gain) {
        best = &each;
        best_gain = gain;
      }
    }
    if (best == nullptr) break;
    ++best->taken;
    M += best->J.transpose() * best->R.inverse() * best->J;
    steps.push_back(
        {best->candidate, workspace_uncertainty(tool, v, M.ldlt().solve(one), workspace)});
  }
  return steps;
}

}  // namespace sixdial::calibration
