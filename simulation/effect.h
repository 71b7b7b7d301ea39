// One physical effect that the plain forward model lacks: a small change at one stage between
// the joint angles and a dial's reading. An effect is one file in effects/ and one
// line in effects/all_effects.cpp: what it changes, and all that diagnosis, studies and report
// ask of it. Nothing outside of effects/ asks for an effect by its name.
//
//   q -> [before_kinematics] -> robot -> [after_kinematics] -> cuboid, dials
//
//     -> [before_contact] -> displacement -> [after_reading]
//
// Example:
//   const Effect& backlash = *find_effect("joint_backlash");
//   const Place& joint2 = backlash.places(rig)[1];
//   const ActiveEffect there{&backlash, joint2, {4e-4}};  // 0.4 mrad wide
//   in_words_at(backlash, there.place.name);  // -> "backlash of joint 2"
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/instrument_kind.h"
#include "geometry/rig.h"
#include "simulation/callable.h"
#include "simulation/trial.h"

namespace sixdial::simulation {

/// What is known of one sample besides its joint values (circumstances.h). It is made once for
/// a session, from measured values, so that it does not change during a fit.
struct Circumstance {
  int order = 0;           // 0, 1, ... in time
  double time_h = 0.0;     // since the first sample
  double time_sd_h = 0.0;  // 0: recorded
  double temperature_degC = 20.0;
  double temperature_sd_degC = 0.0;  // 0: recorded
  Eigen::VectorXd approach;          // by joint: sign of its last move, 0 unknown
  /// Moment of weight about each joint [m for a unit of weight, along the joint's turning]:
  /// column 0 of equal masses at the frames behind it, column 1 of a mass at the tool. Of a
  /// robot in space whose joints stand one after the other; empty of others.
  Eigen::MatrixXd weight_m;
  Eigen::MatrixXd weight_sideways_m;  // the same if weight pulled sideways
  Eigen::Vector3d travel{0, 0, 0};    // unit vector of the tool's last move in W, 0 if unknown
  std::vector<double> plunger_direction;   // sign of each plunger's last move: +1 pushed in
  std::vector<double> plunger_force_n;     // of each dial on the cuboid, along its axis
  std::vector<double> plunger_force_sd_n;  // 0: known
  Eigen::Vector2d force_n{0, 0};           // of all plungers on the cuboid, in W
  std::vector<double> previous_mm;  // each dial's reading one sample earlier; NaN if none
};

/// One pose on its way from joint angles to readings.
struct Scene {
  Eigen::VectorXd q;             // joint by joint [rad, or mm of a prismatic one]
  Eigen::VectorXd v;             // the robot's parameters
  std::span<const int> growing;  // those that are lengths of links: they grow with temperature
  // Of a robot in space: where its base is, and where its last link ends, at the tool.
  Eigen::Vector3d stands_mm{0, 0, 0}, end_mm{0, 0, 0};
  Eigen::VectorXd torque_Nmm;     // of the plungers on each joint (of effects that need kDials)
  Eigen::Vector3d p_WE{0, 0, 0};  // after kinematics; in the plane z stays 0
  Eigen::Vector3d turn_rad{
      0, 0, 0};            // of all frames about W's origin, as the instrument sees it
  double gamma_rad = 0.0;  // of a cuboid
  double side_mm = 0.0;
  double squareness_rad = 0.0;  // faces 1 and 3 turned by this against 0 and 2
  Eigen::Vector2d centre_offset_mm{
      0, 0};  // of the square's centre from E, in the cuboid's frame
  std::vector<geometry::DialGeometry> dials;
  /// Of an instrument that looks at the robot's frames: these, as after_kinematics left them.
  std::vector<geometry::Pose<double>> X;
  geometry::Observation seen;
  std::vector<double> reading;  // by channel of the instrument [its unit; mm of a dial]
};

/// Where an effect acts.
struct Place {
  std::string name{};  // "joint1", "base", "A", "C,D"
  int joint = -1;      // from 0
  int other_joint = -1;
  int dial = -1;  // index into rig.dials
  int other_dial = -1;
  bool slides = false;  // the joint does: its value is a length
  int axes = 2;         // in which the robot works
};

struct EffectParameter {
  std::string_view name;
  std::string_view unit;
  double sigma;  // a plausible size on a rig of this kind: scales searches and priors
  bool never_negative = false;  // cannot be less than zero: limits are for sizes above it
};

/// Columns of a session that an effect needs.
enum Needs : unsigned {
  kNothing = 0,
  kTime = 1,
  kTemperature = 2,
  kApproach = 4,
  kDials = 8,  // raw dial readings
};

/// Which quantity shows an effect when nothing else is left in the readings ...
enum class Shows { kJointAngle, kToolShift, kReading };
/// ... drawn against what ...
enum class Against {
  kJointAngle,
  kOtherJoint,  // the angle of Place::other_joint
  kTime,
  kTemperature,
  kTravel,           // direction of the tool's last move
  kForce,            // of the plungers, along the same axis
  kOtherCoordinate,  // the shift in x against y, the shift in y against x
  kRotation,         // of the face that the dial touches
  kReadingTimesRotation,
  kReading,
  kSimulatedReading,
};
/// ... with which samples told apart.
enum class Groups { kNone, kJointApproach, kPlungerDirection };

/// The picture in which an effect shows itself.
struct SignaturePlot {
  Shows shows = Shows::kReading;
  Against against = Against::kReading;
  Groups groups = Groups::kNone;
  /// The effect depends on nothing but what it is drawn against: its fit is a line, not a
  /// cloud.
  bool is_function = true;
};

struct Effect {
  using Hook =
      Callable<void(std::span<const double> x, const Place&, const Circumstance&, Scene&)>;

  std::string_view cause = {};     // "joint_backlash"
  std::string_view in_words = {};  // "backlash"
  /// With its place: "backlash of {place}" (see in_words_at). Empty: as in_words.
  std::string_view in_words_with_place = {};
  Callable<std::vector<Place>(const geometry::Rig&)> places = {};
  std::span<const EffectParameter> parameters = {};  // the linear ones first
  /// Parameter k of a place where unit or size depend on the place; empty for a parameter that
  /// this place lacks. Without it: parameters[k].
  Callable<std::optional<EffectParameter>(const Place&, int k)> parameter_of_place = {};
  unsigned needs = kNothing;
  /// The last parameter is searched over these values (a period, a sample number).
  Callable<std::vector<double>(
      const geometry::Rig&, std::span<const Circumstance>, const Place&)>
      searched = {};
  /// How far to change a searched value to take its derivative, if it is continuous: the value
  /// is then fitted like a parameter, once the search has come near it. Empty: it is searched
  /// only.
  Callable<double(double value)> searched_change = {};

  /// A fit that makes the first parameter negative is no explanation: lost motion, for example,
  /// is never less than zero, and such a fit has found something else.
  bool never_negative = false;

  /// It changes with time alone, so that anything else that wanders in time can be mistaken for
  /// it.
  bool in_time = false;
  /// A constant shift from the sample on that is searched.
  bool is_step = false;
  /// The rig itself is not as its file says: something stands, leans or measures otherwise.
  bool of_rig_geometry = false;
  /// The same computed from a wrong quantity of the same shape: what it gains is what
  /// flexibility alone gains, and the name must gain clearly more.
  const Effect* sham = nullptr;

  /// Every dial has some of it: no fault while it is within what the maker allows.
  bool within_accuracy = false;
  /// It has no size: the readings of place.dial and place.other_dial come under each other's
  /// name. Diagnosis tries it by exchanging the measured readings.
  bool exchanges_dials = false;

  /// A smooth function with as many coefficients as it needs: diagnosis finds it as such
  /// (diagnosis/unknown.h) and not by a fit of `parameters`, which say its size only. What the
  /// hooks get as x is told in smooth_function.h.
  bool is_curve = false;

  Hook before_kinematics = {};
  Hook after_kinematics = {};
  Hook before_contact = {};
  Hook after_reading = {};

  /// How its size is said. {a}: parameter a with its uncertainty; {a,b}: the length of the
  /// vector (a, b) with its uncertainty, a part that the place lacks left out; {=a}: a without
  /// uncertainty ({=a:.2f}: with two decimals). "amplitude {a,b}, period {=period}". Empty:
  /// each parameter in turn.
  std::string_view size = {};
  SignaturePlot plot = {};
  Callable<SignaturePlot(const Place&)> plot_of_place = {};  // where it depends on the place
  /// The cause in mock_devices/ that does the same to the true rig, by its own physics: what
  /// the blind challenge hides to see whether this one is found.
  std::string_view twin = {};

  std::string_view signature = {};    // how it shows in the residuals
  std::string_view consequence = {};  // what it does to parts
  std::string_view advice = {};       // what to repair, enter or do
  /// Why a network on joint angles cannot learn it; may be empty.
  std::string_view why_not_learned = {};
  std::string_view told_apart = {};  // from the causes that look like it
  std::string_view helps = {};       // which poses or measurements show it best
};

/// All effects, also those added at run time, sorted by cause. A span that was returned once
/// stays valid and does not change.
[[nodiscard]] std::span<const Effect* const> all_effects();
[[nodiscard]] const Effect* find_effect(std::string_view cause);
/// The curve over a joint's own value. Not null.
[[nodiscard]] const Effect* curve_of_joints();

/// Adds a row made at run time to the catalogue, for as long as this object lives:
///
///   Effect row{.cause = "belt_slip", ...};
///   const AddedEffect added(row);  // `row` and the texts it views outlive `added`
///
/// and longer than any study that has seen it. May be used beside running studies. Several
/// threads call its functions at once: they must not write what they share.
class AddedEffect {
 public:
  /// Throws std::invalid_argument if the cause is taken or the row lacks a name, its places or
  /// anything to do.
  explicit AddedEffect(const Effect& row);
  ~AddedEffect();
  AddedEffect(const AddedEffect&) = delete;
  AddedEffect& operator=(const AddedEffect&) = delete;

 private:
  const Effect* row_;
};

/// An effect somewhere, with a size.
struct ActiveEffect {
  const Effect* effect = nullptr;
  Place place;
  std::vector<double>
      x;  // as effect->parameters; a searched value last; of a curve as it needs
};

/// Parameter k with the unit and size that it has at this place: a step of a joint is an angle,
/// of a dial a length. Empty where the place lacks it: a step of a joint has no y.
[[nodiscard]] std::optional<EffectParameter> parameter_at(
    const Effect& effect, const Place& place, int k);
[[nodiscard]] SignaturePlot plot_at(const Effect& effect, const Place& place);
/// "backlash of joint 2", "swapped dials C and D", "a step of the base".
[[nodiscard]] std::string in_words_at(const Effect& effect, std::string_view place_name);

/// Helpers for `places`.
[[nodiscard]] std::vector<Place> at_each_joint(const geometry::Rig&);
[[nodiscard]] std::vector<Place> at_each_turning_joint(const geometry::Rig&);
[[nodiscard]] std::vector<Place> at_each_dial(const geometry::Rig&);
[[nodiscard]] std::vector<Place> at_each_pair_of_dials(const geometry::Rig&);
/// One place that a robot on any instrument has.
[[nodiscard]] std::vector<Place> at_one_place(const geometry::Rig&, std::string_view name);
/// One place that only a rig of dials on a cuboid has.
[[nodiscard]] std::vector<Place> on_the_cuboid(const geometry::Rig&, std::string_view name);
/// One place that only a rig with another instrument has.
[[nodiscard]] std::vector<Place> at_the_instrument(const geometry::Rig&);
/// Helper for `searched`: every sample that a step can come at.
[[nodiscard]] std::vector<double> samples_of_a_step(
    const geometry::Rig&, std::span<const Circumstance> all, const Place&);
/// A parameter of a joint: an angle, or of one that slides the length that turns a lever of
/// that joint just as far.
[[nodiscard]] EffectParameter of_joint(const EffectParameter& parameter, const Place& place);

}  // namespace sixdial::simulation
