// The honest rival of every named cause: "something smooth that depends on C". A Gaussian
// process over a covariate (cosine basis with the spectrum of a squared-exponential kernel),
// entering at a stage of the robot, held against the same residual as the named effects, by the
// same evidence.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/kernel_basis.h"

namespace sixdial::diagnosis {

enum class UnknownKind {
  kSmooth,       // a smooth function of its covariates
  kDialCurves,   // of each dial's own reading, all dials at once, within their makers' limits
  kDialHabits,   // effects that every dial has some of (Effect::within_accuracy), likewise
  kMasses,       // what unequal masses add to the sag of a joint whose name is weight
  kRigGeometry,  // places and sizes that the rig file claims exactly
};

/// No fault: dials are as good as their makers say, and the links of an arm never have equal
/// masses.
[[nodiscard]] constexpr bool is_background(UnknownKind kind) {
  return kind == UnknownKind::kDialCurves || kind == UnknownKind::kDialHabits ||
         kind == UnknownKind::kMasses;
}

struct UnknownCandidate {
  UnknownKind kind = UnknownKind::kSmooth;
  std::vector<std::string> covariates;  // names of covariate.h: {"x", "y"}, {"time"}
  std::string enters;                   // "tool", "joint1", "dial A", "clamp"
  double evidence = 0.0;                // log Bayes factor against nothing
  double length = 0.0;                  // of the kernel, in half ranges of the covariate
  double rms_mm = 0.0;                  // of what it explains in the readings
  double scale = 0.0;  // standard deviation of each column's coefficient, in the column's unit
  /// Random columns for a joint fit, n x m; of smooth functions only the best one has them.
  Eigen::MatrixXd columns;
  Kernel kernel{};    // where there is one covariate and one way to enter
  double cost = 0.0;  // of the search over covariate, length and scale, in log evidence
  [[nodiscard]] bool is_background() const { return diagnosis::is_background(kind); }
};

/// The columns of several, side by side.
[[nodiscard]] Eigen::MatrixXd random_columns(
    Eigen::Index readings, const std::vector<UnknownCandidate>& of);
/// Random columns, n x any, and what each is multiplied by, one set a length that is tried.
/// `most`: the standard deviation of its coefficients is at most so many times that of a
/// reading.
struct RandomBox {
  Eigen::MatrixXd columns;
  std::vector<Eigen::VectorXd> spread;
  double most = std::numeric_limits<double>::infinity();
};
/// A smooth function of time that moves the tool: the rival of every cause that changes with
/// time alone. One column set a length; none where no time passes.
[[nodiscard]] std::vector<RandomBox> smooth_in_time(
    const Readings& readings, const JointFit& fit);
/// About how many smooth functions of all covariates are tried.
[[nodiscard]] int count_of_smooth(const Readings& readings);

/// What the dials or the rig may do, with all lengths that score_unknown tries.
struct RigRival {
  UnknownKind kind = UnknownKind::kDialCurves;
  std::vector<RandomBox> boxes;
};
/// Curves and habits of the dials, the rig where its file claims to be exact, and the masses
/// that a joint carries which gives under weight.
[[nodiscard]] std::vector<RigRival> rig_rivals(const Readings& readings, const JointFit& fit);

/// What is no fault by itself (is_background), best first.
[[nodiscard]] std::vector<UnknownCandidate> score_background(
    const Readings& readings, const JointFit& fit);
/// The error of one joint's value as a smooth function of each joint's value: of its own first.
[[nodiscard]] std::vector<UnknownCandidate> score_joint_by_others(
    const Readings& readings, const JointFit& fit, int joint);
/// The error of each joint's value as a smooth function of its own, one for each joint in their
/// order, all with their columns.
[[nodiscard]] std::vector<UnknownCandidate> score_joint_curves(
    const Readings& readings, const JointFit& fit);
/// All of them, best first.
[[nodiscard]] std::vector<UnknownCandidate> score_unknown(
    const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
