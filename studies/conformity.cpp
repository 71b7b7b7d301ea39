#include "studies/conformity.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/coverage.h"
#include "session/trials.h"

namespace sixdial::studies {
namespace {

/// Row of a method in PointResiduals; none where it is not among the methods.
std::optional<std::size_t> row_of(const CalibrationResult& result, std::string_view method) {
  const auto found = std::ranges::find(result.methods, method, &MethodRow::id);
  if (found == result.methods.end()) return std::nullopt;
  return static_cast<std::size_t>(found - result.methods.begin());
}

void judge(Conformity& out, double error_mm, double expanded_mm) {
  const Decision each = decide(error_mm, expanded_mm, out.tolerance_mm);
  ++out.points;
  out.accepted += each == Decision::kAccepted ? 1 : 0;
  out.rejected += each == Decision::kRejected ? 1 : 0;
  const auto upper = [](double error, double expanded) {
    return error + (std::isfinite(expanded) ? expanded : 0.0);
  };
  if (out.points == 1 ||
      upper(error_mm, expanded_mm) > upper(out.largest_mm, out.expanded_mm)) {
    out.largest_mm = error_mm;
    out.expanded_mm = expanded_mm;
  }
}

}  // namespace

Decision decide(double error, double expanded, double tolerance) {
  if (!std::isfinite(error) || !std::isfinite(expanded)) return Decision::kUndecided;
  if (error + expanded <= tolerance) return Decision::kAccepted;
  if (error - expanded > tolerance) return Decision::kRejected;
  return Decision::kUndecided;
}

std::optional<double> position_uncertainty_mm(
    const geometry::Rig& rig, const session::Sample& sample, bool with_limits) {
  const simulation::Trial trial = session::trial_of(rig, sample);
  const Eigen::MatrixXd& C = trial.position_covariance;
  if (C.size() == 0 || !(C.diagonal().minCoeff() > 0.0)) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(C, Eigen::EigenvaluesOnly);
  const double variance_mm2 = axes.eigenvalues().maxCoeff();
  if (!with_limits) return std::sqrt(variance_mm2);
  // C is of the scatter alone. The limits of error are added in the same proportion, by the
  // dial for which they matter most: never too small.
  double times = 1.0;
  for (const int channel : trial.position_channels) {
    const geometry::Dial& dial = rig.dials[static_cast<std::size_t>(channel)];
    const double scatter_mm = session::reading_sigma_mm(dial);
    const double limit_mm = dial.accuracy_mm / std::sqrt(3.0);
    times = std::max(times, 1.0 + std::pow(limit_mm / scatter_mm, 2));
  }
  return std::sqrt(variance_mm2 * times);
}

SharedUncertainty rig_uncertainty(const CalibrationResult& result) {
  SharedUncertainty shared;
  double variance_mm2 = 0.0;
  if (!result.uncertainty_budgets) return shared;
  for (const UncertaintyBudget& budget : *result.uncertainty_budgets) {
    if (budget.measurand != Measurand::kMeasured) continue;
    for (const BudgetRow& row : budget.rows) {
      const bool of_rig =
          row.source == BudgetSource::kFittedAlong || row.source == BudgetSource::kRig;
      if (of_rig && row.state == BudgetState::kCounted) {
        variance_mm2 += std::pow(row.contribution_mm, 2);
        shared.holds_curves |= row.source == BudgetSource::kFittedAlong;
      }
    }
  }
  shared.mm = std::sqrt(variance_mm2);
  return shared;
}

std::optional<Conformity> conformity_of(
    const CalibrationResult& result, const session::Session& session, double tolerance_mm,
    std::string_view wanted) {
  const std::optional<std::size_t> method =
      row_of(result, wanted.empty() ? std::string_view(result.result_method) : wanted);
  if (!method) return std::nullopt;
  const SharedUncertainty of_rig = rig_uncertainty(result);
  for (const std::string set : {"G2", "G1"}) {
    Conformity out{
        .tolerance_mm = tolerance_mm, .set = set, .validated = set == std::string("G2")};
    for (const PointResiduals& each : result.points) {
      const bool known =
          *method < each.residual_mm.size() && each.residual_mm[*method].has_value();
      if (each.set != set || !known) continue;
      const auto sample = static_cast<std::size_t>(each.sample);
      const std::optional<double> u_mm = position_uncertainty_mm(
          session.rig, session.samples.at(sample), !of_rig.holds_curves);
      judge(
          out, each.residual_mm[*method]->norm(),
          u_mm ? geometry::kCoverage * std::hypot(*u_mm, of_rig.mm)
               : std::numeric_limits<double>::quiet_NaN());
    }
    if (out.points == 0) continue;
    if (out.rejected > 0) {
      out.decision = Decision::kRejected;
    } else if (out.validated && out.accepted == out.points) {
      out.decision = Decision::kAccepted;
    }
    return out;
  }
  return std::nullopt;
}

Conformity conformity_of_largest(
    const session::Session& session, const SharedUncertainty& of_rig, double largest_mm,
    int points, double tolerance_mm) {
  Conformity out{
      .tolerance_mm = tolerance_mm,
      .set = "G2",
      .points = points,
      .largest_mm = largest_mm,
      .expanded_mm = std::numeric_limits<double>::quiet_NaN()};
  for (const session::Sample& sample : session.samples) {
    const auto u_mm = sample.set == "G2"
                          ? position_uncertainty_mm(session.rig, sample, !of_rig.holds_curves)
                          : std::optional<double>();
    if (!u_mm) continue;
    out.expanded_mm =
        std::fmax(out.expanded_mm, geometry::kCoverage * std::hypot(*u_mm, of_rig.mm));
  }
  out.decision = decide(largest_mm, out.expanded_mm, tolerance_mm);
  out.accepted = out.decision == Decision::kAccepted ? points : 0;
  out.rejected = out.decision == Decision::kRejected ? 1 : 0;
  return out;
}

}  // namespace sixdial::studies
