// Whether a robot keeps a tolerance of its user, by the decision rule of JCGM 106:2012, 8.3,
// with a guard band as wide as the expanded uncertainty U (k = 2; ISO 14253-1 has the same
// rule):
//
//   error + U <= tolerance   accepted          error
//   error - U >  tolerance   rejected     0 ----|--U--|------- tolerance
//   between                  cannot be decided
//
// Example:
//   decide(0.012, 0.006, 0.020);  // -> Decision::kAccepted
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "session/session.h"
#include "studies/calibration_result.h"

namespace sixdial::studies {

/// All in the same unit; `expanded` not finite: nobody knows it, so nothing can be decided.
[[nodiscard]] Decision decide(double error, double expanded, double tolerance);

/// Standard uncertainty of the measured position of a sample, in its worst direction [mm]: what
/// the dials scatter, and their makers' limits of error as a rectangle (GUM 4.3.7). Empty where
/// nobody knows it. `with_limits` false: the scatter alone.
[[nodiscard]] std::optional<double> position_uncertainty_mm(
    const geometry::Rig& rig, const session::Sample& sample, bool with_limits = true);

/// What all positions share, root mean square over G1.
struct SharedUncertainty {
  double mm = 0.0;  // k = 1; 0: nothing is stated of the rig
  /// The rig was fitted along: the dials' curves are within it, and counted once.
  bool holds_curves = false;
};
/// Of the rig's geometry: what is stated of it, or what a fit along left open.
[[nodiscard]] SharedUncertainty rig_uncertainty(const CalibrationResult& result);

/// `method` empty: the delivered one. Empty for an unknown method, or without points of it.
[[nodiscard]] std::optional<Conformity> conformity_of(
    const CalibrationResult& result, const session::Session& session, double tolerance_mm,
    std::string_view method = {});
/// Where only the largest error of some points is known: each of them is at most that, with the
/// largest uncertainty that a position of G2 has.
[[nodiscard]] Conformity conformity_of_largest(
    const session::Session& session, const SharedUncertainty& of_rig, double largest_mm,
    int points, double tolerance_mm);

}  // namespace sixdial::studies
