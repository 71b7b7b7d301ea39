// One calibration problem as every method sees it: samples with rows of measured values that a
// parameter vector x predicts. Parameters, joints and channels are named lists of any length;
// which robot and which instrument they belong to is known only to the code that built the
// space (rig_spaces.h).
//
// Example:
//   const Identified found = identify(*find_identifier("lm"), space);
//   space.rmse(found.x) < space.rmse(space.nominal);  // -> true
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "calibration/least_squares.h"
#include "geometry/robot_kind.h"

namespace sixdial::calibration {

using geometry::ParameterInfo;

struct SpaceJoint {
  std::string name;  // "q1", "shoulder"
  std::string unit;  // "rad", "mm"
};
struct SpaceChannel {
  std::string name;  // "x", or a dial's id
  std::string unit;  // "mm"
};

/// Where a filter takes f and J.
enum class Linearisation {
  kNominal,   // as printed, (11): a linear filter
  kEstimate,  // at the current estimate: what "extended" means
};

/// Many parameter vectors and all samples in one call: for speed only. Each does what the space
/// does sample by sample, up to rounding; a law test holds them together. Called from several
/// threads at once.
struct BatchKernels {
  /// ObservationSpace::rmse of each column of x (n x any).
  std::function<void(const Eigen::MatrixXd& x, Eigen::Ref<Eigen::ArrayXd> rmse_mm)> rmse;
  /// Equations (17)-(22) over all samples for each column of `noise` (diag Q, then R by
  /// channel): errors x - nominal after the last sample, n x columns. A filter that breaks
  /// leaves NaN. `p0`: diagonal of P0.
  std::function<void(
      Linearisation linearisation, const Eigen::VectorXd& p0, const Eigen::MatrixXd& noise,
      Eigen::MatrixXd& errors)>
      filter;
  /// ObservationSpace::problem(Weighting::kAlike), with normal equations.
  LeastSquaresProblem problem;
};

/// How rows count in a fit.
enum class Weighting {
  kAlike,         // every row the same, as (31)
  kBySigma,       // each by its standard deviation
  kByCovariance,  // a sample's rows by their covariance, correlations included
};

struct ObservationSpace {
  std::string name;                           // "positions", "dials"
  std::vector<ParameterInfo> parameter_info;  // n
  Eigen::VectorXd nominal;                    // n
  /// What the robot's kind has words for.
  std::vector<geometry::NamedDirection> named_directions;
  std::vector<SpaceJoint> joint_info;
  std::vector<SpaceChannel> channel_info;

  // By sample.
  Eigen::MatrixXd joints;   // joints x samples: what the encoders say
  std::vector<int> sample;  // row of the session
  std::vector<int> point;   // samples of one point are repeats: the plan says so
  std::vector<int> repeat;
  std::vector<int> first_row{0};  // samples + 1: rows of sample i start at [i]
  /// Covariance of each sample's rows; 0 x 0 where it is not known. Empty: known of no sample.
  std::vector<Eigen::MatrixXd> covariance_mm2;

  // By row.
  std::vector<int> channel;
  Eigen::VectorXd measured_mm;
  Eigen::VectorXd sigma_mm;  // standard deviation of the reading
  /// sigma_mm is a default, as neither rig file nor session say how good a reading is.
  bool sigma_is_assumed = false;

  /// Change of each row [mm] where a quantity of the rig that its file states with a standard
  /// deviation is off by that, rows x quantities; no columns: nothing is stated (rig_errors.h).
  Eigen::MatrixXd rig_mm;

  /// e = measured - predicted [mm] of one sample (problem() has the other sign) and, unless
  /// null, J = d(predicted)/dx (rows x n). Both come in with the right size. False if x cannot
  /// reach the pose.
  std::function<bool(
      int sample, const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> e, Eigen::MatrixXd* J)>
      evaluate;

  /// d(predicted)/d(position of the tool) of one sample at x, rows x axes: what all its rows
  /// see if the tool is somewhere else. Empty where the rows are that position, or nobody
  /// knows.
  std::function<Eigen::MatrixXd(int sample, const Eigen::VectorXd& x)> by_tool;

  /// Where the instrument gives the tool's position: its coordinates, and measured - modelled
  /// position of one sample. 0 and empty where it does not.
  int position_axes = 0;
  std::function<bool(int sample, const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> e)>
      position_error;
  /// Measured position - target, position_axes x samples; NaN where a sample has no target.
  Eigen::MatrixXd off_target_mm;

  /// Rows of one sample belong together (a position's coordinates): a robust loss takes or
  /// leaves them as a whole, and by default they weigh the same. Else each row is taken by
  /// itself and weighs 1/sigma.
  bool rows_belong_together = false;
  /// Unknowns that evaluate() settles for each sample by itself (a freely held cuboid's angle).
  int unknowns_per_sample = 0;
  /// Searches draw from this random stream and the next one; starts of searches from those 16
  /// and 17 later.
  std::uint32_t random_stream = 3;
  std::shared_ptr<const BatchKernels> kernels;  // null: none

  [[nodiscard]] int parameters() const { return static_cast<int>(nominal.size()); }
  [[nodiscard]] int channels() const { return static_cast<int>(channel_info.size()); }
  [[nodiscard]] int samples() const { return static_cast<int>(first_row.size()) - 1; }
  [[nodiscard]] int rows() const { return first_row.back(); }
  /// Rows of one sample.
  [[nodiscard]] int rows(int of_sample) const {
    const auto i = static_cast<std::size_t>(of_sample);
    return first_row[i + 1] - first_row[i];
  }
  /// Rows that a robust loss takes as one.
  [[nodiscard]] int block() const;
  /// ParameterInfo::change of each: directions of parameter space are measured in these.
  [[nodiscard]] Eigen::VectorXd scale() const;
  /// Views of ParameterInfo::name: valid as long as this space.
  [[nodiscard]] std::vector<std::string_view> parameter_names() const;
  /// Residuals predicted - measured of all rows. Weights are relative to the mean, so that
  /// weighted residuals stay in mm. The space must outlive the problem.
  [[nodiscard]] LeastSquaresProblem problem(Weighting weighting) const;
  /// What problem(weighting) multiplies the residuals of each sample with, rows x rows; empty:
  /// nothing.
  [[nodiscard]] std::vector<Eigen::MatrixXd> weights(Weighting weighting) const;
  /// Root of the mean over samples of the squared error length, unweighted [mm]; +inf if a pose
  /// cannot be reached.
  [[nodiscard]] double rmse(const Eigen::VectorXd& x) const;
  /// Root mean square of sigma_mm.
  [[nodiscard]] double mean_sigma() const;
  /// Index of a parameter by name.
  [[nodiscard]] std::optional<int> find(std::string_view parameter) const;
};

/// measured - modelled position, position_axes x samples [mm]; a column is NaN where x cannot
/// reach the pose. Only for a space with position_axes > 0.
[[nodiscard]] Eigen::MatrixXd position_errors(
    const ObservationSpace& space, const Eigen::VectorXd& x);
/// Root of the mean squared distance (29) [mm]; +inf if a pose is out of reach. Where the rows
/// are positions that is rmse, the objective (31).
[[nodiscard]] double position_rmse(const ObservationSpace& space, const Eigen::VectorXd& x);

struct RepeatNoise {
  double sigma_mm = 0.0;
  int degrees_of_freedom = 0;
};
/// Standard deviation of one reading, pooled from readings of the same channel at the same
/// point. A point counts only if all its samples really stand at the same pose
/// (geometry/same_pose.h). Empty without repeats.
[[nodiscard]] std::optional<RepeatNoise> repeat_noise(const ObservationSpace& space);

/// Which parameters keep their nominal value, from names such as "d" or "alpha". The error is
/// the name that no parameter has.
[[nodiscard]] tl::expected<std::vector<char>, std::string> fixed_by_name(
    const ObservationSpace& space, std::span<const std::string> names);
/// `fixed` by parameter, 1 keeps nominal; a shorter list leaves the rest free.
[[nodiscard]] bool is_fixed(const std::vector<char>& fixed, int parameter);

}  // namespace sixdial::calibration
