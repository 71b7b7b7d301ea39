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

/// What measuring at one candidate tells of the parameters: d(measured)/d(parameters), and the
/// covariance of what is measured.
struct DesignRows {
  Eigen::MatrixXd J;  // rows x n
  Eigen::MatrixXd R;  // rows x rows
};

/// What is known of the parameters while candidates are added one by one.
class DesignKnowledge {
 public:
  /// `information`: inverse covariance so far, positive definite (a prior at least). `JJ`: mean
  /// of J_w' J_w over the workspace, of kI.
  DesignKnowledge(Eigen::MatrixXd information, Eigen::MatrixXd JJ, Criterion criterion);
  /// How much a candidate would tell: the gain in log det M, or the loss of mean variance.
  [[nodiscard]] double gain(const DesignRows& rows) const;
  void add(const DesignRows& rows);
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return P_; }

 private:
  void settle();
  Eigen::MatrixXd M_, JJ_, P_, PJJP_;
  Criterion criterion_;
};

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
/// and poses that v cannot reach are passed over. `besides`: covariance of the parameters that
/// measuring takes nothing away from, in the uncertainties that are told; 0 x 0: none.
[[nodiscard]] std::vector<DesignStep> greedy_design(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& information,
    std::span<const DesignCandidate> candidates, std::span<const WorkspacePose> workspace,
    int count, Criterion criterion, int most_each = 1, const Eigen::MatrixXd& besides = {});

}  // namespace sixdial::calibration
