// Ridge with the pull towards nominal: the residuals, and each parameter's deviation from
// nominal as one more residual. How strong the pull is comes from the data (the evidence for a
// common standard deviation of the deviations) unless it is given.
#include <cmath>

#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

constexpr int kRounds = 30;
constexpr double kSettled = 1e-6;
constexpr double kLeastSd = 1e-4;  // in units of scale
constexpr double kFirstSd = 1.0;

LeastSquaresProblem with_pull(
    const LeastSquaresProblem& plain, const ObservationSpace& space, double weight) {
  LeastSquaresProblem result;
  result.parameters = plain.parameters;
  result.residuals = plain.residuals + plain.parameters;
  result.evaluate = [&plain, &space, weight](
                        const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd* J) {
    Eigen::VectorXd data(plain.residuals);
    Eigen::MatrixXd data_J;
    if (J != nullptr) data_J.resize(plain.residuals, plain.parameters);
    if (!plain.evaluate(x, data, J != nullptr ? &data_J : nullptr)) return false;
    r << data, weight * (x - space.nominal).cwiseQuotient(space.scale());
    if (J != nullptr) {
      const Eigen::VectorXd diagonal = weight * space.scale().cwiseInverse();
      *J << data_J, Eigen::MatrixXd(diagonal.asDiagonal());
    }
    return true;
  };
  return result;
}

Identified fit(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  const LeastSquaresProblem plain = space.problem(weighting_of(space, settings));
  LeastSquaresSettings core = core_settings(space, settings);
  core.hold_below = 0.0;  // the pull holds what the data leave open
  double sd = settings.tikhonov_sd > 0.0 ? settings.tikhonov_sd : kFirstSd;
  double noise_mm = settings.noise_mm;
  Identified result;
  result.x = space.nominal;
  for (int round = 0; round < kRounds; ++round) {
    const LeastSquaresProblem pulled = with_pull(plain, space, noise_mm / sd);
    const LeastSquaresFit found = solve_least_squares(pulled, result.x, core);
    result.status = found.status;
    result.iterations += found.iterations;
    if (found.status == FitStatus::kBadStart) return result;
    result.x = found.x;
    if (settings.tikhonov_sd > 0.0) return result;
    // MacKay: of the free parameters, those that the data determine
    const double prior = noise_mm / sd;
    double determined = 0.0;
    for (const double s : found.singular_values) determined += 1.0 - prior * prior / (s * s);
    determined = std::max(determined, 0.5);
    const Eigen::VectorXd u = (result.x - space.nominal).cwiseQuotient(space.scale());
    const double freedom = std::max(plain.residuals - determined, 1.0);
    const double next = std::max(u.norm() / std::sqrt(determined), kLeastSd);
    const double data_rss = found.residual.head(plain.residuals).squaredNorm();
    if (data_rss > 0.0 && plain.residuals > plain.parameters) {
      noise_mm = std::sqrt(data_rss / freedom);
    }
    const bool settled = std::abs(next / sd - 1.0) < kSettled;
    sd = next;
    if (settled) break;
  }
  return result;
}

}  // namespace

extern constinit const Identifier tikhonov{
    .name = "tikhonov",
    .title = "Tikhonov",
    .description = "least squares with a pull towards nominal",
    .identify = fit};

}  // namespace sixdial::calibration
