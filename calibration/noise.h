// Which noise a fit's uncertainties rest on, and whether the data contradict it.
//
//   const NoiseEstimate noise = noise_estimate(space, fit);
//   const double half_width = quantile_95(noise) * sd;
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "calibration/least_squares.h"
#include "calibration/observation_space.h"

namespace sixdial::calibration {

/// 97.5 % quantile of the normal distribution: half of a two-sided 95 % interval.
inline constexpr double kNormal_95 = 1.959963984540054;

/// Repeats tell the noise with at least so many degrees of freedom (to a fifth, one sigma).
inline constexpr int kEnoughRepeats = 10;

enum class NoiseSource {
  kRepeats,   // repeated readings of the same poses
  kResidual,  // what the fit leaves over
  kRigFile,   // what the rig file says of its instruments
  kAssumed,   // a default: neither the data nor the rig file say anything
};
/// "repeats", "residual", "rig_file", "assumed".
[[nodiscard]] std::string_view to_string(NoiseSource source);

/// Standard deviation of one reading (one axis of a position, or one dial).
struct NoiseEstimate {
  NoiseSource source = NoiseSource::kRigFile;
  double sigma_mm = 0.0;
  int degrees_of_freedom = 0;  // 0: taken as known (rig file)
  // All of them as far as the session has them.
  std::optional<RepeatNoise> repeats;
  std::optional<RepeatNoise> residual;
  double rig_file_mm = 0.0;  // or what is assumed in its place
  /// Residual between poses over repeats, where that is more than repeats of this number allow
  /// (95 %): the model misses something.
  std::optional<double> lack_of_fit;
  /// Residual over the rig file's noise, where chance makes it that large in one of a thousand
  /// sessions only.
  std::optional<double> over_rig_file;
  /// How far a row is from the model, which the uncertainties rest on: the noise, or where
  /// there is lack of fit what the fit leaves between poses.
  double spread_mm = 0.0;
  int spread_freedom = 0;  // 0: taken as known
  /// False: the noise is taken from the rig file or assumed, and with fewer than five readings
  /// more than unknowns the session cannot check it: no uncertainty is stated.
  bool known = true;
  std::string words;  // which, why, and the warning
};

/// Repeats where they have ten degrees of freedom, else the residual of the fit from five on.
/// With one to four the residual only where it contradicts the rig file (chi-square, 1e-3);
/// else the space's own sigma.
[[nodiscard]] NoiseEstimate noise_estimate(
    const ObservationSpace& space, const LeastSquaresFit& fit);

/// 95 % quantile for the spread's degrees of freedom; 1.96 where it is taken as known.
[[nodiscard]] double quantile_95(const NoiseEstimate& noise);

}  // namespace sixdial::calibration
