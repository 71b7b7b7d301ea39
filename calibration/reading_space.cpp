#include "calibration/reading_space.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "calibration/rig_spaces.h"
#include "geometry/instrument_kind.h"
#include "geometry/known_parts.h"
#include "geometry/lever.h"
#include "geometry/tool_turn.h"
#include "simulation/forward_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::Trial;

/// No sample of the session: something that is known of the instrument.
constexpr int kNoSample = -1;

struct ReadSample {
  VectorXd q;
  geometry::Assembly assembly;
  std::vector<std::optional<double>> reading;  // by channel
  std::vector<Index> channels;                 // that have one
  VectorXd measured;
  VectorXd per_unit;  // [mm]: 1 of a length, the lever of an angle
};

struct Details {
  geometry::Rig rig;
  std::shared_ptr<const geometry::InstrumentModel> instrument;
  std::vector<ReadSample> samples;
  std::vector<geometry::KnownPart> known;
};

std::span<const double> part_of(const VectorXd& x, Index first, Index count) {
  return {x.data() + first, static_cast<std::size_t>(count)};
}

bool evaluate_known(
    const geometry::KnownPart& known, Index robot, const VectorXd& x, Eigen::Ref<VectorXd> e,
    MatrixXd* J) {
  const auto of_instrument = x.tail(x.size() - robot);
  if (J == nullptr) {
    e[0] = known.value - geometry::value_of(known, of_instrument);
    return true;
  }
  Eigen::RowVectorXd by_x;
  e[0] = known.value - geometry::value_of(known, of_instrument, &by_x);
  J->setZero();
  J->rightCols(by_x.size()) = by_x;
  return !by_x.isZero(0.0);
}

bool evaluate_sample(
    const Details& is, const ReadSample& sample, const VectorXd& x, Eigen::Ref<VectorXd> e,
    MatrixXd* J) {
  const geometry::RobotModel& robot = *is.rig.robot.model;
  const Index of_robot = is.rig.robot.nominal.size();
  const Index of_instrument = is.instrument->parameter_count();
  static thread_local geometry::Frames frames;
  static thread_local geometry::Observation seen;
  if (frames.X.size() != robot.frames.size() ||
      frames.by_v[0].cols() != robot.parameter_count() ||
      frames.by_q[0].cols() != robot.joint_count() || frames.by_v.size() != frames.X.size()) {
    frames = geometry::Frames(robot);
  }
  const auto reached =
      J != nullptr
          ? robot.forward_derivative(x.head(of_robot), sample.q, sample.assembly, frames)
          : robot.forward(x.head(of_robot), sample.q, sample.assembly, frames.X);
  if (!reached) return false;
  const geometry::InstrumentKind& kind = *is.instrument->kind;
  kind.observe(*is.instrument, part_of(x, of_robot, of_instrument), {}, frames.X, false, seen);
  if (kind.nearest != nullptr) kind.nearest(sample.reading, seen);
  e = sample.per_unit.cwiseProduct(sample.measured - seen.reading(sample.channels));
  if (J == nullptr) return true;
  J->leftCols(of_robot).setZero();
  J->rightCols(of_instrument) = seen.by_x(sample.channels, Eigen::all);
  for (std::size_t k = 0; k < frames.X.size(); ++k) {
    const Eigen::Matrix<double, Eigen::Dynamic, 6> by_frame =
        seen.by_frames(sample.channels, Eigen::seqN(6 * static_cast<Index>(k), 6));
    if (by_frame.isZero(0.0)) continue;  // the instrument does not look at it
    J->leftCols(of_robot).noalias() += by_frame.lazyProduct(frames.by_v[k]);
  }
  J->array().colwise() *= sample.per_unit.array();
  return true;
}

/// An instrument that gives positions and turns.
bool shows_poses(const geometry::InstrumentModel& instrument) {
  const bool turns = std::ranges::any_of(
      instrument.channels, [](const auto& channel) { return channel.unit == "rad"; });
  return turns && instrument.find_channel("x").has_value();
}

/// Whether each angle of a turn was read.
bool whole_turn(const Trial& trial, const geometry::InstrumentModel& instrument) {
  for (std::size_t k = 0; k < instrument.channels.size(); ++k) {
    if (instrument.channels[k].unit != "rad") continue;
    if (k >= trial.reading.size() || !trial.reading[k]) return false;
    if (!std::isfinite(*trial.reading[k])) return false;
  }
  return true;
}

/// Of an instrument of poses, a sample needs its position, and has a whole turn or none.
std::optional<ReadSample> sample_of(
    const Trial& trial, const geometry::Rig& rig, const geometry::InstrumentModel& instrument) {
  if (trial.q.size() != rig.robot.model->joint_count() || !trial.q.allFinite()) {
    return std::nullopt;
  }
  ReadSample sample{trial.q, trial.assembly, {}, {}, {}, {}};
  sample.reading.resize(instrument.channels.size());
  std::vector<double> measured, per_unit;
  const double lever_mm = geometry::lever_mm(instrument);
  const bool poses = shows_poses(instrument);
  const bool turned = !poses || whole_turn(trial, instrument);
  for (std::size_t k = 0; k < trial.reading.size() && k < sample.reading.size(); ++k) {
    if (!trial.reading[k] || !std::isfinite(*trial.reading[k])) continue;
    if (!turned && instrument.channels[k].unit == "rad") continue;
    sample.reading[k] = trial.reading[k];
    sample.channels.push_back(static_cast<Index>(k));
    measured.push_back(*trial.reading[k]);
    per_unit.push_back(instrument.channels[k].unit == "rad" ? lever_mm : 1.0);
  }
  // The coordinates are the first channels.
  const auto axes = static_cast<std::size_t>(rig.instrument.dimensions);
  const bool whole = sample.channels.size() >= axes &&
                     sample.channels[axes - 1] + 1 == rig.instrument.dimensions;
  if (measured.empty() || (poses && !whole)) return std::nullopt;
  sample.measured = Eigen::Map<const VectorXd>(measured.data(), std::ssize(measured));
  sample.per_unit = Eigen::Map<const VectorXd>(per_unit.data(), std::ssize(per_unit));
  return sample;
}

/// d(reading)/d(position of the tool), rows x axes; empty where x cannot reach the pose.
std::optional<MatrixXd> by_tool_of(
    const Details& is, const ReadSample& sample, const VectorXd& x) {
  const geometry::RobotModel& robot = *is.rig.robot.model;
  const Index of_robot = is.rig.robot.nominal.size();
  std::vector<geometry::Pose<double>> X(robot.frames.size());
  if (!robot.forward(x.head(of_robot), sample.q, sample.assembly, X)) return std::nullopt;
  geometry::Observation seen;
  is.instrument->kind->observe(
      *is.instrument, part_of(x, of_robot, is.instrument->parameter_count()), {}, X, false,
      seen);
  return MatrixXd(
      seen.by_frames(sample.channels, Eigen::seqN(0, is.rig.instrument.dimensions)));
}

/// The least shift of the tool that explains what was read.
bool shift_of_tool(
    const Details& is, const ReadSample& sample, const VectorXd& x,
    Eigen::Ref<VectorXd> shift) {
  VectorXd e(std::ssize(sample.channels));
  const auto by_tool = by_tool_of(is, sample, x);
  if (!by_tool || !evaluate_sample(is, sample, x, e, nullptr)) return false;
  shift = by_tool->completeOrthogonalDecomposition().solve(e);
  return true;
}

/// Nominal parameters; of the instrument those that the samples put there.
VectorXd start_of(const Details& is) {
  VectorXd x = is.instrument->nominal;
  if (is.instrument->kind->start != nullptr) {
    std::vector<std::vector<geometry::Pose<double>>> poses;
    std::vector<const ReadSample*> reached;
    for (const ReadSample& sample : is.samples) {
      std::vector<geometry::Pose<double>> X(is.rig.robot.model->frames.size());
      if (!is.rig.robot.model->forward(is.rig.robot.nominal, sample.q, sample.assembly, X)) {
        continue;
      }
      poses.push_back(std::move(X));
      reached.push_back(&sample);
    }
    std::vector<geometry::SeenSample> seen;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      seen.push_back({poses[i], reached[i]->reading});
    }
    if (!seen.empty()) is.instrument->kind->start(*is.instrument, seen, x);
  }
  VectorXd all(is.rig.robot.nominal.size() + x.size());
  all << is.rig.robot.nominal, x;
  return all;
}

void add_rows(ObservationSpace& space, int rows, int sample, int point, int repeat) {
  space.first_row.push_back(space.first_row.back() + rows);
  space.sample.push_back(sample);
  space.point.push_back(point);
  space.repeat.push_back(repeat);
}

/// Names of parameters, joints and channels.
ObservationSpace named_space(
    const geometry::RobotModel& robot, const geometry::InstrumentModel& instrument) {
  ObservationSpace space;
  space.name = shows_poses(instrument) ? "poses" : "readings";
  space.parameter_info = robot.parameters;
  space.parameter_info.insert(
      space.parameter_info.end(), instrument.parameters.begin(), instrument.parameters.end());
  space.named_directions = robot.named_directions;
  for (const geometry::JointInfo& joint : robot.joints) {
    space.joint_info.push_back({joint.name, std::string(joint.unit())});
  }
  for (const auto& channel : instrument.channels) {
    space.channel_info.push_back({channel.name, "mm"});  // an angle by its lever
  }
  return space;
}

/// Of one reading, in the channel's unit: a coordinate's own where the row gives it, and an
/// angle's as well as the coordinates' at the lever where nobody says it. 0: nobody knows.
double deviation_of(
    const Trial& trial, const geometry::InstrumentModel& instrument, Index channel) {
  const geometry::ChannelInfo& info = instrument.channels[static_cast<std::size_t>(channel)];
  const Eigen::MatrixXd& C = trial.position_covariance;
  if (!shows_poses(instrument) || C.rows() == 0) return info.sd;
  if (channel < C.rows()) return std::sqrt(std::max(0.0, C(channel, channel)));
  const double usual_mm = std::sqrt(C.trace() / static_cast<double>(C.rows()));
  return info.sd > 0.0 ? info.sd : usual_mm / geometry::lever_mm(instrument);
}

/// Measured position less the target; NaN: there is no target.
VectorXd off_target_of(const Trial& trial, const geometry::Rig& rig) {
  const Index axes = rig.instrument.dimensions;
  const bool aimed = trial.position_mm && trial.target_mm &&
                     trial.position_mm->size() == axes && trial.target_mm->size() == axes;
  return aimed ? VectorXd(*trial.position_mm - *trial.target_mm)
               : VectorXd::Constant(axes, std::numeric_limits<double>::quiet_NaN());
}

/// What is asked of the space, sample by sample: the measured ones, then what is known.
void set_functions(const std::shared_ptr<const Details>& details, ObservationSpace& space) {
  const Index of_robot = details->rig.robot.nominal.size();
  space.evaluate = [details, of_robot](
                       int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    const auto k = static_cast<std::size_t>(i);
    if (k < details->samples.size()) {
      return evaluate_sample(*details, details->samples[k], x, e, J);
    }
    return evaluate_known(details->known[k - details->samples.size()], of_robot, x, e, J);
  };
  space.position_axes = details->rig.instrument.dimensions;
  space.position_error = [details](int i, const VectorXd& x, Eigen::Ref<VectorXd> shift) {
    const auto k = static_cast<std::size_t>(i);
    return k < details->samples.size() &&
           shift_of_tool(*details, details->samples[k], x, shift);
  };
  // What a pose does not have in common from channel to channel: each shows one coordinate.
  if (shows_poses(*details->instrument)) return;
  space.by_tool = [details](int i, const VectorXd& x) {
    const auto k = static_cast<std::size_t>(i);
    const auto by_tool = k < details->samples.size()
                             ? by_tool_of(*details, details->samples[k], x)
                             : std::nullopt;
    const Index rows =
        k < details->samples.size() ? std::ssize(details->samples[k].channels) : 1;
    return by_tool.value_or(MatrixXd::Zero(rows, details->rig.instrument.dimensions));
  };
}

}  // namespace

ObservationSpace reading_space(
    std::span<const Trial> trials, const geometry::Rig& rig, double noise_mm) {
  auto details = std::make_shared<Details>();
  details->rig = rig;
  details->instrument = geometry::instrument_of(rig);
  const geometry::InstrumentModel& instrument = *details->instrument;
  const geometry::RobotModel& robot = *rig.robot.model;
  ObservationSpace space = named_space(robot, instrument);
  std::vector<double> sigma;
  std::vector<double> measured;
  std::vector<VectorXd> off_target;
  for (const Trial& trial : trials) {
    auto sample = sample_of(trial, rig, instrument);
    if (!sample) continue;
    for (Index row = 0; row < std::ssize(sample->channels); ++row) {
      const auto channel = sample->channels[static_cast<std::size_t>(row)];
      const double sd = sample->per_unit[row] * deviation_of(trial, instrument, channel);
      space.channel.push_back(static_cast<int>(channel));
      space.sigma_is_assumed = space.sigma_is_assumed || sd == 0.0;
      sigma.push_back(sd > 0.0 ? sd : noise_mm);
      measured.push_back(sample->per_unit[row] * sample->measured[row]);
    }
    if (shows_poses(instrument)) off_target.push_back(off_target_of(trial, rig));
    add_rows(
        space, static_cast<int>(sample->channels.size()), trial.sample, trial.point,
        trial.repeat);
    details->samples.push_back(*std::move(sample));
  }
  details->known = geometry::known_parts(instrument);
  for (std::size_t k = 0; k < details->known.size(); ++k) {
    space.channel.push_back(0);
    sigma.push_back(details->known[k].sd);
    measured.push_back(details->known[k].value);
    add_rows(space, 1, kNoSample, kNoSample - static_cast<int>(k), 0);
  }
  const auto measured_count = static_cast<Index>(details->samples.size());
  space.joints.setZero(robot.joint_count(), space.samples());
  for (Index i = 0; i < measured_count; ++i) {
    space.joints.col(i) = details->samples[static_cast<std::size_t>(i)].q;
  }
  if (measured_count > 0) {
    space.joints.rightCols(space.samples() - measured_count).colwise() =
        VectorXd(space.joints.leftCols(measured_count).rowwise().mean());
  }
  space.sigma_mm = Eigen::Map<const VectorXd>(sigma.data(), std::ssize(sigma));
  space.measured_mm = Eigen::Map<const VectorXd>(measured.data(), std::ssize(measured));
  for (int i = 0; i < space.samples(); ++i) {
    const auto at = space.first_row[static_cast<std::size_t>(i)];
    space.covariance_mm2.emplace_back(
        space.sigma_mm.segment(at, space.rows(i)).cwiseAbs2().asDiagonal());
  }
  // Place and turn of an arrival, each as a whole.
  space.rows_belong_together = shows_poses(instrument);
  space.nominal = start_of(*details);
  space.off_target_mm.resize(rig.instrument.dimensions, std::ssize(off_target));
  for (std::size_t i = 0; i < off_target.size(); ++i) {
    space.off_target_mm.col(static_cast<Index>(i)) = off_target[i];
  }
  set_functions(details, space);
  return space;
}

bool gives_positions(const geometry::Rig& rig) {
  return rig.on_cuboid() || geometry::instrument_of(rig)->find_channel("x").has_value();
}

ObservationSpace measured_space(
    std::span<const Trial> trials, const geometry::Rig& rig, double noise_mm) {
  return gives_positions(rig) ? position_space(trials, rig, noise_mm)
                              : reading_space(trials, rig, noise_mm);
}

bool fits_turns(const geometry::Rig& rig) {
  return !rig.on_cuboid() && shows_poses(*geometry::instrument_of(rig)) &&
         geometry::turns_its_tool(*rig.robot.model, rig.robot.nominal);
}

bool has_turn(const Trial& trial, const geometry::InstrumentModel& instrument) {
  return shows_poses(instrument) && whole_turn(trial, instrument);
}

bool fits_turns(std::span<const Trial> trials, const geometry::Rig& rig) {
  if (!fits_turns(rig)) return false;
  const auto instrument = geometry::instrument_of(rig);
  return std::ranges::any_of(
      trials, [&](const Trial& trial) { return has_turn(trial, *instrument); });
}

ObservationSpace fitted_space(
    std::span<const Trial> trials, const geometry::Rig& rig, double noise_mm) {
  return fits_turns(trials, rig) ? reading_space(trials, rig, noise_mm)
                                 : measured_space(trials, rig, noise_mm);
}

bool shows_position(const ObservationSpace& space) {
  static constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  const auto axes = static_cast<std::size_t>(space.position_axes);
  if (axes == 0 || space.channel_info.size() < axes) return false;
  for (std::size_t i = 0; i < axes; ++i) {
    if (space.channel_info[i].name != kAxes.at(i)) return false;
  }
  return true;
}

int measured_samples(const ObservationSpace& space) {
  return static_cast<int>(
      std::ranges::count_if(space.sample, [](int sample) { return sample != kNoSample; }));
}

}  // namespace sixdial::calibration
