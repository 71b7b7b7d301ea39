// The forward model with effects: the plain simulation when there are none.
#pragma once

#include <Eigen/Core>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "simulation/effect.h"
#include "simulation/forward_model.h"

namespace sixdial::simulation {

/// Circumstances of a session's samples, in time order as given. `at` places the tool for the
/// direction of travel. Forces and plunger directions come from the measured readings.
[[nodiscard]] std::vector<Circumstance> circumstances_of(
    const ForwardModel& model, const ModelVector& at, std::span<const Trial> trials);

class ExtendedModel {
 public:
  ExtendedModel(const ForwardModel& base, std::vector<ActiveEffect> effects);

  [[nodiscard]] const ForwardModel& base() const { return *base_; }
  [[nodiscard]] const std::vector<ActiveEffect>& effects() const { return effects_; }
  [[nodiscard]] std::vector<ActiveEffect>& effects() { return effects_; }

  /// Runs one sample through every stage. `extra` acts after the others of its stage.
  [[nodiscard]] tl::expected<void, geometry::KinematicTrouble> run(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
      const ActiveEffect* extra = nullptr) const;

 private:
  const ForwardModel* base_;
  std::vector<ActiveEffect> effects_;
};

}  // namespace sixdial::simulation
