// One physical effect that the plain forward model lacks: a small change at one stage between
// the joint angles and a dial's reading (spec 4). An effect is one file in effects/ and one
// line in effects/all_effects.cpp.
//
//   q -> [before_kinematics] -> robot -> [after_kinematics] -> cuboid, dials ->
//   [before_contact]
//     -> displacement -> [after_reading]
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::simulation {

/// What one sample brings besides its joint angles. Made once a session, from measured values,
/// so that it does not move while parameters are fitted.
struct Circumstance {
  int order = 0;        // 0, 1, ... in time
  double time_h = 0.0;  // since the first sample
  double temperature_degC = 20.0;
  Eigen::Vector2d approach{0, 0};  // sign of each joint's last move
  Eigen::Vector2d travel{0, 0};    // unit vector of the tool's last move in W, 0 if unknown
  Eigen::Vector2d force_n{0, 0};   // of all plungers in contact on the cuboid, in W
  std::vector<double> plunger_direction;  // sign of each plunger's last move: +1 pushed in
  std::vector<double> previous_mm;        // each dial's reading one sample earlier; NaN if none
};

/// One pose on its way from joint angles to readings.
struct Scene {
  Eigen::Vector2d q_rad;
  geometry::ParameterVector v;
  Eigen::Vector2d p_WE;  // after kinematics
  Eigen::Matrix2d J_q;   // dp_WE/dq [mm/rad], after kinematics
  double gamma_rad = 0.0;
  double side_mm = 0.0;
  double squareness_rad = 0.0;  // faces 1 and 3 turned by this against 0 and 2
  Eigen::Vector2d centre_offset_mm{
      0, 0};  // of the square's centre from E, in the cuboid's frame
  std::vector<geometry::DialGeometry> dials;
  std::vector<double> reading_mm;  // after contact
};

/// Where an effect acts.
struct Place {
  std::string name;  // "joint1", "base", "A", "C,D"
  int joint = -1;    // 0, 1
  int dial = -1;     // index into rig.dials
  int other_dial = -1;
};

struct EffectParameter {
  std::string_view name;
  std::string_view unit;
  double sigma;  // a plausible size on a rig of this kind: scales searches and priors
};

/// Columns of a session that an effect needs.
enum Needs : unsigned {
  kNothing = 0,
  kTime = 1,
  kTemperature = 2,
  kApproach = 4,
  kDials = 8,  // raw dial readings
};

struct Effect {
  using Hook = void (*)(std::span<const double> x, const Place&, const Circumstance&, Scene&);

  std::string_view cause;     // "joint_backlash"
  std::string_view in_words;  // "backlash"
  std::vector<Place> (*places)(const geometry::Rig&);
  std::span<const EffectParameter> parameters = {};  // the linear ones first
  unsigned needs = kNothing;
  /// The last parameter is searched over these values (a period, a sample number).
  std::vector<double> (*searched)(
      const geometry::Rig&, std::span<const Circumstance>, const Place&) = nullptr;
  /// A small change of a searched value that is continuous, or null: such a value is fitted too
  /// once the search has found its neighbourhood.
  double (*searched_change)(double value) = nullptr;
  Hook before_kinematics = nullptr;
  Hook after_kinematics = nullptr;
  Hook before_contact = nullptr;
  Hook after_reading = nullptr;
  std::string_view signature;    // how it shows in the residuals
  std::string_view consequence;  // what it does to parts
  std::string_view advice;       // what to repair, enter or do
  std::string_view
      why_not_learned;  // why a network on joint angles cannot learn it; may be empty
  std::string_view told_apart = {};  // from the causes that look like it
  std::string_view helps = {};       // which poses or measurements show it best
};

/// Every effect, in alphabetical order of cause.
[[nodiscard]] std::span<const Effect* const> all_effects();
[[nodiscard]] const Effect* find_effect(std::string_view cause);

/// An effect somewhere, with a size.
struct ActiveEffect {
  const Effect* effect = nullptr;
  Place place;
  std::vector<double> x;  // as effect->parameters; a searched value last
};

/// Parameter k at a place: a step of a joint or of the cuboid is an angle.
[[nodiscard]] EffectParameter parameter_at(const Effect& effect, const Place& place, int k);

/// Helpers for `places`.
[[nodiscard]] std::vector<Place> at_each_joint(const geometry::Rig&);
[[nodiscard]] std::vector<Place> at_each_dial(const geometry::Rig&);
[[nodiscard]] std::vector<Place> at_each_pair_of_dials(const geometry::Rig&);
[[nodiscard]] std::vector<Place> at_one_place(std::string_view name);

}  // namespace sixdial::simulation
