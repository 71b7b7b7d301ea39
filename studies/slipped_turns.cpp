#include "studies/slipped_turns.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "calibration/gross_error_parts.h"
#include "calibration/reading_space.h"
#include "geometry/registration.h"
#include "geometry/units.h"
#include "session/measured_turn.h"
#include "session/sample_layout.h"
#include "studies/turns_left.h"

namespace sixdial::studies {
namespace {

/// Of three normal parts the length is so many times its median once in 10^17.
constexpr double kSlipTimes = 6.0;
/// Median length of three normal parts, in standard deviations of one.
constexpr double kMedianOfThree = 1.538;
/// No instrument tells less: rounding is no slip.
constexpr double kLeastUsual_rad = 1e-6;
/// Rows more than parameters for each turn that is judged: else a fit follows its slips.
constexpr int kLeastFreedom = 2;

/// What is left of most turns; not less than the rig file says of the instrument.
double usual_of(const std::vector<TurnLeft>& turns, const geometry::Rig& rig) {
  std::vector<double> left_rad;
  left_rad.reserve(turns.size());
  for (const TurnLeft& each : turns) left_rad.push_back(each.rad);
  return std::max(
      {geometry::median_of(left_rad), kMedianOfThree * rig.instrument.sd_rad, kLeastUsual_rad});
}

WarningPlace place_of(const session::Session& session, const std::vector<TurnLeft>& far) {
  WarningPlace place{
      .file = "session.csv", .field = "rx, ry, rz", .rows = static_cast<int>(far.size())};
  for (const TurnLeft& each : far) {
    if (place.named.size() == WarningPlace::kNamedRows) break;
    const session::Sample& sample = session.samples[static_cast<std::size_t>(each.sample)];
    place.named.push_back({sample.line, sample.set, sample.point, sample.repeat});
  }
  return place;
}

}  // namespace

bool may_be_accidents(std::ptrdiff_t far, std::ptrdiff_t turns) {
  const double most = std::max(1.0, calibration::kMostAccidents * static_cast<double>(turns));
  return static_cast<double>(far) <= most && turns - far >= kFewestTurns;
}

std::optional<Warning> leave_out_slipped_turns(
    session::Session& session, std::span<const simulation::Trial> g1,
    const calibration::IdentifySettings& settings) {
  const geometry::Rig& rig = session.rig;
  if (!calibration::fits_turns(g1, rig)) return std::nullopt;
  const calibration::ObservationSpace space =
      calibration::fitted_space(g1, rig, settings.noise_mm);
  const int freedom = space.rows() - space.parameters();
  if (freedom <= 0) return std::nullopt;
  calibration::IdentifySettings robust = settings;
  robust.loss = calibration::Loss::kCauchy;
  robust.weighted = true;
  const calibration::Identified found =
      calibration::identify(*calibration::find_identifier("lm"), space, robust);
  if (found.status == calibration::FitStatus::kBadStart) return std::nullopt;
  const std::vector<TurnLeft> turns =
      turns_left(session, g1, found.x.head(rig.robot.nominal.size()));
  const auto judged = static_cast<int>(turns.size());
  if (judged == 0 || freedom < kLeastFreedom * judged) return std::nullopt;
  const double usual_rad = usual_of(turns, rig);
  std::vector<TurnLeft> far;
  std::ranges::copy_if(turns, std::back_inserter(far), [&](const TurnLeft& each) {
    return each.rad > kSlipTimes * usual_rad;
  });
  if (far.empty()) return std::nullopt;
  const double most_rad = std::ranges::max(far, {}, &TurnLeft::rad).rad;
  Warning warning{
      "slipped_turn",
      Severity::kNote,
      place_of(session, far),
      {{"most", geometry::kDegPerRad * most_rad}, {"usual", geometry::kDegPerRad * usual_rad}}};
  if (!may_be_accidents(std::ssize(far), judged)) {
    warning.code = "slipped_turns";
    warning.severity = Severity::kDoubt;
    return warning;
  }
  const session::SampleLayout layout = session::layout_of(rig);
  for (const TurnLeft& each : far) {
    session::set_turn(
        session.samples[static_cast<std::size_t>(each.sample)], layout, std::nullopt);
  }
  return warning;
}

}  // namespace sixdial::studies
