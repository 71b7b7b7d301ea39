// The part of the noise that all readings of one arrival share: a robot does not come to the
// same place twice. Readings of a sample are then no independent witnesses:
//
//   e = simulated part + B v + noise,   v ~ N(0, ratio s^2 I) for each arrival
//
// with B = d(reading)/d(shift): of the tool in the plane (2 columns), or of the joint values
// (one for each joint). With B~ = sqrt(ratio) D B and D = 1 / (noise of each reading, in s),
// the readings' covariance is s^2 D^-1 (I + B~ B~') D^-1, block by block; Whitening takes the
// square root of its inverse, which is the identity but for k directions of each block.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace sixdial::diagnosis {

enum class ScatterOf { kTool, kJoints };

/// What could be shared, and by which readings.
struct ScatterColumns {
  ScatterOf of = ScatterOf::kTool;
  bool of_stops = false;                // samples without a move between them share it too
  Eigen::MatrixXd columns;              // B, count x k [mm per mm, mm per unit of the joint]
  std::vector<Eigen::Index> first_row;  // of each block of rows that share a shift; and the end
  [[nodiscard]] std::size_t blocks() const { return first_row.size() - 1; }
};

/// Makes noise independent and alike: W with W'W = s^2 x (covariance of the readings)^-1.
class Whitening {
 public:
  /// Independent readings: W = diag(root).
  explicit Whitening(Eigen::VectorXd root) : root_(std::move(root)) {}
  /// `shared` may be null.
  Whitening(Eigen::VectorXd root, const ScatterColumns* shared, double ratio);

  [[nodiscard]] bool independent() const { return scaled_.size() == 0; }
  [[nodiscard]] const Eigen::VectorXd& root() const { return root_; }
  /// W X, and W'X.
  [[nodiscard]] Eigen::MatrixXd operator()(const Eigen::MatrixXd& X) const;
  [[nodiscard]] Eigen::MatrixXd transposed(const Eigen::MatrixXd& X) const;
  /// (I + B~B~')^-1/2 X.
  [[nodiscard]] Eigen::MatrixXd spread(Eigen::MatrixXd X) const;
  /// C'W'W C for columns C on some rows only (in rising order), the others zero.
  [[nodiscard]] Eigen::MatrixXd normal(
      const Eigen::MatrixXd& C, const std::vector<Eigen::Index>& rows) const;

  /// The likeliest shifts, given what the simulation leaves.
  struct Shifts {
    Eigen::VectorXd in_readings_mm;  // B v
    double squares = 0.0;            // |v|^2 / ratio [mm^2]: counts among the squares of s
  };
  [[nodiscard]] Shifts shifts_of(const Eigen::VectorXd& residual_mm) const;
  /// How much of each reading's freedom the shifts use up, between 0 and 1.
  [[nodiscard]] Eigen::VectorXd leverage() const;
  /// Sum of ln det(I + B~'B~).
  [[nodiscard]] double log_volume() const { return log_volume_; }

 private:
  [[nodiscard]] Eigen::MatrixXd along(const Eigen::MatrixXd& X) const;

  Eigen::VectorXd root_;
  Eigen::MatrixXd scaled_;  // B~, turned so that B~'B~ of each block is diagonal
  std::vector<Eigen::Index> first_row_;
  Eigen::MatrixXd lambda_;  // blocks x k: that diagonal
  double log_volume_ = 0.0;
};

/// What a fit has left, for a question about its noise: whether something is shared.
struct LeftOver {
  const Eigen::VectorXd& root;         // 1 / noise of each reading in s; 0: not counted
  const Eigen::VectorXd& residual_mm;  // shared part and all
  const Eigen::MatrixXd& fitted;       // columns of the parameters, count x p
  const Eigen::MatrixXd& random;       // C of joint_fit.h, count x m
  const Eigen::VectorXd& u;
  double freedom = 0.0;  // counted readings less fitted parameters
};

struct ScatterSize {
  double ratio = 0.0;  // variance of the shift over s^2
  double gain = 0.0;   // residual log likelihood with it less without
  // Standard deviation of the shift [mm, or unit of the joints], and its 95 % interval.
  double sd = 0.0, low = 0.0, high = 0.0;
};
struct ScatterQuestion {
  double near = 0.0;  // ratio of a similar fit, 0: none is known
  bool with_interval = false;
};

/// Cheap: whether a closer look could find anything shared.
[[nodiscard]] bool may_be_shared(const LeftOver& left, const ScatterColumns& columns);
/// The most likely size by residual maximum likelihood, which looks only at what no change of
/// the parameters explains. Empty where nothing shared makes the readings likelier.
[[nodiscard]] std::optional<ScatterSize> scatter_size(
    const LeftOver& left, const ScatterColumns& columns, const ScatterQuestion& asked = {});

}  // namespace sixdial::diagnosis
