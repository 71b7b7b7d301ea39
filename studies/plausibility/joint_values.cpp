// Where joint values were both commanded and read back: which of them say where the joints
// stood? A controller may echo its command, stop short of it, or read an encoder that slips.
// Both fit the robot to half of the poses and are judged on the other half, by turns.
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "calibration/pose_groups.h"
#include "calibration/reading_space.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/registration.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/plausibility/check.h"
#include "studies/plausibility/tool_seen.h"

namespace sixdial::studies::plausibility {
namespace {

using calibration::ObservationSpace;
using simulation::Trial;

constexpr double kSurely = 3.3;       // standard deviations of the count of poses: 1 in 1,000
constexpr double kClearly = 1.1;      // and so many times smaller
constexpr std::size_t kFewest = 12;   // poses to judge by
constexpr double kSameValue = 1e-12;  // of the values themselves: nothing was read anew

/// Both are there, and finite.
bool has_both(const session::Sample& sample) {
  return sample.q_command.size() == sample.q.size() && sample.q_command.allFinite();
}

session::Session by_command(session::Session session) {
  for (session::Sample& sample : session.samples) {
    if (has_both(sample)) sample.q = sample.q_command;
  }
  return session;
}

/// What the rig's instrument measured, as something that the robot can be fitted to.
ObservationSpace space_of(const std::vector<Trial>& trials, const geometry::Rig& rig) {
  if (!session::layout_of(rig).others.empty()) return calibration::reading_space(trials, rig);
  const bool positions = std::ranges::any_of(trials, [](const Trial& each) {
    return each.position_mm && each.position_channels.empty();
  });
  return positions || rig.dials.empty() ? calibration::position_space(trials, rig)
                                        : calibration::dial_space(trials, rig);
}

/// Root mean square of what a fit of the other half leaves, by the row of the session.
std::map<int, double> held_out_errors(
    const session::Session& session, const std::vector<Trial>& trials,
    const std::vector<int>& pose) {
  std::map<int, double> error_mm;
  for (const int half : {0, 1}) {
    std::vector<Trial> fitted;
    std::vector<Trial> judged;
    for (std::size_t i = 0; i < trials.size(); ++i) {
      (pose[i] % 2 == half ? fitted : judged).push_back(trials[i]);
    }
    const ObservationSpace space = space_of(fitted, session.rig);
    if (space.samples() == 0 || space.rows() <= space.parameters()) return {};
    calibration::SpaceFitSettings settings;
    settings.weighting = calibration::Weighting::kBySigma;
    settings.loss = calibration::Loss::kCauchy;
    const calibration::SpaceFit fit = calibration::fit_space(space, settings);
    const ObservationSpace other = space_of(judged, session.rig);
    Eigen::VectorXd e;
    for (int i = 0; i < calibration::measured_samples(other); ++i) {
      e.resize(other.rows(i));
      if (e.size() == 0 || !other.evaluate(i, fit.v, e, nullptr)) continue;
      error_mm[other.sample[static_cast<std::size_t>(i)]] =
          e.norm() / std::sqrt(static_cast<double>(e.size()));
    }
  }
  return error_mm;
}

/// Both ways, pose by pose.
struct Judgement {
  int poses = 0;
  int command_nearer = 0;
  double read_mm = 0.0, command_mm = 0.0;  // median of a pose
  /// How surely the poses say that the commanded values are nearer; below zero: those read.
  [[nodiscard]] double surely() const {
    return (2.0 * command_nearer - poses) / std::sqrt(static_cast<double>(poses));
  }
};

Judgement judge(
    const std::vector<Trial>& trials, const std::vector<int>& pose,
    const std::map<int, double>& read, const std::map<int, double>& command) {
  std::map<int, std::pair<double, double>> of_pose;  // sums of squares
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const auto a = read.find(trials[i].sample);
    const auto b = command.find(trials[i].sample);
    if (a == read.end() || b == command.end()) continue;
    auto& [by_read, by_command] = of_pose[pose[i]];
    by_read += a->second * a->second;
    by_command += b->second * b->second;
  }
  Judgement result;
  std::vector<double> by_read;
  std::vector<double> by_command;
  for (const auto& [number, both] : of_pose) {
    ++result.poses;
    if (both.second < both.first) ++result.command_nearer;
    by_read.push_back(std::sqrt(both.first));
    by_command.push_back(std::sqrt(both.second));
  }
  if (result.poses == 0) return result;
  result.read_mm = geometry::median_of(std::move(by_read));
  result.command_mm = geometry::median_of(std::move(by_command));
  return result;
}

bool is_echo(const session::Session& session, const std::vector<std::size_t>& rows) {
  return std::ranges::all_of(rows, [&](std::size_t row) {
    const session::Sample& sample = session.samples[row];
    return (sample.q - sample.q_command).cwiseAbs().maxCoeff() < kSameValue;
  });
}

WarningPlace command_columns(const session::Session& session) {
  std::string names;
  for (const session::Joint& joint : session::layout_of(session.rig).joints) {
    names += (names.empty() ? "" : ", ") + joint.command_column();
  }
  return {.file = "session.csv", .field = names};
}

}  // namespace

void look_at_joint_values(Look& look) {
  session::Session few = look.used;
  for (session::Sample& sample : few.samples) {
    sample.left_out = sample.left_out || !has_both(sample);
  }
  const std::vector<std::size_t> rows = looked_rows(few);
  if (rows.empty()) return;
  if (is_echo(few, rows)) {
    look.tell("joints_echo_command", Severity::kNote, command_columns(few));
    return;
  }
  std::vector<bool> looked(few.samples.size(), false);
  for (const std::size_t row : rows) looked[row] = true;
  for (std::size_t i = 0; i < few.samples.size(); ++i) few.samples[i].left_out = !looked[i];
  const std::vector<Trial> read = session::trials_of(few, "");
  const std::vector<Trial> command = session::trials_of(by_command(few), "");
  Eigen::MatrixXd joints(std::ssize(command), few.samples.front().q.size());
  for (std::size_t i = 0; i < command.size(); ++i) {
    joints.row(static_cast<Eigen::Index>(i)) = command[i].q.transpose();
  }
  const std::vector<int> pose = calibration::pose_groups(joints);
  const Judgement judged =
      judge(read, pose, held_out_errors(few, read, pose), held_out_errors(few, command, pose));
  if (judged.poses < static_cast<int>(kFewest)) {
    look.tell("few_poses_for_commands", Severity::kNote, command_columns(few));
    return;
  }
  const WarningParts parts{
      {"commanded", judged.command_mm},
      {"read", judged.read_mm},
      {"nearer", static_cast<double>(judged.command_nearer)},
      {"poses", static_cast<double>(judged.poses)}};
  if (judged.surely() > kSurely && judged.read_mm > kClearly * judged.command_mm) {
    look.tell("commanded_joints_fit_better", Severity::kNote, command_columns(few), parts);
    look.used = by_command(std::move(look.used));
  } else if (judged.surely() < -kSurely && judged.command_mm > kClearly * judged.read_mm) {
    look.tell("read_joints_fit_better", Severity::kNote, command_columns(few), parts);
  } else {
    look.tell("commanded_joints_alike", Severity::kNote, command_columns(few), parts);
  }
}

}  // namespace sixdial::studies::plausibility
