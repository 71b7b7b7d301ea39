#include "calibration/design.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Known {
  std::size_t candidate;
  DesignRows rows;
  int taken = 0;
};

/// Mean of J_w' J_w: the mean position variance is trace(mean P).
MatrixXd mean_sensitivity(
    const geometry::Tool& tool, const VectorXd& v, std::span<const WorkspacePose> workspace) {
  MatrixXd mean = MatrixXd::Zero(v.size(), v.size());
  int poses = 0;
  for (const WorkspacePose& pose : workspace) {
    const auto d = tool.derivative(v, pose.q, pose.assembly);
    if (!d) continue;
    mean += d->J_v.transpose() * d->J_v;
    ++poses;
  }
  if (poses > 0) mean /= poses;
  return mean;
}

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

DesignKnowledge::DesignKnowledge(MatrixXd information, MatrixXd JJ, Criterion criterion)
    : M_(std::move(information)), JJ_(std::move(JJ)), criterion_(criterion) {
  settle();
}

void DesignKnowledge::settle() {
  P_ = M_.ldlt().solve(MatrixXd::Identity(M_.rows(), M_.cols()));
  if (criterion_ == Criterion::kI) PJJP_ = P_ * JJ_ * P_;
}

double DesignKnowledge::gain(const DesignRows& rows) const {
  const MatrixXd S = rows.J * P_ * rows.J.transpose() + rows.R;
  // Matrix determinant lemma, and Woodbury's identity inside the trace.
  return criterion_ == Criterion::kD
             ? std::log(S.determinant() / rows.R.determinant())
             : (S.inverse() * (rows.J * PJJP_ * rows.J.transpose())).trace();
}

void DesignKnowledge::add(const DesignRows& rows) {
  M_ += rows.J.transpose() * rows.R.inverse() * rows.J;
  settle();
}

std::vector<DesignStep> greedy_design(
    const geometry::Tool& tool, const VectorXd& v, const MatrixXd& information,
    std::span<const DesignCandidate> candidates, std::span<const WorkspacePose> workspace,
    int count, Criterion criterion, int most_each, const MatrixXd& besides) {
  std::vector<Known> known;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const WorkspacePose& pose = candidates[i].pose;
    const auto d = tool.derivative(v, pose.q, pose.assembly);
    if (d) known.push_back({i, {d->J_v, candidates[i].covariance_mm2}});
  }
  DesignKnowledge so_far(information, mean_sensitivity(tool, v, workspace), criterion);
  std::vector<DesignStep> steps;
  while (static_cast<int>(steps.size()) < count) {
    Known* best = nullptr;
    double best_gain = 0.0;
    for (Known& each : known) {
      if (each.taken >= most_each) continue;
      const double gain = so_far.gain(each.rows);
      if (best == nullptr || gain > best_gain) {
        best = &each;
        best_gain = gain;
      }
    }
    if (best == nullptr) break;
    ++best->taken;
    so_far.add(best->rows);
    MatrixXd covariance = so_far.covariance();
    if (besides.size() > 0) covariance += besides;
    steps.push_back({best->candidate, workspace_uncertainty(tool, v, covariance, workspace)});
  }
  return steps;
}

}  // namespace sixdial::calibration
