// How far a fit can be from the truth: noise of every row with what is known of its covariance,
// and what neighbouring poses share in the residuals, which is no noise but something that the
// model misses.
//
// A fit minimises |W (y - f(x))|^2. Where the rows' true covariance is V, that of x is the
// sandwich A V A' with A = (J'W'WJ)^-1 J'W'W, whatever W was. V has two parts here:
//
//   sigma^2 S  noise. S: the known covariance of each sample's rows (the rows' own variances
//              where only these are known), scaled so that the weighted rows have a mean
//              variance of 1.
//   tau^2 K    structure: for each channel, or for each coordinate of the tool, a smooth random
//              function with the covariance exp(-d^2 / (2 l^2)) between two samples, d: their
//              distance in joint values or in the order of measuring, as shares of the
//              session's range.
//
// sigma, tau, l and the kind of structure come from the restricted likelihood (REML; Patterson
// and Thompson 1971): that of the part of the residuals which no change of x explains. It
// decides whether there is structure; the covariance is then the mean over all kinds, lengths
// and sizes, each by its likelihood, as a few poses leave much possible.
//
//   const Structure structure = smooth_structure(space, fit, weighting);
//   const Eigen::MatrixXd C = fit_covariance(space, fit, weighting, sigma_mm, structure);
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/least_squares.h"
#include "calibration/observation_space.h"
#include "calibration/smooth_basis.h"

namespace sixdial::calibration {

/// What has a smooth function of its own.
enum class SmoothActs {
  kChannels,  // each channel: dials with error curves
  kTool,      // each coordinate of the tool: a robot that is not where it should be, which all
              // channels see at once
};

/// One kind of structure, and how well it explains the residuals among all kinds.
struct StructurePart {
  SmoothOver over = SmoothOver::kJoints;
  SmoothActs acts = SmoothActs::kChannels;
  double length = 0.0;
  double sd_mm = 0.0;
  double noise_mm = 0.0;
  double weight = 0.0;  // of all parts: 1
};

/// Smooth structure in the residuals of a fit: the likeliest, or none.
struct Structure {
  SmoothOver over = SmoothOver::kJoints;
  double sd_mm = 0.0;     // tau: of one row at one pose; 0: none seen
  double length = 0.0;    // l, as a share of the range
  double noise_mm = 0.0;  // sigma beside it; 0 where sd_mm is 0
  double log_gain = 0.0;  // log likelihood over that of noise alone
  SmoothActs acts = SmoothActs::kChannels;
  /// All that the residuals leave possible, by weight; empty: the likeliest stands for all.
  std::vector<StructurePart> parts{};
};

/// Structure in the residuals of `fit`, which minimised space.problem(weighting). Repeats of a
/// pose count as one. Of many samples a spread part is looked at. With too few rows to tell,
/// none is seen.
[[nodiscard]] Structure smooth_structure(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting);

/// Covariance of fit.x, parameters x parameters; zero in held and fixed directions. `fit`
/// minimised space.problem(weighting). `sigma_mm`: noise of one row where no structure is seen;
/// else structure.noise_mm counts.
[[nodiscard]] Eigen::MatrixXd fit_covariance(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    double sigma_mm, const Structure& structure = {});

}  // namespace sixdial::calibration
