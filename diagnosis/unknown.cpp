#include "diagnosis/unknown.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/covariate.h"
#include "diagnosis/search.h"
#include "diagnosis/stages.h"
#include "diagnosis/unknown_search.h"

namespace sixdial::diagnosis {
namespace {

/// What each trial has that something could depend on.
struct Covariates {
  Eigen::MatrixXd q, approach;  // trials x joints
  Eigen::VectorXd x, y, z, gamma, time, temperature;
};

Covariates covariates_of(
    const Readings& readings, const JointFit& fit, const simulation::ExtendedModel& extended) {
  const auto& trials = readings.trials();
  const auto count = static_cast<Eigen::Index>(trials.size());
  Covariates at;
  for (Eigen::VectorXd* each : {&at.x, &at.y, &at.z, &at.gamma, &at.time, &at.temperature}) {
    each->resize(count);
  }
  const Eigen::Index joints = trials.empty() ? 0 : trials.front().q.size();
  at.q.resize(count, joints);
  at.approach.resize(count, joints);
  simulation::Scene scene;
  for (Eigen::Index t = 0; t < count; ++t) {
    const auto i = static_cast<std::size_t>(t);
    const simulation::Circumstance& sample = readings.circumstances()[i];
    at.q.row(t) = trials[i].q.transpose();
    at.time[t] = sample.time_h;
    at.temperature[t] = sample.temperature_degC;
    at.approach.row(t) = sample.approach.transpose();
    const bool there = extended.run(fit.model, trials[i], sample, scene).has_value();
    const Eigen::Index before = std::max<Eigen::Index>(0, t - 1);
    at.x[t] = there ? scene.p_WE.x() : t > 0 ? at.x[before] : 0.0;
    at.y[t] = there ? scene.p_WE.y() : t > 0 ? at.y[before] : 0.0;
    at.z[t] = there ? scene.p_WE.z() : t > 0 ? at.z[before] : 0.0;
    at.gamma[t] = there ? scene.gamma_rad : t > 0 ? at.gamma[before] : 0.0;
  }
  if (at.time.maxCoeff() <= 0) {
    at.time = Eigen::VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1));
  }
  return at;
}

// Numbers of basis functions: a random walk in time is rough, a creep is not.
constexpr int kFunctions = 16;
// A dial's curve may be fifty times the noise: it has to be described to a fiftieth, where it
// bends within 3 mm too. With a length that is a third too long a wave beside it would pay.
constexpr int kOfDial = 28;
const std::vector<Box> kAlongDial{
    {1.3, {0.08, 0.11, 0.15, 0.2, 0.26, 0.34, 0.44, -0.5, -2.0}},
    {2.0, {0.6, 0.85}},
    {3.5, {1.2, 2.5}}};
constexpr int kOfTime = 40;
constexpr int kFew = 10;
// A drive errs many times a turn, and a robot in space is measured at many poses: what so many
// samples can tell.
constexpr int kSamplesPerFunction = 12;
constexpr int kMostOfJoint = 40;
const std::vector<Box> kAlongDrive{
    {1.3, {0.04, 0.08, 0.15, 0.3, -0.5, -2.0}}, {2.0, {0.6}}, {3.5, {1.2, 2.5}}};

/// Sines that a smooth function of a joint's value has.
int functions_of_joint(const Readings& readings, const Covariates& at) {
  const auto samples = static_cast<int>(readings.of_used(at.time).size());
  return readings.axes() == 3
             ? std::clamp(samples / kSamplesPerFunction, kFunctions, kMostOfJoint)
             : kFunctions;
}

/// Anything of joint `bent` that depends on the value of joint `by`.
void along_joint(
    UnknownSearch& search, const Readings& readings, const Covariates& at,
    const Eigen::MatrixXd& stage, int bent, int by) {
  const bool in_space = readings.axes() == 3;
  const int functions = functions_of_joint(readings, at);
  search.along(
      dependence_name({.on = DependsOn::kJointAngle, .joint = by}),
      "joint" + std::to_string(bent + 1), at.q.col(by), stage, functions,
      in_space ? kAlongDrive : boxes_along());
}

/// Waves of joint `bent` along the value of joint `by`: teeth of a gear, a strain-wave drive.
/// Of robots in space only: the figures of doc/diagnosis.md for the plane were measured
/// without.
void waves_along_joint(
    UnknownSearch& search, const Readings& readings, const Covariates& at,
    const Eigen::MatrixXd& stage, int bent, int by) {
  if (readings.axes() != 3) return;
  search.along_waves(
      dependence_name({.on = DependsOn::kJointAngle, .joint = by}),
      "joint" + std::to_string(bent + 1), at.q.col(by), stage.col(0),
      functions_of_joint(readings, at));
}

bool is_shift_of_tool(const Eigen::VectorXd& column, const Eigen::MatrixXd& tool) {
  constexpr double kAlike = 1e-4;  // tool columns are differences, others are not
  for (Eigen::Index axis = 0; axis < tool.cols(); ++axis) {
    const double size = tool.col(axis).norm();
    if ((column * (size / std::max(1e-300, column.norm())) - tool.col(axis)).norm() <=
        kAlike * size) {
      return true;
    }
  }
  return false;
}

/// Channels that show the same in every sample: a ball in its socket, a touched surface. They
/// hold the tool where it is, and measure nothing beside the joints.
std::vector<bool> holding_channels(const Readings& readings) {
  std::map<int, std::pair<double, double>> seen;  // lowest and highest reading
  int channels = 0;
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const int channel = readings.rows()[static_cast<std::size_t>(row)].dial;
    const double value = readings.measured_mm()[row];
    const auto [at, is_new] = seen.try_emplace(channel, value, value);
    at->second.first = std::min(at->second.first, value);
    at->second.second = std::max(at->second.second, value);
    channels = std::max(channels, channel + 1);
  }
  std::vector<bool> holds(static_cast<std::size_t>(channels), false);
  constexpr double kSame_mm = 1e-9;
  for (const auto& [channel, range] : seen) {
    holds[static_cast<std::size_t>(channel)] = range.second - range.first < kSame_mm;
  }
  return holds;
}

/// Where the tool is at each trial, trials x axes [mm]. Where a channel holds the tool, its
/// place across the surface is the residual itself, which any smooth function of it would
/// explain: the mean of all trials of that channel stands for it.
/// Empty: all is held, as by sockets, whose own places are free already.
std::optional<Eigen::MatrixXd> places_of(
    const Readings& readings, const Covariates& at, const Eigen::MatrixXd& tool) {
  const Eigen::Index axes = readings.axes();
  Eigen::MatrixXd place(at.x.size(), axes);
  place.leftCols<2>() << at.x, at.y;
  if (axes == 3) place.col(2) = at.z;
  if (readings.has_dials()) return place;  // one that shows the same is stuck
  const std::vector<bool> holds = holding_channels(readings);
  std::map<int, std::pair<Eigen::VectorXd, double>> of_channel;  // sum of places, how many
  std::map<std::size_t, std::vector<Eigen::Index>> held;         // rows, by trial
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const auto& each = readings.rows()[static_cast<std::size_t>(row)];
    if (!holds[static_cast<std::size_t>(each.dial)]) continue;
    auto& [sum, count] =
        of_channel.try_emplace(each.dial, Eigen::VectorXd::Zero(axes), 0.0).first->second;
    sum += place.row(each.trial).transpose();
    count += 1;
    held[static_cast<std::size_t>(each.trial)].push_back(row);
  }
  std::ptrdiff_t fully = 0;
  for (const auto& [trial, rows] : held) {
    Eigen::MatrixXd across(axes, std::ssize(rows));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      across.col(static_cast<Eigen::Index>(k)) = tool.row(rows[k]).transpose();
    }
    const auto& [sum, count] =
        of_channel.at(readings.rows()[static_cast<std::size_t>(rows.front())].dial);
    const auto index = static_cast<Eigen::Index>(trial);
    const Eigen::VectorXd off = place.row(index).transpose() - sum / count;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> directions(across);
    const Eigen::MatrixXd Q =
        Eigen::MatrixXd(directions.householderQ()).leftCols(directions.rank());
    place.row(index) -= (Q * (Q.transpose() * off)).transpose();
    fully += directions.rank() == axes ? 1 : 0;
  }
  if (fully > 0 && fully == std::ssize(held)) return std::nullopt;
  return place;
}

/// Anything of the robot may creep with time or temperature. Parameters that only shift the
/// tool (the base's position) have been tried as that already.
void along_robot(
    UnknownSearch& search, const Readings& readings, const JointFit& fit, const Covariates& at,
    const Eigen::MatrixXd& tool) {
  const simulation::ForwardModel& model = readings.model();
  const Eigen::MatrixXd& J = fit.J;  // the robot's columns come first
  for (Eigen::Index k = 0; k < model.robot_parameter_count(); ++k) {
    if (is_shift_of_tool(J.col(k), tool)) continue;
    const std::string name(model.parameters()[static_cast<std::size_t>(k)].name);
    search.along("time", name, at.time, J.col(k), kFew);
    search.along("temperature", name, at.temperature, J.col(k), kFew);
  }
}

/// What one parameter of an effect does to the readings when what it goes by (the hour, the
/// temperature) is one unit larger.
Eigen::VectorXd per_unit(
    const Readings& readings, const JointFit& fit, const simulation::ExtendedModel& extended,
    const simulation::ActiveEffect& none, std::size_t parameter, bool by_temperature) {
  simulation::ActiveEffect moved = none;
  const double step = 1e-3 * none.effect->parameters[parameter].sigma;
  moved.x[parameter] += step;
  Eigen::VectorXd with(readings.count());
  Eigen::VectorXd without(readings.count());
  Eigen::VectorXd result = Eigen::VectorXd::Zero(readings.count());
  simulation::Scene scene;
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    if (!readings.has_rows(t)) continue;
    const Eigen::Index first = readings.first_row(t);
    const Eigen::Index rows = readings.first_row(t + 1) - first;
    const simulation::Trial& trial = readings.trials()[t];
    for (const double more : {1.0, 0.0}) {
      simulation::Circumstance sample = readings.circumstances()[t];
      (by_temperature ? sample.temperature_degC : sample.time_h) += more;
      const bool there = extended.run(fit.model, trial, sample, scene, &moved).has_value();
      if (there) readings.pick(scene, t, with);
      if (!there || !extended.run(fit.model, trial, sample, scene)) break;
      readings.pick(scene, t, without);
      result.segment(first, rows) +=
          (more > 0 ? 1 : -1) / step * (with - without).segment(first, rows);
    }
  }
  return result.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

/// What a cause bends by time or temperature may bend by something smooth that no column shows:
/// else a slow change that only looks like the cause would be called by its name.
void along_causes(
    UnknownSearch& search, const Readings& readings, const JointFit& fit,
    const simulation::ExtendedModel& extended, const Covariates& at,
    const Eigen::MatrixXd& tool) {
  for (const simulation::Effect* effect : simulation::all_effects()) {
    const bool by_temperature = (effect->needs & simulation::kTemperature) != 0;
    const bool by_time = (effect->needs & simulation::kTime) != 0;
    if (effect->is_step || !(by_temperature || by_time)) continue;
    for (const simulation::Place& place : effect->places(readings.model().rig())) {
      const simulation::ActiveEffect none{
          effect, place, std::vector<double>(effect->parameters.size(), 0.0)};
      Eigen::MatrixXd stage(readings.count(), 0);
      for (std::size_t k = 0; k < static_cast<std::size_t>(linear_count(*effect)); ++k) {
        const Eigen::VectorXd column =
            per_unit(readings, fit, extended, none, k, by_temperature);
        if (is_shift_of_tool(column, tool)) continue;
        stage.conservativeResize(Eigen::NoChange, stage.cols() + 1);
        stage.rightCols(1) = column;
      }
      if (stage.cols() == 0 || !(stage.norm() > 0)) continue;
      search.along("time", place.name, at.time, stage, kFew);
      search.along("temperature", place.name, at.temperature, stage, kFew);
    }
  }
}

/// Anything of one dial that depends on its own reading, on time or on temperature.
void along_dial(
    UnknownSearch& search, const Readings& readings, const Covariates& at,
    const Eigen::VectorXd& simulated_mm, std::size_t dial) {
  constexpr std::size_t kFewestReadings = 12;
  if (readings.rows_of_dial(dial).size() < kFewestReadings) return;
  const Eigen::VectorXd own = own_reading_mm(readings, simulated_mm, dial);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(readings.count(), 1);
  for (const Eigen::Index row : readings.rows_of_dial(dial)) rows(row, 0) = 1.0;
  const std::string& id = readings.model().rig().dials[dial].id;
  const std::string name = "dial " + id;
  search.along(
      dependence_name({.on = DependsOn::kReading, .dial = id}), name, own, rows, kOfDial,
      kAlongDial);
  search.along("time", name, at.time, rows, kFew);
  search.along("temperature", name, at.temperature, rows, kFew);
}

}  // namespace

Eigen::MatrixXd random_columns(Eigen::Index readings, const std::vector<UnknownCandidate>& of) {
  Eigen::MatrixXd result(readings, 0);
  for (const UnknownCandidate& each : of) {
    const Eigen::Index before = result.cols();
    result.conservativeResize(Eigen::NoChange, before + each.columns.cols());
    result.rightCols(each.columns.cols()) = each.columns;
  }
  return result;
}

int count_of_smooth(const Readings& readings) {
  const auto& trials = readings.trials();
  const Eigen::Index joints = trials.empty() ? 0 : trials.front().q.size();
  const auto dials = readings.has_dials() ? readings.model().rig().dials.size() : 0;
  // About as many as score_unknown tries: what counts is the logarithm.
  return static_cast<int>(
      3 + 2 * joints + 2 * readings.model().robot_parameter_count() +
      static_cast<Eigen::Index>(dials > 0 ? 4 + 3 * dials : 0));
}

std::vector<RandomBox> smooth_in_time(const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Covariates at = covariates_of(readings, fit, extended);
  std::vector<RandomBox> result;
  const auto u = scaled(at.time);
  if (!u) return result;
  const Eigen::MatrixXd tool = stage_columns(
      readings, fit.model, extended, readings.simulate(fit.model, extended), Stage::kTool);
  for (const Box& box : boxes_along()) {
    const Eigen::MatrixXd basis = basis_of(readings.of_used(*u), box.half_width, kOfTime);
    Eigen::MatrixXd columns(readings.count(), kOfTime * tool.cols());
    for (Eigen::Index row = 0; row < columns.rows(); ++row) {
      const Eigen::Index trial = readings.place_of(row);
      for (Eigen::Index s = 0; s < tool.cols(); ++s) {
        columns.block(row, s * kOfTime, 1, kOfTime) = tool(row, s) * basis.row(trial);
      }
    }
    for (const double length : box.lengths) {
      Eigen::VectorXd spread(columns.cols());
      for (Eigen::Index k = 0; k < spread.size(); ++k) {
        const int j = static_cast<int>(k) % kOfTime;
        spread[k] = std::sqrt(spectrum(j, box.half_width, length));
      }
      RandomBox own{scaled_columns(columns, spread, prominent(columns, spread)), {}};
      own.spread.push_back(Eigen::VectorXd::Ones(own.columns.cols()));
      result.push_back(std::move(own));
    }
  }
  return result;
}

std::vector<UnknownCandidate> score_joint_by_others(
    const Readings& readings, const JointFit& fit, int joint) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::MatrixXd stage = stage_columns(
      readings, fit.model, extended, readings.simulate(fit.model, extended), Stage::kJointAngle,
      joint);
  const Covariates at = covariates_of(readings, fit, extended);
  UnknownSearch search(readings, fit);
  along_joint(search, readings, at, stage, joint, joint);
  for (int other = 0; other < static_cast<int>(at.q.cols()); ++other) {
    if (other != joint) along_joint(search, readings, at, stage, joint, other);
    waves_along_joint(search, readings, at, stage, joint, other);
  }
  return search.as_tried();
}

std::vector<UnknownCandidate> score_joint_curves(
    const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  const Covariates at = covariates_of(readings, fit, extended);
  std::vector<UnknownCandidate> result;
  for (int joint = 0; joint < static_cast<int>(at.q.cols()); ++joint) {
    UnknownSearch search(readings, fit);
    along_joint(
        search, readings, at,
        stage_columns(readings, fit.model, extended, simulated, Stage::kJointAngle, joint),
        joint, joint);
    std::vector<UnknownCandidate> found = search.as_tried();
    result.push_back(found.empty() ? UnknownCandidate{} : std::move(found.front()));
  }
  return result;
}

std::vector<UnknownCandidate> score_unknown(const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  const auto stage = [&](Stage where, int joint = -1) -> Eigen::MatrixXd {
    return stage_columns(readings, fit.model, extended, simulated, where, joint);
  };
  const Covariates at = covariates_of(readings, fit, extended);

  UnknownSearch search(readings, fit);
  for (int joint = 0; joint < static_cast<int>(at.q.cols()); ++joint) {
    const Eigen::MatrixXd bent = stage(Stage::kJointAngle, joint);
    along_joint(search, readings, at, bent, joint, joint);
    waves_along_joint(search, readings, at, bent, joint, joint);
  }
  const Eigen::MatrixXd tool = stage(Stage::kTool);
  search.along("time", "tool", at.time, tool, kOfTime);
  search.along("temperature", "tool", at.temperature, tool, kFew);
  if (const auto place = places_of(readings, at, tool)) search.over(*place, "tool", tool);
  search.by_approach(at.approach, "tool", tool);
  along_robot(search, readings, fit, at, tool);
  along_causes(search, readings, fit, extended, at, tool);
  if (readings.has_dials()) {
    const Eigen::MatrixXd side = stage(Stage::kCuboidSide);
    search.along("time", "cuboid", at.time, side, kFew);
    search.along("temperature", "cuboid", at.temperature, side, kFew);
    const Eigen::MatrixXd clamp = stage(Stage::kCuboidAngle);
    search.along("time", "clamp", at.time, clamp, kFew);
    search.along("gamma", "clamp", at.gamma, clamp, kFew);
    for (std::size_t d = 0; d < readings.model().rig().dials.size(); ++d) {
      along_dial(search, readings, at, simulated, d);
    }
    along_background(search, readings, simulated);
    along_rig(search, readings, fit);
  }
  along_masses(search, readings, fit, extended, simulated);
  return search.ranked();
}

}  // namespace sixdial::diagnosis
