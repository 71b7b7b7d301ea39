// The rigs that every effect is tried on: the five-bar on six dials, and an arm under an
// instrument that measures positions in space.
#pragma once

#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "simulation/effect.h"
#include "simulation/forward_model.h"

namespace sixdial::simulation {

enum class LawRig { kDials, kArm };

inline geometry::Rig law_rig(LawRig which) {
  geometry::Rig rig = geometry::default_rig();
  if (which == LawRig::kDials) return rig;
  rig.robot.model = geometry::find_robot_kind("serial")->example();
  rig.robot.nominal = rig.robot.model->nominal;
  rig.instrument.kind = "position";
  rig.instrument.dimensions = 3;
  rig.instrument.sd_mm = 0.02;
  rig.dials.clear();
  return rig;
}

/// One effect at one place of one rig.
struct EffectCase {
  const Effect* effect;
  Place place;
  LawRig rig = LawRig::kDials;
  [[nodiscard]] std::string name() const {
    std::string result = std::string(effect->cause) + "_" + place.name;
    for (char& each : result) each = each == ',' ? '_' : each;
    return rig == LawRig::kArm ? "arm_" + result : result;
  }
  friend void PrintTo(const EffectCase& each, std::ostream* out) { *out << each.name(); }
};

inline std::vector<EffectCase> effect_cases() {
  std::vector<EffectCase> cases;
  for (const LawRig which : {LawRig::kDials, LawRig::kArm}) {
    const geometry::Rig rig = law_rig(which);
    for (const Effect* effect : all_effects()) {
      for (const Place& place : effect->places(rig)) cases.push_back({effect, place, which});
    }
  }
  return cases;
}

/// Samples with all that an effect may ask for.
inline std::vector<Trial> law_trials(const ForwardModel& model, int count, double apart_s) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> x(18, 38), y(32, 62);
  std::vector<Trial> trials;
  for (int i = 0; i < count; ++i) {
    Trial trial;
    if (model.rig().on_cuboid()) {
      trial.q = *geometry::inverse(
          model.rig().robot.nominal, {x(engine), y(engine)}, {}, Eigen::Vector2d(1.4, 3.1));
    } else {
      trial.q.resize(model.robot().joint_count());
      for (Eigen::Index j = 0; j < trial.q.size(); ++j) {
        const auto& joint = model.robot().joints[static_cast<std::size_t>(j)];
        trial.q[j] = std::uniform_real_distribution<double>(joint.low, joint.high)(engine);
      }
    }
    trial.time_s = apart_s * i;
    trial.temperature_c = 20.0 + 0.1 * i;
    for (Eigen::Index j = 0; j < trial.q.size(); ++j) {
      trial.approach.push_back((i + j) % (j + 2) == 0 ? 1 : -1);
    }
    const auto seen = model.predict(model.nominal(), trial.q, trial.assembly);
    for (const double reading : seen->reading) trial.reading.emplace_back(reading);
    trials.push_back(trial);
  }
  return trials;
}

/// Numbers that bend by three plausible sizes; of a curve two waves.
inline std::vector<double> three_sizes(const Effect& effect) {
  if (effect.is_curve && effect.plot.shows == Shows::kReading) {
    return {0.0, 50.0, 1.3, 0.02, 0.0, -0.01};
  }
  if (effect.is_curve) return {-3.0, 3.0, 1.3, 1e-3, 0.0, -5e-4};
  std::vector<double> x;
  for (const EffectParameter& each : effect.parameters) x.push_back(3 * each.sigma);
  return x;
}

}  // namespace sixdial::simulation
