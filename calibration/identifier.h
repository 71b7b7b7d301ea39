// A way to find the parameters: one file in identifiers/ and one row in the table for each.
// Every identifier works in every observation space.
//
// Example:
//   const Identified found = identify(*find_identifier("lm"), space);
//   for (int i = 0; i < space.parameters(); ++i) {
//     show(space.parameter_info[static_cast<std::size_t>(i)].name, found.x[i]);
//   }
//   found.status;  // -> FitStatus::kConverged
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/dqpso.h"
#include "calibration/observation_space.h"

namespace sixdial::calibration {

struct IdentifySettings {
  std::vector<char> fixed;    // by parameter, 1 keeps nominal; empty: all free
  Loss loss = Loss::kSquare;  // lm only
  bool weighted = false;      // rows by their sigma; the dial space always is
  std::uint64_t seed = 1;
  int threads = 1;
  Linearisation linearisation = Linearisation::kEstimate;
  SearchCoordinates coordinates = SearchCoordinates::kWhitened;
  SwarmSize qpso1{50, 100};
  SwarmSize qpso2{50, 400};
  double first_variance = 1e-4;  // Q and R of `ekf`
  double p0 = 1.0;               // diagonal of P0
  double tikhonov_sd = 0.0;      // prior standard deviation in units of scale; 0: by evidence
  double noise_mm = 0.003;       // of one reading, to judge what is determined
  double hold_uncertainty_mm = 2.0;
};

struct Identified {
  Eigen::VectorXd x;  // n
  FitStatus status = FitStatus::kConverged;
  double rmse = 0.0;  // ObservationSpace::rmse [mm]
  int iterations = 0;
  std::vector<double> history;  // best RMSE by iteration, of searches
  LeastSquaresFit fit;          // the data at x: Jacobian, singular values, held directions
  /// Of a filter, whose gains are not those of least squares: covariance of x for readings of
  /// mean sigma 1. Empty: that of least squares.
  Eigen::MatrixXd unit_covariance;
  Eigen::MatrixXd covariance;  // of x, from the residual variance (or noise_mm without freedom)
  double sigma_mm = 0.0;       // of one reading, from the residuals
  bool cancelled = false;
};

using IdentifyFunction = std::function<Identified(
    const ObservationSpace& space, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop)>;

/// A row of the table: one for each file of identifiers/, and those that are added at run time.
struct Identifier {
  std::string_view name;         // "ekf_dqpso"
  std::string_view title;        // as tables name it: "EKF-DQPSO"
  std::string_view description;  // for people
  Identified (*identify)(
      const ObservationSpace& space, const IdentifySettings& settings,
      const SearchProgress& progress, const std::stop_token& stop) = nullptr;
  const IdentifyFunction* made = nullptr;  // of a row added at run time, instead of `identify`
};

/// The program's own rows, then those added at run time.
[[nodiscard]] std::vector<const Identifier*> all_identifiers();
/// Null if there is none of that name.
[[nodiscard]] const Identifier* find_identifier(std::string_view name);
/// Adds a row for as long as the program runs; every command takes it from then on. Throws
/// std::invalid_argument where the name is taken or no name.
const Identifier& add_identifier(
    std::string name, std::string description, IdentifyFunction identify);

/// Calls the identifier and adds what the data say at its answer (fit, covariance, rmse).
[[nodiscard]] Identified identify(
    const Identifier& identifier, const ObservationSpace& space,
    const IdentifySettings& settings = {}, const SearchProgress& progress = {},
    const std::stop_token& stop = {});

// Shared by the files of identifiers/.

[[nodiscard]] LeastSquaresSettings core_settings(
    const ObservationSpace& space, const IdentifySettings& settings);
[[nodiscard]] bool is_fixed(const IdentifySettings& settings, int parameter);
/// How rows count: alike where they are a position's coordinates and the settings do not say
/// otherwise, else by their sigma.
[[nodiscard]] Weighting weighting_of(
    const ObservationSpace& space, const IdentifySettings& settings);

/// QPSO-1: nominal + the filter's estimate with the best noise.
[[nodiscard]] Identified qpso1_in(
    const ObservationSpace& space, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop);
/// QPSO-2, from an estimate.
[[nodiscard]] Identified qpso2_in(
    const ObservationSpace& space, const Eigen::VectorXd& estimate,
    const IdentifySettings& settings, const SearchProgress& progress,
    const std::stop_token& stop);

}  // namespace sixdial::calibration
