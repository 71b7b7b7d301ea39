#include "diagnosis/command_fit.h"

#include <Eigen/Dense>
#include <vector>

#include "calibration/reading_errors.h"
#include "diagnosis/curves_in_model.h"
#include "diagnosis/eliminated.h"
#include "diagnosis/normal_inverse.h"
#include "diagnosis/orthonormal.h"
#include "diagnosis/unnamed.h"

namespace sixdial::diagnosis {
namespace {

/// Of the model's numbers, then of what the fit moved in its causes.
Eigen::VectorXd plausible_changes(const Readings& readings, const JointFit& fit) {
  std::vector<double> changes;
  for (const geometry::ParameterInfo& info : readings.model().parameters()) {
    changes.push_back(info.known_to > 0.0 ? info.known_to : info.change);
  }
  for (const simulation::ActiveEffect& active : fit.effects) {
    for (int k = 0; k < fitted_count(*active.effect); ++k) {
      const auto size = simulation::parameter_at(*active.effect, active.place, k);
      changes.push_back(
          size ? size->sigma : active.effect->parameters[static_cast<std::size_t>(k)].sigma);
    }
  }
  return Eigen::Map<const Eigen::VectorXd>(changes.data(), std::ssize(changes));
}

}  // namespace

Eigen::MatrixXd error_curves(const Readings& readings) {
  using calibration::kCurveShapes;
  if (!readings.has_dials()) return Eigen::MatrixXd(readings.count(), 0);
  const auto& dials = readings.model().rig().dials;
  Eigen::MatrixXd curves = Eigen::MatrixXd::Zero(
      readings.count(), kCurveShapes * static_cast<Eigen::Index>(dials.size()));
  for (std::size_t dial = 0; dial < dials.size(); ++dial) {
    calibration::ReadingRange range;
    for (const Eigen::Index row : readings.rows_of_dial(dial)) {
      range.add(readings.measured_mm()[row]);
    }
    for (const Eigen::Index row : readings.rows_of_dial(dial)) {
      curves.block(row, kCurveShapes * static_cast<Eigen::Index>(dial), 1, kCurveShapes) =
          calibration::curve_sd_mm(dials[dial]) *
          calibration::curve_shapes(readings.measured_mm()[row], range);
    }
  }
  return curves;
}

Eigen::MatrixXd covariance_with_structure(
    const JointFit& plain, const JointFit& structured, const Eigen::MatrixXd& curves) {
  const Whitening whitening = plain.whitening();
  // Parameters by rows'(whitened readings): the readings themselves are too many to be columns.
  const NormalInverse all(plain);
  const auto bent_by = [&](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
    const Eigen::MatrixXd seen = all.rows.transpose() * whitening(columns);
    return all.estimate * seen;
  };
  const Eigen::MatrixXd smooth = bent_by(structured.scaled_random());
  const Eigen::MatrixXd bent = bent_by(curves);
  const double variance = structured.s_mm * structured.s_mm;
  return variance * (all.estimate * gram(all.rows) * all.estimate.transpose() +
                     smooth * smooth.transpose()) +
         bent * bent.transpose();
}

JointFit command_fit(const Readings& readings, const NamedCauses& named) {
  const JointFit& extended = named.extended;
  // Masses that only the readings know cannot be commanded by, as nothing smooth can.
  const bool all_has_names = named.unknown.empty() && named.masses.empty();
  JointFit fit = all_has_names ? extended
                               : fit_jointly(
                                     readings, extended.model, extended.effects, nullptr,
                                     named.dial_columns(readings.count()));
  // The curves become a part of the model; beside them only what the dials do stays random:
  // curves of dials too, as far as the readings leave them open.
  fit = with_curves(
      readings, fit, named.curves(), random_columns(readings.count(), named.background),
      named.dial_columns(readings.count()));
  const bool same = all_has_names && named.joint_curves.empty();
  const JointFit& structured = same ? fit : extended;
  const Eigen::MatrixXd curves = error_curves(readings);
  const Eigen::MatrixXd unnamed = unnamed_columns(readings, fit);
  Eigen::MatrixXd bends(readings.count(), curves.cols() + unnamed.cols());
  bends << curves, unnamed;
  fit.covariance = covariance_with_structure(fit, structured, bends);
  return fit;
}

Eigen::MatrixXd covariance_of_unseen(const Readings& readings, const JointFit& fit) {
  const Eigen::MatrixXd unseen = NormalInverse(fit).unseen;
  if (unseen.cols() == 0) return Eigen::MatrixXd::Zero(unseen.rows(), unseen.rows());
  const Eigen::VectorXd change = plausible_changes(readings, fit);
  const Eigen::MatrixXd moves =
      change.asDiagonal() * orthonormal_basis(change.cwiseInverse().asDiagonal() * unseen);
  return moves * moves.transpose();
}

}  // namespace sixdial::diagnosis
