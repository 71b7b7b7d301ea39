// How noise and structure move a fit, row by row: shared by the covariance of its parameters
// and that of predicted positions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/fit_covariance.h"

namespace sixdial::calibration {

/// W of one sample.
[[nodiscard]] Eigen::MatrixXd weight_of(
    const std::vector<Eigen::MatrixXd>& weights, int sample, Eigen::Index rows);

/// d(row)/d(what the structure moves): a channel's own function, or the tool's coordinates.
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
    if (!by_tool_.empty()) return by_tool_[k](row, f);
    const auto at = static_cast<std::size_t>(space_.first_row[k] + row);
    return space_.channel[at] == f ? 1.0 : 0.0;
  }

 private:
  const ObservationSpace& space_;
  std::vector<Eigen::MatrixXd> by_tool_;
};

/// A of the sandwich with the weights that each row has, sample by sample.
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

/// All that may be, or the likeliest where nothing else is known.
[[nodiscard]] std::vector<StructurePart> parts_of(const Structure& structure);

}  // namespace sixdial::calibration
