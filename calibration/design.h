// Which poses to measure next: greedily those that tell most beyond what is known already.
// D-optimal shrinks the volume of the parameters' uncertainty, I-optimal the mean variance of
// the tool's position over the workspace, which is what a user of the robot sees.
//
//   M = M_0 + sum J' R^-1 J,   D: max log det M,   I: min mean trace(J_w M^-1 J_w')
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calibration/workspace.h"

namespace sixdial::calibration {

enum class Criterion { kD, kI };
/// "D", "I".
[[nodiscard]] std::string_view to_string(Criterion criterion);
[[nodiscard]] std::optional<Criterion> criterion_from(std::string_view text);

struct DesignCandidate {
  WorkspacePose pose;
  Eigen::MatrixXd covariance_mm2;  // of a position measured there
};

struct DesignStep {
  std::size_t candidate = 0;
  WorkspaceUncertainty uncertainty;  // over the workspace, with this and all before it
};

/// Up to `count` candidates, best first, each at most `most_each` times. `information`: inverse
/// covariance of the parameters so far, positive definite (a prior at least). Candidates
/// and poses that v cannot reach are passed over.
[[nodiscard]] std::vector<DesignStep> greedy_design(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& information,
    std::span<const DesignCandidate> candidates, std::span<const WorkspacePose> workspace,
    int count, Criterion criterion, int most_each = 1);

}  // namespace sixdial::calibration
