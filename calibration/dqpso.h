// The two searches of the paper: QPSO-1 for the filter's Q and R, QPSO-2 for the parameters.
#pragma once

#include <functional>
#include <stop_token>

#include "calibration/ekf.h"
#include "calibration/position_fit.h"
#include "calibration/qpso.h"

namespace sixdial::calibration {

struct SwarmSize {
  int particles = 50;
  int iterations = 100;
};

using SearchProgress = std::function<void(const QpsoProgress&)>;

/// QPSO-1: log10 of diag(Q) and diag(R), 12 dimensions, equation (29).
struct NoiseSearchSettings {
  SwarmSize swarm{50, 100};
  Linearisation linearisation = Linearisation::kEstimate;
  geometry::ParameterVector p0 = geometry::ParameterVector::Ones();
  double first_log10 = -4.0;    // of every entry of the first particle: 1e-4
  double spread_decades = 2.0;  // standard deviation of the others around it
  double lower_log10 = -12.0;
  double upper_log10 = 2.0;
  FixedParameters fixed{};
  std::uint64_t seed = 1;
  int threads = 1;
};

struct NoiseSearch {
  FilterNoise noise;  // found
  FilterRun run;      // the filter with it
  double rmse_mm = 0.0;
  QpsoResult search;
};

[[nodiscard]] NoiseSearch search_noise(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const NoiseSearchSettings& settings = {}, const SearchProgress& progress = {},
    std::stop_token stop = {});

enum class SearchCoordinates {
  kWhitened,  // by the covariance of a filter at the estimate: the long valley becomes a bowl
  kRaw,       // the parameters themselves, as printed
};

/// QPSO-2: the parameters, 10 dimensions, equation (31).
struct ParameterSearchSettings {
  SwarmSize swarm{50, 400};
  SearchCoordinates coordinates = SearchCoordinates::kWhitened;
  double whitened_spread = 3.0;  // standard deviation of the start, in the filter's
  double raw_spread_mm = 0.3;    // half width of the start around the estimate, lengths
  double raw_spread_rad = 0.005;
  double raw_bound = 5.0;   // search region, in raw spreads around nominal
  double noise_mm = 0.003;  // as PositionFitSettings, to judge what is determined
  double hold_uncertainty_mm = 2.0;
  FixedParameters fixed{};
  std::uint64_t seed = 1;
  int threads = 1;
};

struct ParameterSearch {
  geometry::ParameterVector v;
  double rmse_mm = 0.0;
  QpsoResult search;
  std::vector<geometry::ParameterVector> history;  // best parameters by iteration (Fig. 9)
  int held = 0;  // directions left at nominal because the data do not determine them
};

/// `estimate`: where the first particle starts (QPSO-1's).
[[nodiscard]] ParameterSearch search_parameters(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const geometry::ParameterVector& estimate, const ParameterSearchSettings& settings = {},
    const SearchProgress& progress = {}, std::stop_token stop = {});

}  // namespace sixdial::calibration
