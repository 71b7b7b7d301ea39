#include "tests/diagnosis/made_session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "calibration/random.h"

namespace sixdial::diagnosis {

Session session_of(const Recipe& recipe) {
  geometry::Rig rig = geometry::default_rig();
  rig.cuboid.mount = recipe.mount;
  rig.dials[4].geometry.position_mm.x() = recipe.dial_E_x_mm;
  Session session{simulation::ForwardModel(rig), {}, {}, {}};
  calibration::RandomSequence random(recipe.seed, 9);
  simulation::ModelVector truth = session.model.nominal();
  for (int i = 0; i < 5; ++i) truth[i] += random.uniform(-0.5, 0.5);
  for (int i = 5; i < 7; ++i) truth[i] += random.uniform(-0.8, 0.8);
  for (int i = 7; i < 10; ++i) truth[i] += random.uniform(-0.01, 0.01);
  truth[session.model.find("clamp").value()] = random.uniform(-0.01, 0.01);
  session.truth = truth;
  const auto reference = geometry::inverse(
      rig.robot.nominal, rig.cuboid.reference_pose_mm, rig.robot.working_mode);
  Eigen::Vector2d before = *reference;
  for (int point = 0; point < recipe.points; ++point) {
    const Eigen::Vector2d target(random.uniform(17, 39), random.uniform(31, 65));
    const auto q =
        geometry::inverse(rig.robot.nominal, target, rig.robot.working_mode, *reference);
    for (int repeat = 0; repeat < recipe.repeats; ++repeat) {
      simulation::Trial trial;
      trial.sample = static_cast<int>(session.trials.size());
      trial.point = point;
      trial.repeat = repeat;
      trial.q = *q;
      trial.assembly = *geometry::assembly_at(rig.robot.nominal, *q, target);
      trial.time_s = 8.0 * trial.sample;
      trial.temperature_c = 20.0 + 4.0 * (1 - std::exp(-trial.time_s.value() / 600.0)) +
                            0.5 * std::sin(trial.time_s.value() / 150.0);
      if (recipe.temperature_degC) {
        trial.temperature_c = recipe.temperature_degC(
            static_cast<double>(trial.sample) / (recipe.points * recipe.repeats));
      }
      for (int j = 0; j < 2; ++j) {  // standing still, it lies on the side of its last move
        const bool first = session.trials.empty() || repeat == 0;
        trial.approach.push_back(
            first ? ((*q)[j] > before[j] ? 1 : -1)
                  : session.trials.back().approach[static_cast<std::size_t>(j)]);
      }
      trial.reading.assign(rig.dials.size(), 0.0);
      before = *q;
      session.trials.push_back(std::move(trial));
    }
  }
  calibration::RandomSequence off(recipe.seed, 10);
  // Twice: forces and plunger directions come from the readings.
  for (int pass = 0; pass < 2; ++pass) {
    const simulation::ExtendedModel extended(
        session.model, pass == 0 ? std::vector<simulation::ActiveEffect>{} : recipe.effects);
    const auto samples = simulation::circumstances_of(session.model, truth, session.trials);
    simulation::Scene scene;
    for (std::size_t t = 0; t < session.trials.size(); ++t) {
      auto& trial = session.trials[t];
      if (recipe.mount == geometry::Mount::kFree)
        trial.gamma_rad = 0.1 * std::sin(0.3 * static_cast<double>(t));
      simulation::ModelVector here = truth;
      simulation::Trial arrived = trial;
      if (pass == 1) {
        for (const char* axis : {"x0", "y0"}) {
          here[session.model.find(axis).value()] += recipe.scatter_mm * off.normal();
        }
        for (double& angle : arrived.q) angle += recipe.scatter_rad * off.normal();
      }
      EXPECT_TRUE(extended.run(here, arrived, samples[t], scene).has_value());
      for (std::size_t d = 0; d < trial.reading.size(); ++d) {
        trial.reading[d] = scene.reading[d];
        if (pass == 1) *trial.reading[d] += recipe.noise_mm * random.normal();
      }
    }
  }
  for (std::size_t t = 0; t < session.trials.size(); ++t) {
    session.held_out.push_back(t >= session.trials.size() * 2 / 3);
  }
  return session;
}

simulation::ActiveEffect effect_of(
    const geometry::Rig& rig, const char* cause, const char* where, std::vector<double> x) {
  const simulation::Effect* effect = simulation::find_effect(cause);
  for (const simulation::Place& place : effect->places(rig)) {
    if (place.name == where) return {effect, place, std::move(x)};
  }
  throw std::invalid_argument(where);
}

}  // namespace sixdial::diagnosis
