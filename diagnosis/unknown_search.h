// One smooth function after the other, each scored against the same residual of a fit, by the
// same evidence as a named effect.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/kernel_basis.h"
#include "diagnosis/unknown.h"

namespace sixdial::diagnosis {

/// Scores smooth functions against the same residual. They are asked for one after the other,
/// and tried a few at a time, by the threads of this work's crew.
class UnknownSearch {
 public:
  UnknownSearch(const Readings& readings, const JointFit& fit)
      : readings_(readings), projector_(fit), weight_(fit.weight.sum()) {}

  /// f(covariate), one for each column of the stage.
  void along(
      const std::string& name, const std::string& enters, const Eigen::VectorXd& covariate,
      const Eigen::MatrixXd& stage, int functions,
      const std::vector<Box>& boxes = boxes_along());

  /// Waves of the covariate that are shorter than those of `along`, which has the first `from`
  /// sines. Only the strongest are scored; the evidence pays for having chosen among all.
  void along_waves(
      const std::string& name, const std::string& enters, const Eigen::VectorXd& covariate,
      const Eigen::VectorXd& stage, int from);

  /// f(x, y) or f(x, y, z), one for each column of the stage. `coordinates`: trials x 2 or 3.
  void over(
      const Eigen::MatrixXd& coordinates, const std::string& enters,
      const Eigen::MatrixXd& stage);

  /// A smooth function of its own reading for each dial, all of one size, which is within the
  /// makers' limits.
  void dial_curves(const Eigen::MatrixXd& own_mm, double limit_mm);

  /// What every dial has some of, a column a dial for one mm of it.
  void dial_habit(const std::string& name, const Eigen::MatrixXd& columns, double limit_mm);

  /// What the masses behind a joint do beyond equal ones, a column for one rad/m each; no more
  /// than `size` [rad/m].
  void masses(
      int joint, const std::string& enters, const Eigen::MatrixXd& columns, double size);

  /// All that the rig file claims to know exactly, each as well as a workshop knows it.
  void rig_geometry(const Eigen::MatrixXd& columns);

  /// Another constant for each sign of each joint's approach.
  void by_approach(
      const Eigen::MatrixXd& approach, const std::string& enters, const Eigen::MatrixXd& stage);

  [[nodiscard]] std::vector<UnknownCandidate> ranked();
  /// In the order in which they were asked, without what the choice costs.
  [[nodiscard]] std::vector<UnknownCandidate> as_tried() {
    try_asked();
    return std::move(found_);
  }

  /// Keeps what was tried as well, whole: much memory for smooth functions.
  void keep_tried() { keeps_ = true; }
  [[nodiscard]] std::vector<RigRival> tried() {
    try_asked();
    return std::move(tried_);
  }

 private:
  /// Which function of each covariate a column is the product of; -1: there is none.
  using Order = std::array<int, 3>;
  /// One smooth function while it is tried.
  struct Trial {
    UnknownCandidate best;
    double top = -1e300;
    std::vector<double> all;            // evidence of each box, length and scale
    double price = 0.0;                 // log evidence, for others that were not scored
    std::array<double, 2> range{0, 0};  // of its covariate
    RigRival tried;                     // only where it is kept
  };
  [[nodiscard]] Eigen::Index trial_of(Eigen::Index row) const {
    return static_cast<Eigen::Index>(readings_.rows()[static_cast<std::size_t>(row)].trial);
  }
  /// Standard deviation of a good reading.
  [[nodiscard]] double projector_sigma_mm() const {
    return std::sqrt(projector_.squares() / projector_.freedom());
  }

  /// Each function of the basis times each column of the stage, readings x any. `basis`: places
  /// x functions, from number `first` on, which `order` gets for each column.
  [[nodiscard]] Eigen::MatrixXd columns_along(
      const Eigen::MatrixXd& basis, const Eigen::MatrixXd& stage, int first,
      std::vector<Order>& order) const;
  /// `score` tries it, later, maybe on another thread: all that it needs it has copied.
  void ask(
      std::vector<std::string> covariates, const std::string& enters, UnknownKind kind,
      std::function<void(Trial&)> score);
  /// Tries what was asked, together.
  void try_asked();
  /// One box of kernels; without `order` the columns as they are.
  void score(
      Trial& trial, const Eigen::MatrixXd& columns, const std::vector<Order>& order,
      const Box& box, double most = std::numeric_limits<double>::infinity()) const;
  void take(Trial trial);

  const Readings& readings_;
  Projector projector_;
  double weight_;
  struct Asked {
    Trial trial;
    std::function<void(Trial&)> score;
  };
  std::vector<Asked> asked_;
  std::vector<UnknownCandidate> found_;
  bool keeps_ = false;
  std::vector<RigRival> tried_;
  std::optional<std::size_t> best_smooth_;  // the one of found_ that keeps its columns
};

/// What the rig's dials may do within their makers' limits.
void along_background(
    UnknownSearch& search, const Readings& readings, const Eigen::VectorXd& simulated_mm);
/// Whether a joint of this fit gives under weight; and what unequal masses do there.
[[nodiscard]] bool gives_under_weight(const JointFit& fit);
void along_masses(
    UnknownSearch& search, const Readings& readings, const JointFit& fit,
    const simulation::ExtendedModel& extended, const Eigen::VectorXd& simulated_mm);
/// A dial's own reading at each trial, its mean where it has none. As simulated: a function of
/// the measured one would explain its own noise, n log(k) of evidence for any dial that is
/// called k times less sensitive than it is.
[[nodiscard]] Eigen::VectorXd own_reading_mm(
    const Readings& readings, const Eigen::VectorXd& simulated_mm, std::size_t dial);
/// What the rig itself may do where its file claims to be exact.
void along_rig(UnknownSearch& search, const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
