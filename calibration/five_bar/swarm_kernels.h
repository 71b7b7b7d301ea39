// The inner loops of QPSO-1 and QPSO-2 for eight particles at a time, one in each lane of the
// vector unit. What a lane computes does not depend on its place or on its neighbours, so
// results are the same for any split of the swarm over threads. geometry/robots/five_bar.h is
// the reference that tests hold these against.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/five_bar/positions.h"
#include "calibration/lanes.h"
#include "geometry/robots/five_bar.h"

namespace sixdial::calibration {

/// A block of values for eight particles: row i holds value i of particles 0..7.
template <int Rows>
using Lanes = Eigen::Matrix<double, Rows, kLanes, Eigen::RowMajor>;
using ParameterLanes = Lanes<geometry::kParameterCount>;
/// diag(Q) (10) and diag(R) (2) of eight filters.
using NoiseLanes = Lanes<12>;

/// One sample, ready for the kernels.
struct SwarmPoint {
  double cos1, sin1, cos2, sin2;  // of the encoder angles
  double beta;
  double x_mm, y_mm;  // measured
};

/// The samples with sines and cosines tabulated once, and f and J at the nominal parameters.
struct SwarmTable {
  std::vector<SwarmPoint> points;
  geometry::ParameterVector nominal;
  /// J (2x10) and Y = measured - f at nominal of each sample, equations (12), (13).
  struct Linear {
    double row[2][geometry::kParameterCount];
    double error_mm[2];
  };
  std::vector<Linear> linear;
  /// Every sample can be reached with the nominal parameters, so `linear` is complete.
  bool nominal_reaches_all = true;

  SwarmTable(const PositionObservations& observations, const geometry::ParameterVector& v);
};

/// Equation (31) for eight parameter vectors [mm]; +inf where a pose cannot be reached or a
/// number is not finite.
void swarm_rmse(const SwarmTable& table, const ParameterLanes& v, Lanes<1>& rmse_mm);

/// Equations (17)-(22) over all samples, f and J at the nominal parameters: the state after the
/// last sample. `p0`: the diagonal of P0. A filter that breaks leaves NaN.
void swarm_filter_nominal(
    const SwarmTable& table, const geometry::ParameterVector& p0, const NoiseLanes& noise,
    ParameterLanes& state);

/// The same with f and J at each filter's own estimate.
void swarm_filter_estimate(
    const SwarmTable& table, const geometry::ParameterVector& p0, const NoiseLanes& noise,
    ParameterLanes& state);

}  // namespace sixdial::calibration
