// The two searches of the paper: QPSO-1 for the filter's Q and R, QPSO-2 for the parameters.
#pragma once

#include <functional>
#include <stop_token>

#include "calibration/ekf.h"
#include "calibration/qpso.h"
#include "calibration/space_fit.h"

namespace sixdial::calibration {

struct SwarmSize {
  int particles = 50;
  int iterations = 100;
};

using SearchProgress = std::function<void(const QpsoProgress&)>;

/// QPSO-1 searches log10 of diag(Q) and diag(R): one dimension for each parameter and for each
/// channel (12 for the five-bar's positions), equation (29).
struct NoiseSearchSettings {
  SwarmSize swarm{50, 100};
  Linearisation linearisation = Linearisation::kEstimate;
  Eigen::VectorXd p0;           // diagonal of P0; empty: 1 everywhere
  double first_log10 = -4.0;    // of every entry of the first particle: 1e-4
  double spread_decades = 2.0;  // standard deviation of the others around it
  double lower_log10 = -12.0;
  double upper_log10 = 2.0;
  std::vector<char> fixed;  // 1: keeps its nominal value; empty: all free
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
    const ObservationSpace& space, const NoiseSearchSettings& settings = {},
    const SearchProgress& progress = {}, std::stop_token stop = {});

enum class SearchCoordinates {
  kWhitened,  // by the covariance of a filter at the estimate: the long valley becomes a bowl
  kRaw,       // the parameters themselves, as printed
};

/// QPSO-2: one dimension for each parameter, equation (31).
struct ParameterSearchSettings {
  SwarmSize swarm{50, 400};
  SearchCoordinates coordinates = SearchCoordinates::kWhitened;
  double whitened_spread = 3.0;  // standard deviation of the start, in the filter's
  double raw_spread = 0.3;       // half width of the start around the estimate, in scales
  double raw_bound = 5.0;        // search region, in raw spreads around nominal
  double noise_mm = 0.003;       // as SpaceFitSettings, to judge what is determined
  double hold_uncertainty_mm = 2.0;
  Weighting weighting = Weighting::kAlike;
  std::vector<char> fixed;  // 1: keeps its nominal value; empty: all free
  std::uint64_t seed = 1;
  int threads = 1;
};

struct ParameterSearch {
  Eigen::VectorXd v;
  double rmse_mm = 0.0;
  QpsoResult search;
  std::vector<Eigen::VectorXd> history;  // best parameters by iteration (Fig. 9)
  int held = 0;  // directions left at nominal because the data do not determine them
};

/// `estimate`: the parameters that QPSO-1 ended with; the first particle starts there.
[[nodiscard]] ParameterSearch search_parameters(
    const ObservationSpace& space, const Eigen::VectorXd& estimate,
    const ParameterSearchSettings& settings = {}, const SearchProgress& progress = {},
    std::stop_token stop = {});

}  // namespace sixdial::calibration
