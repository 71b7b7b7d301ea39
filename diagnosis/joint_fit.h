// Robot, clamp angle and effects fitted together to every reading. Each reading is either good,
// normal with standard deviation s, or gross, anywhere within a millimetre:
//   L = sum ln((1 - eps) phi(e/s_i)/s_i + eps/W),   s_i = s r_i,   W = max(1 mm, 30 s)
// with r_i the dial's noise over that of the others (Readings::relative_noise), and what nobody
// knows of a sample in it (Readings::doubt_mm), so that gross errors neither pull the fit nor
// are lost as evidence. Fitted by weighted Gauss-Newton steps, weights = probability of being
// good, with the full derivative: what an effect does depends on the robot it does it to.
//
// Random columns C with C u enter with a prior each, and are eliminated from the equations of a
// step (eliminated.h). First those of Readings::nuisance, u ~ N(0, known^2 I): the rig's own
// geometry where it is known to within something, the angle of a free mount at each sample.
// Then smooth functions that nobody named (unknown.h), u ~ N(0, s^2 I).
//
// Readings of one arrival may share a shift that nobody can foresee (sample_scatter.h). Its
// size belongs to the noise, as s does: each fit finds its own, and has none where that does
// not pay.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/orthonormal.h"
#include "diagnosis/readings.h"
#include "diagnosis/sample_scatter.h"

namespace sixdial::diagnosis {

struct JointFit {
  simulation::ModelVector model;
  std::vector<simulation::ActiveEffect> effects;
  Eigen::VectorXd residual_mm;  // measured - simulated - C u
  Eigen::VectorXd weight;       // probability that a reading is good
  Eigen::VectorXd noise;        // standard deviation of each reading, in s
  Eigen::MatrixXd J;            // d(simulated)/d(model, fitted parameters of the effects)
  Eigen::MatrixXd covariance;   // of the same, with the fitted s
  Eigen::MatrixXd random;       // C, count x m
  Eigen::VectorXd u;            // [mm]
  Eigen::VectorXd u_sd_mm;      // of what the data left open of each
  Eigen::Index known = 0;       // so many of u come first, with a known standard deviation
  double known_sd_mm = 1.0;
  double s_mm = 0.0;            // standard deviation of the good readings
  double gross_share = 0.0;     // eps
  double log_likelihood = 0.0;  // u integrated out over its prior; sharing paid for
  int fitted = 0;               // number of parameters that the data determine
  /// What readings of an arrival share, null: nothing; and its variance over s^2.
  std::shared_ptr<const ScatterColumns> shared;
  double shared_ratio = 0.0;
  Eigen::VectorXd shift_mm;  // the shared part of each reading, a part of residual_mm
  /// No step would raise the likelihood by anything that matters. Where this is false, nothing
  /// that is computed from the fit may be called certain.
  bool converged = false;
  /// What a row of the least squares is multiplied by if readings are independent.
  [[nodiscard]] Eigen::VectorXd root() const { return weight.cwiseSqrt().cwiseQuotient(noise); }
  /// What the row of each u is multiplied by: s over its own standard deviation.
  [[nodiscard]] Eigen::VectorXd root_of_u() const {
    Eigen::VectorXd result = Eigen::VectorXd::Ones(u.size());
    result.head(known).setConstant(s_mm / known_sd_mm);
    return result;
  }
  /// C and u scaled so that each u ~ N(0, s^2).
  [[nodiscard]] Eigen::MatrixXd scaled_random() const {
    return random * root_of_u().cwiseInverse().asDiagonal();
  }
  [[nodiscard]] Eigen::VectorXd scaled_u() const { return root_of_u().cwiseProduct(u); }
  /// The same where the readings of an arrival share a shift: makes all rows independent, each
  /// with the standard deviation s.
  [[nodiscard]] Whitening whitening() const { return {root(), shared.get(), shared_ratio}; }
  /// residual_mm without what an arrival's readings share: of each reading alone.
  [[nodiscard]] Eigen::VectorXd own_residual_mm() const { return residual_mm - shift_mm; }
  /// Share of the readings that count as gross: one less the mean weight.
  [[nodiscard]] double left_out() const { return weight.size() > 0 ? 1 - weight.mean() : 0.0; }
  /// For questions about the noise.
  [[nodiscard]] std::optional<ScatterSize> scatter(bool with_interval = false) const;
};

/// Fits from a start. Parameters that the data cannot determine keep their start value. `near`:
/// the fit of a similar model, whose noise and gross readings are a good first guess (without
/// it, the first steps count all readings). `random`: columns beside
/// those of the readings' own nuisance.
[[nodiscard]] JointFit fit_jointly(
    const Readings& readings, const simulation::ModelVector& start,
    std::vector<simulation::ActiveEffect> effects, const JointFit* near = nullptr,
    const Eigen::MatrixXd& random = {});

/// Residuals of each reading alone in the noise of its dial [mm]: those of a sample of which
/// something is not known are larger by that, which is no scatter.
[[nodiscard]] Eigen::VectorXd residual_at_rest_mm(
    const Readings& readings, const JointFit& fit);

/// Removes from a column what the fitted parameters can imitate: what is left is what could be
/// noticed.
class Projector {
 public:
  explicit Projector(const JointFit& fit);
  /// Orthonormal basis of the fitted columns, the rows of the readings.
  [[nodiscard]] const Eigen::MatrixXd& Q() const { return Q_; }
  /// The rows below, one for each random column of the fit: what its prior says of u.
  [[nodiscard]] const Eigen::MatrixXd& Q_of_u() const { return Q_of_u_; }
  /// Weighted residual, projected; and its squared norm with that of u.
  [[nodiscard]] const Eigen::VectorXd& residual() const { return e_; }
  [[nodiscard]] double squares() const { return squares_; }
  [[nodiscard]] double freedom() const { return freedom_; }
  [[nodiscard]] const Whitening& whitening() const { return whitening_; }

 private:
  Eigen::MatrixXd Q_;
  Eigen::MatrixXd Q_of_u_;
  Whitening whitening_;
  Eigen::VectorXd e_;
  double squares_ = 0.0;
  double freedom_ = 0.0;
};

/// d(simulated)/d(linear parameter i of an effect), one column each.
[[nodiscard]] Eigen::MatrixXd effect_columns(
    const Readings& readings, const simulation::ModelVector& at,
    const simulation::ExtendedModel& extended, const simulation::ActiveEffect& candidate,
    const Eigen::VectorXd& simulated_mm);

/// Number of linear parameters: all but a searched one.
[[nodiscard]] int linear_count(const simulation::Effect& effect);
/// Number of parameters that a fit moves: a searched one too if it is continuous.
[[nodiscard]] int fitted_count(const simulation::Effect& effect);

}  // namespace sixdial::diagnosis
