// What a kind of instrument is: it looks at a robot's frames and shows channels. A kind is one
// file in geometry/instruments/ and one row in geometry/instrument_kind.cpp (or a row added at
// run time).
//
//   frames, x, unknowns --observe--> reading of each channel
//
// x are the instrument's own parameters (where it stands, how it is held), the same for a whole
// session; unknowns belong to one sample alone (how a cuboid held in a free hand is turned).
//
// Example:
//   const auto instrument = instrument_of(rig);  // what [instrument] of rig.toml names
//   for (const ChannelInfo& channel : instrument->channels) show(channel.name, channel.unit);
//   instrument->channel_count();  // -> 6
//   instrument->find_channel("B");  // -> 1
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/parameter.h"
#include "geometry/robot_kind.h"

namespace sixdial::geometry {

struct Rig;
struct InstrumentKind;

struct ChannelInfo {
  std::string name;  // "A"; "x"
  std::string unit;  // "mm"
  double sd = 0.0;   // standard deviation of one reading [unit]; 0: nobody knows
};

/// An unknown that each sample has a value of its own for.
struct UnknownInfo {
  std::string name;  // "gamma"
  std::string unit;  // "rad"
};

/// Two places among the parameters (three each, from these indices on) whose distance is known.
struct KnownDistance {
  int first = -1;
  int second = -1;
  double mm = 0.0;
  double sd_mm = 0.0;
};

/// The instrument at hand, for one rig. Immutable.
struct InstrumentModel {
  const InstrumentKind* kind = nullptr;
  std::vector<ChannelInfo> channels;
  std::vector<ParameterInfo> parameters;
  Eigen::VectorXd nominal;   // of its parameters
  Eigen::VectorXd known_to;  // their standard deviation before any sample; +inf: not known
  std::vector<UnknownInfo> unknowns;
  std::vector<KnownDistance> distances;
  std::shared_ptr<const void> details;  // what else the kind keeps

  [[nodiscard]] Eigen::Index channel_count() const {
    return static_cast<Eigen::Index>(channels.size());
  }
  [[nodiscard]] Eigen::Index parameter_count() const {
    return static_cast<Eigen::Index>(parameters.size());
  }
  [[nodiscard]] std::optional<int> find_channel(std::string_view name) const;
};

/// Readings and their derivatives. One element or row a channel.
struct Observation {
  Eigen::VectorXd reading;
  /// By the twist of each frame, six columns a frame in the robot's order: rows are
  /// d(reading)/d(origin) [per mm] and d(reading)/d(rotation vector) [per rad], both in W.
  Eigen::MatrixXd by_frames;
  Eigen::MatrixXd by_x;
  Eigen::MatrixXd by_unknowns;
  double gamma_rad = 0.0;  // rotation of the cuboid in W, where the instrument has one
  /// A real instrument would show this reading (a plunger within its travel and on its face).
  std::vector<bool> shows;
};

/// One sample as an instrument saw it: frames by the robot's parameters at hand, and what was
/// read, by channel.
struct SeenSample {
  std::span<const Pose<double>> X;
  std::span<const std::optional<double>> reading;
};

/// One row of the registry.
struct InstrumentKind {
  std::string_view name;      // "dials_on_cuboid", as in [instrument] kind
  std::string_view in_words;  // "dial indicators on a cuboid"
  /// The instrument of a rig. Says why the rig cannot have it.
  tl::expected<std::shared_ptr<const InstrumentModel>, std::string> (*of_rig)(const Rig& rig) =
      nullptr;
  /// Computes the readings and their derivatives from the poses `X` of the robot's frames. If
  /// `unknowns` is empty, the instrument takes what it would expect (a cuboid turned with its
  /// link). Observation::shows is filled only with `say_shown`.
  void (*observe)(
      const InstrumentModel& instrument, std::span<const double> x,
      std::span<const double> unknowns, std::span<const Pose<double>> X, bool say_shown,
      Observation& out) = nullptr;
  /// It looks at the tool's frame and at no other.
  bool sees_tool_only = false;
  /// Optional, where measured - reading is not how far two poses differ (rotation vectors):
  /// makes out.reading measured - e, where e is that difference, and its derivatives.
  void (*nearest)(std::span<const std::optional<double>> measured, Observation& out) = nullptr;
  /// Optional: a closed-form estimate of the parameters that are not known. `x` holds the
  /// nominal values when it is called.
  void (*start)(
      const InstrumentModel& instrument, std::span<const SeenSample> samples,
      Eigen::VectorXd& x) = nullptr;
};

/// Every kind; rows added at run time come last.
[[nodiscard]] std::span<const InstrumentKind* const> instrument_kinds();
[[nodiscard]] const InstrumentKind* find_instrument_kind(std::string_view name);
/// Adds a row while the program runs, under the rules of add_robot_kind.
const InstrumentKind& add_instrument_kind(InstrumentKind kind);

/// The instrument that a rig names. Throws std::invalid_argument, with the rig's name, if there
/// is no such kind or the rig cannot have it.
[[nodiscard]] std::shared_ptr<const InstrumentModel> instrument_of(const Rig& rig);

}  // namespace sixdial::geometry
