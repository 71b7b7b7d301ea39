#include "report/words/conformity_words.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "geometry/coverage.h"
#include "report/text.h"

namespace sixdial::report {
namespace {

using studies::Conformity;
using studies::Decision;

std::string mm(double value) { return fmt::format("{} mm", fixed(value, 4)); }

std::string error_and_u(const Conformity& judged) {
  return fmt::format(
      "{} with U = {} (k = {})", mm(judged.largest_mm), mm(judged.expanded_mm),
      fixed(geometry::kCoverage, 0));
}

std::string undecided(const Conformity& judged) {
  if (!std::isfinite(judged.expanded_mm)) {
    return "It cannot be decided whether it is kept: the uncertainty of the measured positions "
           "is "
           "not known. State it in the rig file (sd_mm of [instrument]).";
  }
  if (!judged.validated) {
    return "It cannot be decided whether it is kept: all points were used for the fit. Measure "
           "validation points (G2).";
  }
  return fmt::format(
      "It cannot be decided whether it is kept: at {} of {} points the tolerance lies within "
      "the "
      "expanded uncertainty of the error (worst: {}).",
      judged.points - judged.accepted, judged.points, error_and_u(judged));
}

constexpr std::pair<Decision, std::string_view> kNames[] = {
    {Decision::kAccepted, "accepted"},
    {Decision::kRejected, "rejected"},
    {Decision::kUndecided, "undecided"}};

}  // namespace

std::string_view decision_name(Decision decision) {
  for (const auto& [each, name] : kNames) {
    if (each == decision) return name;
  }
  return "undecided";
}

std::optional<Decision> decision_from(std::string_view name) {
  for (const auto& [decision, each] : kNames) {
    if (each == name) return decision;
  }
  return std::nullopt;
}

std::string conformity_title(const std::optional<Conformity>& judged) {
  if (!judged) return "no tolerance stated";
  switch (judged->decision) {
    case Decision::kAccepted:
      return "within tolerance";
    case Decision::kRejected:
      return "outside tolerance";
    case Decision::kUndecided:
      break;
  }
  return "tolerance not decided";
}

std::string conformity_in_words(const std::optional<Conformity>& judged) {
  if (!judged) {
    return "No tolerance is stated, so this says how accurate the robot is, not whether that "
           "is "
           "good enough. State one with tolerance_mm in the rig file, or with \"sixdial "
           "calibrate "
           "SESSION --tolerance MM\".";
  }
  const std::string tolerance = fmt::format("Tolerance {}. ", mm(judged->tolerance_mm));
  switch (judged->decision) {
    case Decision::kAccepted:
      return tolerance + fmt::format(
                             "It is kept at each of {} validation points, with the expanded "
                             "uncertainty as guard band (worst: {}).",
                             judged->points, error_and_u(*judged));
    case Decision::kRejected:
      return tolerance +
             fmt::format(
                 "It is not kept: at {} of {} points the error is larger by more than "
                 "its expanded uncertainty (worst: {}).",
                 judged->rejected, judged->points, error_and_u(*judged));
    case Decision::kUndecided:
      break;
  }
  return tolerance + undecided(*judged);
}

}  // namespace sixdial::report
