// The laws of every effect, each as a function that says how an effect breaks it; empty: it
// keeps it. So the laws themselves can be tried: on effects that are wrong on purpose.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simulation/effect.h"
#include "simulation/extended_model.h"
#include "tests/simulation/law_rigs.h"

namespace sixdial::simulation {

class EffectLaws {
 public:
  explicit EffectLaws(LawRig rig = LawRig::kDials);

  using Complaints = std::vector<std::string>;
  /// Of size nought it changes no reading and no position.
  [[nodiscard]] Complaints does_nothing_at_zero(const Effect& effect, const Place& place) const;
  /// Each parameter that the place has moves something by 0.1 um at its plausible size, a
  /// searched one too; one that the place lacks moves nothing.
  [[nodiscard]] Complaints every_parameter_acts(const Effect& effect, const Place& place) const;
  /// Half the size does half as much, within 2 %.
  [[nodiscard]] Complaints is_smooth(const Effect& effect, const Place& place) const;
  /// What has no size exchanges the readings of its two dials and leaves the others.
  [[nodiscard]] Complaints exchanges_its_dials(const Effect& effect, const Place& place) const;
  /// Names, units, sizes, words and the twin's name are there; what is of time says so.
  [[nodiscard]] Complaints says_what_it_is(const Effect& effect, const Place& place) const;

  /// The size in words changes with each parameter.
  [[nodiscard]] Complaints says_its_size(const Effect& effect, const Place& place) const;
  /// Those words where each parameter has its plausible size, known to a tenth of it.
  [[nodiscard]] static std::string example_of_size(
      const Effect& effect, const Place& place, int enlarged = -1);

  [[nodiscard]] Complaints all(const Effect& effect, const Place& place) const;
  [[nodiscard]] const geometry::Rig& rig() const { return model_.rig(); }

 private:
  /// All readings and positions, with the effect at x.
  [[nodiscard]] Eigen::VectorXd seen(const std::optional<ActiveEffect>& active) const;
  /// Parameter i has `share` of its plausible size, all other linear ones are zero; a searched
  /// one has the value in the middle, or the first.
  [[nodiscard]] ActiveEffect only(
      const Effect& effect, const Place& place, std::size_t i, double share,
      bool first_searched = false) const;

  ForwardModel model_;
  ExtendedModel plain_;
  std::vector<Trial> trials_;
  std::vector<Circumstance> circumstances_;
};

}  // namespace sixdial::simulation
