#include "studies/measured_positions.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include "diagnosis/explained_positions.h"
#include "session/trials.h"
#include "studies/extended_command.h"
#include "studies/seen_rig.h"

namespace sixdial::studies {
namespace {

using diagnosis::Readings;

/// The exchanged dials that the diagnosis names, if it does.
std::optional<simulation::Place> exchanged_dials(
    const DiagnosisResult& diagnosis, const geometry::Rig& rig) {
  for (const FoundCause& cause : diagnosis.causes) {
    const simulation::Effect* effect = simulation::find_effect(cause.id.cause);
    if (effect == nullptr || !effect->exchanges_dials) continue;
    for (const simulation::Place& place : effect->places(rig)) {
      if (place.name == cause.id.where) return place;
    }
  }
  return std::nullopt;
}

/// Both sessions as one: what happened in the first is the past of the second.
std::vector<simulation::Trial> one_after_the_other(
    const session::Session& calibrated, const session::Session& validation) {
  std::vector<simulation::Trial> trials = session::trials_of(calibrated, "");
  const auto first_time = [](const session::Session& session) {
    const auto found = std::ranges::find_if(
        session.samples, [](const session::Sample& each) { return each.time_utc.has_value(); });
    return found == session.samples.end() ? std::nullopt : found->time_utc;
  };
  const auto begun = first_time(calibrated);
  const auto again = first_time(validation);
  for (simulation::Trial& trial : session::trials_of(validation, "")) {
    if (trial.time_s && begun && again) {
      *trial.time_s += std::chrono::duration<double>(*again - *begun).count();
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

}  // namespace

bool names_the_instrument(const DiagnosisResult& diagnosis, const geometry::Rig& rig) {
  if (exchanged_dials(diagnosis, rig)) return true;
  return std::ranges::any_of(diagnosis.extended_fit.effects, [](const FittedEffect& each) {
    const simulation::Effect* effect = simulation::find_effect(each.id.cause);
    return effect != nullptr && (effect->before_contact || effect->after_reading);
  });
}

PositionOfSample measured_positions(const session::Session& validation) {
  PositionOfSample positions;
  for (const simulation::Trial& trial : session::trials_of(validation, "")) {
    positions.push_back(
        trial.position_mm ? std::optional<Eigen::VectorXd>(*trial.position_mm) : std::nullopt);
  }
  return positions;
}

PositionOfSample explained_positions(
    const session::Session& calibrated, const session::Session& validation,
    const DiagnosisResult& diagnosis) {
  PositionOfSample positions;
  const simulation::ForwardModel model(calibrated.rig);
  std::vector<simulation::Trial> trials = one_after_the_other(calibrated, validation);
  const std::size_t before = trials.size() - session::trials_of(validation, "").size();
  std::vector<bool> counts(trials.size(), false);
  std::fill(counts.begin() + static_cast<std::ptrdiff_t>(before), counts.end(), true);
  Readings readings(model, std::move(trials), std::move(counts));
  if (const auto swap = exchanged_dials(diagnosis, calibrated.rig)) {
    readings = readings.with_swapped_dials(swap->dial, swap->other_dial);
  }
  const ExtendedCommand fitted(diagnosis.extended_fit, calibrated.rig);
  readings.place_tool(fitted.model());
  std::vector<simulation::ActiveEffect> effects = fitted.effects();
  std::ranges::move(
      rig_effects(calibrated.rig, diagnosis.extended_fit.rig), std::back_inserter(effects));
  const Eigen::MatrixXd explained = diagnosis::explained_positions(
      readings, fitted.model(), effects, diagnosis.extended.noise_mm);
  for (std::size_t t = before; t < readings.trials().size(); ++t) {
    const Eigen::VectorXd position = explained.col(static_cast<Eigen::Index>(t));
    positions.push_back(
        position.allFinite() ? std::optional<Eigen::VectorXd>(position) : std::nullopt);
  }
  return positions;
}

}  // namespace sixdial::studies
