#include "studies/separation_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "diagnosis/limits.h"
#include "diagnosis/separation.h"
#include "session/trials.h"
#include "studies/error.h"
#include "studies/measurable_poses.h"
#include "studies/next_plan.h"
#include "studies/plausibility.h"

namespace sixdial::studies {
namespace {

using diagnosis::JointFit;
using diagnosis::PosePoint;

/// What is to come apart: a cause in the fit, and what it is tied with.
struct Question {
  JointFit fit;
  std::size_t cause = 0;
  std::optional<simulation::ActiveEffect> rival;
  bool assumed = false;  // the session does not show it; its size is a plausible one
};

std::optional<Question> tied_in(const diagnosis::NamedCauses& found) {
  for (std::size_t i = 0; i < found.findings.size(); ++i) {
    if (found.findings[i].tied_with.empty()) continue;
    return Question{found.extended, i, found.findings[i].tied_with.front().fitted, false};
  }
  return std::nullopt;
}

/// The effect that would have to be largest, in its own plausible sizes, to be seen.
std::optional<Question> blindest(
    const diagnosis::Readings& readings, const diagnosis::NamedCauses& found) {
  std::vector<diagnosis::NotTestable> ignored;
  std::vector<diagnosis::Hypothesis> open;
  for (const auto& each : diagnosis::hypotheses_for(readings, ignored)) {
    // Poses show what depends on poses.
    if (each.effect->searched || each.effect->needs & simulation::kTime ||
        each.effect->needs & simulation::kTemperature) {
      continue;
    }
    open.push_back(each);
  }
  const auto limits = diagnosis::limits_of(readings, found.extended, open, {});
  const diagnosis::Limit* worst = nullptr;
  for (const diagnosis::Limit& each : limits) {
    if (!std::isfinite(each.detect)) continue;
    if (!worst || each.detect / each.plausible > worst->detect / worst->plausible) {
      worst = &each;
    }
  }
  if (!worst) return std::nullopt;
  Question question{found.extended, found.extended.effects.size(), std::nullopt, true};
  simulation::ActiveEffect active = diagnosis::at_rest(worst->hypothesis);
  active.x[0] = worst->plausible;
  question.fit.effects.push_back(std::move(active));
  return question;
}

PlacedCause name_of(const simulation::ActiveEffect& effect) {
  return {.cause = std::string(effect.effect->cause), .where = std::string(effect.place.name)};
}

}  // namespace

SeparationPlan separation_plan(
    const session::Session& session, const SeparationRequest& request) {
  const session::Session used = in_rig_frame(plausible(session), session.rig);
  const simulation::ForwardModel model(used.rig);
  diagnosis::Readings readings(model, session::trials_of(used, ""));
  constexpr Eigen::Index kFewest = 40;
  if (readings.count() < kFewest) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format("{} readings are too few to ask which causes are tied", readings.count()),
        {{"session", session.name}}, "Measure a first session, then ask again.");
  }
  const diagnosis::NamedCauses found = diagnosis::name_causes(readings);
  std::optional<Question> question = tied_in(found);
  if (!question) question = blindest(readings, found);
  if (!question) {
    throw StudyError(
        StudyErrorCode::kBadData,
        "there is nothing to separate: no tied causes, no hidden effect",
        {{"session", session.name}}, "");
  }
  const std::vector<PosePoint> candidates =
      measurable_poses(session.rig, request.modes, rectangle_of(session));
  if (candidates.empty()) {
    throw StudyError(
        StudyErrorCode::kBadData, "no pose can be measured in these working modes",
        {{"session", session.name}}, "Use sixdial plan separate without --mode.");
  }
  const diagnosis::Separation separation = diagnosis::separating_poses(
      readings, question->fit, question->cause, question->rival, candidates, request.points);

  SeparationPlan result;
  int first = 0;
  for (const session::Sample& sample : session.samples) {
    if (sample.set == "G1") first = std::max(first, sample.point + 1);
  }
  for (std::size_t i = 0; i < separation.chosen.size(); ++i) {
    const PosePoint& pose = candidates[separation.chosen[i]];
    session::PlanPoint point{
        "G1", 0, 0, pose.target_mm, pose.q_rad, {pose.approach.begin(), pose.approach.end()}};
    result.figures.by_point.push_back(
        {.target_mm = pose.target_mm,
         .mode = session::branch_of(session.rig, point).mode,
         .log_odds = separation.log_odds[i]});
    result.plan.points.push_back(std::move(point));
  }
  order_by_branch(session.rig, result.plan, first);
  const simulation::ActiveEffect& own = question->fit.effects[question->cause];
  SeparationFigures& figures = result.figures;
  figures.separates = name_of(own);
  if (question->rival) figures.rival = name_of(*question->rival);
  if (question->assumed) figures.size_assumed = own.x[0];
  if (const auto parameter = parameter_at(*own.effect, own.place, 0)) {
    figures.unit = parameter->unit;
  }
  figures.points = static_cast<int>(result.plan.points.size());
  figures.log_odds_now = separation.log_odds_now;
  figures.log_odds_after =
      separation.log_odds.empty() ? separation.log_odds_now : separation.log_odds.back();
  return result;
}

}  // namespace sixdial::studies
