// Something without a name, as limits_of holds it against an effect: the same random columns
// against many residuals, each with the effect and with other noise.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/evidence.h"
#include "diagnosis/joint_fit.h"
#include "diagnosis/unknown.h"

namespace sixdial::diagnosis {

class UnnamedRival {
 public:
  /// `cost`: of its search, in log evidence, with all that a name is preferred by. `noise`:
  /// n x draws, weighted and off everything fitted.
  UnnamedRival(
      UnknownKind kind, double cost, const Projector& projector, const Eigen::MatrixXd& noise,
      const std::vector<RandomBox>& boxes);

  [[nodiscard]] UnknownKind kind() const { return kind_; }

  /// Its columns' x those of an effect (n x k, projected), box by box.
  using Shared = std::vector<Eigen::MatrixXd>;
  [[nodiscard]] Shared shared_with(const Eigen::MatrixXd& columns) const;

  /// Log evidence, less its cost, for the residual that an effect of sizes `x` leaves.
  [[nodiscard]] double evidence(
      const Shared& shared, const Eigen::VectorXd& x, double sse, double freedom) const;
  /// The same with noise number `draw` in the residual.
  [[nodiscard]] double evidence(
      const Shared& shared, const Eigen::VectorXd& x, int draw, double sse,
      double freedom) const;

 private:
  struct Length {
    Eigen::VectorXd spread;
    MarginalEvidence evidence;
  };
  struct Part {
    Eigen::MatrixXd weighted;
    Eigen::MatrixXd noise;  // weighted' x noise, one column a draw
    std::vector<Length> lengths;
  };
  UnknownKind kind_;
  double cost_;
  std::vector<Part> parts_;
};

}  // namespace sixdial::diagnosis
