// How noise and structure (fit_covariance.h: something smooth that the model lacks) move a fit,
// row by row. A weighted least-squares fit is linear near its end: change of the parameters =
// A W (change of the rows), with the weights W of each sample and A = (J'W'W J)^-1 J'W'. So
// rows of covariance S give A W S W'A', the sandwich. Shared by the covariance of the
// parameters and that of predicted positions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/fit_covariance.h"

namespace sixdial::calibration {

/// Weight matrix of one sample, rows x rows; the identity if `weights` is empty.
[[nodiscard]] Eigen::MatrixXd weight_of(
    const std::vector<Eigen::MatrixXd>& weights, int sample, Eigen::Index rows);

/// How each row answers to the smooth functions of a structure: one function for each channel,
/// or one for each coordinate of the tool, which all rows of a sample see.
class Moves {
 public:
  Moves(const ObservationSpace& space, const Eigen::VectorXd& x, SmoothActs acts)
      : space_(space) {
    if (acts == SmoothActs::kChannels) return;
    for (int i = 0; i < space.samples(); ++i) by_tool_.push_back(space.by_tool(i, x));
  }
  [[nodiscard]] Eigen::Index functions() const {
    return by_tool_.empty() ? space_.channels() : by_tool_.front().cols();
  }
  /// Of row `row` of a sample: derivative by function f.
  [[nodiscard]] double by(int sample, Eigen::Index row, Eigen::Index f) const {
    const auto k = static_cast<std::size_t>(sample);
    if (space_.sample[k] < 0) return 0.0;  // known, not measured: no pose has a part in it
    if (!by_tool_.empty()) return by_tool_[k](row, f);
    const auto at = static_cast<std::size_t>(space_.first_row[k] + row);
    return space_.channel[at] == f ? 1.0 : 0.0;
  }

 private:
  const ObservationSpace& space_;
  std::vector<Eigen::MatrixXd> by_tool_;
};

/// A W of each sample, with the weights of a robust loss in it.
struct Sandwich {
  std::vector<Eigen::MatrixXd> AW;  // parameters x rows of the sample
  Eigen::MatrixXd noise;            // A S A' for weighted rows of mean variance 1
};

[[nodiscard]] Sandwich sandwich_of(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting);

/// d(parameters)/d(coefficients of the shapes `phi`, samples x shapes), function by function.
[[nodiscard]] Eigen::MatrixXd moved_by(
    const ObservationSpace& space, const Sandwich& sandwich, const Moves& moves,
    const Eigen::MatrixXd& phi);

/// All structures that are possible with their probabilities; just the likeliest where they
/// were not worked out; empty where no structure was seen.
[[nodiscard]] std::vector<StructurePart> parts_of(const Structure& structure);

}  // namespace sixdial::calibration
