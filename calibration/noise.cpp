#include "calibration/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "calibration/identifiability.h"

namespace sixdial::calibration {
namespace {

constexpr int kEnoughResiduals = 5;    // degrees of freedom
constexpr double kLackOfFit = 0.05;    // level of the test against repeats
constexpr double kContradicts = 1e-3;  // level of the test against the rig file

std::string um(double mm) { return fmt::format("{:.1f} \u00B5m", 1e3 * mm); }

std::string freedom(int count) {
  return fmt::format("{} {} of freedom", count, count == 1 ? "degree" : "degrees");
}

std::string source_in_words(const NoiseEstimate& noise) {
  switch (noise.source) {
    case NoiseSource::kRepeats:
      return fmt::format(
          "noise from repeated readings of the same points: {} ({})", um(noise.sigma_mm),
          freedom(noise.degrees_of_freedom));
    case NoiseSource::kResidual:
      return fmt::format(
          "noise from what the fit leaves over, as there are {} repeats: {} ({}); whatever the "
          "model misses counts as noise",
          noise.repeats ? "too few" : "no", um(noise.sigma_mm),
          freedom(noise.degrees_of_freedom));
    case NoiseSource::kRigFile:
      return fmt::format(
          "noise from the rig file, as there are too few points to see it: {}",
          um(noise.sigma_mm));
    case NoiseSource::kAssumed:
      return fmt::format(
          "noise assumed to be {}, as the rig file says nothing and there are too few points "
          "to see it",
          um(noise.sigma_mm));
  }
  return "";
}

std::string words_of(const NoiseEstimate& noise) {
  std::string text = source_in_words(noise);
  if (noise.lack_of_fit) {
    text += fmt::format(
        "; the fit leaves {:.1f} times as much as repeats show: something is not in the model, "
        "and the uncertainties are made of what is left",
        *noise.lack_of_fit);
  }
  if (noise.over_rig_file) {
    text += fmt::format(
        "; the parameters leave {} where the rig file says {}", um(noise.residual->sigma_mm),
        um(noise.rig_file_mm));
  }
  if (!noise.known) {
    text += fmt::format(
        "; only {} left: no standard deviations are stated, measure more points",
        noise.residual ? freedom(noise.residual->degrees_of_freedom) : "no degree of freedom");
  }
  return text;
}

/// What is left between poses, the repeats' own differences taken out.
std::optional<RepeatNoise> between_poses(
    const RepeatNoise& residual, const RepeatNoise& repeats) {
  const int left = residual.degrees_of_freedom - repeats.degrees_of_freedom;
  if (left < 1) return std::nullopt;
  const double sum = residual.degrees_of_freedom * residual.sigma_mm * residual.sigma_mm -
                     repeats.degrees_of_freedom * repeats.sigma_mm * repeats.sigma_mm;
  return RepeatNoise{std::sqrt(std::max(sum, 0.0) / left), left};
}

void compare_with_repeats(NoiseEstimate& noise) {
  if (!noise.residual) return;
  const auto between = between_poses(*noise.residual, *noise.repeats);
  if (!between) return;
  const double ratio = between->sigma_mm / noise.repeats->sigma_mm;
  const boost::math::fisher_f chance(
      between->degrees_of_freedom, noise.repeats->degrees_of_freedom);
  if (ratio * ratio <= boost::math::quantile(boost::math::complement(chance, kLackOfFit))) {
    return;
  }
  noise.lack_of_fit = ratio;
  noise.spread_mm = between->sigma_mm;
  noise.spread_freedom = between->degrees_of_freedom;
}

/// Residual over the rig file's noise, where that is no chance.
std::optional<double> over_rig_file(const NoiseEstimate& noise, bool assumed) {
  if (assumed || !noise.residual || !(noise.rig_file_mm > 0.0)) return std::nullopt;
  const double ratio = noise.residual->sigma_mm / noise.rig_file_mm;
  const boost::math::chi_squared chance(noise.residual->degrees_of_freedom);
  const double most = boost::math::quantile(boost::math::complement(chance, kContradicts));
  if (ratio * ratio * noise.residual->degrees_of_freedom <= most) return std::nullopt;
  return ratio;
}

}  // namespace

std::string_view to_string(NoiseSource source) {
  switch (source) {
    case NoiseSource::kRepeats:
      return "repeats";
    case NoiseSource::kResidual:
      return "residual";
    case NoiseSource::kRigFile:
      return "rig_file";
    case NoiseSource::kAssumed:
      return "assumed";
  }
  return "unknown";
}

NoiseEstimate noise_estimate(const ObservationSpace& space, const LeastSquaresFit& fit) {
  NoiseEstimate noise;
  noise.rig_file_mm = space.mean_sigma();
  noise.repeats = repeat_noise(space);
  const int left = fit.degrees_of_freedom() - space.unknowns_per_sample * space.samples();
  if (left > 0) noise.residual = RepeatNoise{std::sqrt(fit.rss / left), left};
  noise.over_rig_file = over_rig_file(noise, space.sigma_is_assumed);
  const auto take = [&](NoiseSource source, const RepeatNoise& from) {
    noise.source = source;
    noise.sigma_mm = noise.spread_mm = from.sigma_mm;
    noise.degrees_of_freedom = noise.spread_freedom = from.degrees_of_freedom;
  };
  if (noise.repeats && noise.repeats->degrees_of_freedom >= kEnoughRepeats &&
      noise.repeats->sigma_mm > 0.0) {
    take(NoiseSource::kRepeats, *noise.repeats);
    compare_with_repeats(noise);
  } else if (
      noise.residual && noise.residual->sigma_mm > 0.0 &&
      (left >= kEnoughResiduals || noise.over_rig_file)) {
    take(NoiseSource::kResidual, *noise.residual);
  } else {
    take(
        space.sigma_is_assumed ? NoiseSource::kAssumed : NoiseSource::kRigFile,
        {noise.rig_file_mm, 0});
    noise.known = left >= kEnoughResiduals;
  }
  noise.words = words_of(noise);
  return noise;
}

double quantile_95(const NoiseEstimate& noise) {
  return noise.spread_freedom > 0 ? student_95(noise.spread_freedom) : kNormal_95;
}

}  // namespace sixdial::calibration
