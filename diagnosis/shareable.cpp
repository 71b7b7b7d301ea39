#include "diagnosis/shareable.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <map>
#include <utility>

#include "diagnosis/stages.h"
#include "diagnosis/thresholds.h"
#include "geometry/same_pose.h"

namespace sixdial::diagnosis {
namespace {

/// Whether the robot stood still between sample t - 1 and t.
bool stood_still(const Readings& readings, std::size_t t) {
  const auto& joints = readings.model().robot().joints;
  const simulation::Trial& now = readings.trials()[t];
  const simulation::Trial& before = readings.trials()[t - 1];
  if (now.assembly != before.assembly) return false;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto joint = static_cast<Eigen::Index>(j);
    if (std::abs(now.q[joint] - before.q[joint]) > geometry::same_pose(joints[j].unit())) {
      return false;
    }
    if (now.approach_of(j) * before.approach_of(j) < 0) return false;
  }
  return true;
}

/// Joints of another unit than the first scatter as much as encoders of their kind do.
double alike(const std::vector<geometry::JointInfo>& joints, Eigen::Index j) {
  return geometry::same_pose(joints[static_cast<std::size_t>(j)].unit()) /
         geometry::same_pose(joints.front().unit());
}

std::vector<Eigen::Index> blocks_of(const Readings& readings, bool of_stops) {
  std::vector<Eigen::Index> first_row;
  bool moved = true;  // since the last sample that counts
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    moved = moved || t == 0 || !stood_still(readings, t);
    if (!readings.has_rows(t)) continue;
    if (!of_stops || moved) first_row.push_back(readings.first_row(t));
    moved = false;
  }
  first_row.push_back(readings.count());
  return first_row;
}

}  // namespace

std::vector<std::shared_ptr<const ScatterColumns>> shareable_columns(
    const Readings& readings, const simulation::ModelVector& at) {
  std::vector<std::shared_ptr<const ScatterColumns>> result;
  const simulation::ExtendedModel plain(readings.model(), {});
  const Eigen::VectorXd simulated = readings.simulate(at, plain);
  Eigen::MatrixXd joints(
      readings.count(), static_cast<Eigen::Index>(readings.model().robot().joints.size()));
  for (Eigen::Index j = 0; j < joints.cols(); ++j) {
    joints.col(j) =
        alike(readings.model().robot().joints, j) *
        stage_columns(readings, at, plain, simulated, Stage::kJointAngle, static_cast<int>(j));
  }
  const bool free = readings.nuisance().cols() > 0;
  const std::vector<Eigen::Index> samples = blocks_of(readings, false);
  const std::vector<Eigen::Index> stops = blocks_of(readings, true);
  const auto add = [&](ScatterOf of, bool of_stops, const Eigen::MatrixXd& columns) {
    result.push_back(std::make_shared<const ScatterColumns>(
        ScatterColumns{of, of_stops, columns, of_stops ? stops : samples}));
  };
  if (!readings.has_dials()) {
    if (static_cast<double>(samples.size() - 1) < kFewestOfScatter) return result;
    add(ScatterOf::kJoints, false, joints);
    if (stops.size() != samples.size()) add(ScatterOf::kJoints, true, joints);
    return result;
  }
  const auto leaves_enough = [&](Eigen::Index columns) {
    const auto taken =
        static_cast<double>(columns + (free ? 1 : 0)) * static_cast<double>(samples.size() - 1);
    return static_cast<double>(readings.count()) - taken >= kFewestOfScatter;
  };
  const Eigen::MatrixXd tool = stage_columns(readings, at, plain, simulated, Stage::kTool);
  // Both at once: half of the tool's variance from either. Which half it is matters little,
  // that the cuboid turns with one of them does.
  const double per_unit_mm = tool_motion_mm(readings, at, ScatterOf::kJoints);
  Eigen::MatrixXd both(tool.rows(), tool.cols() + joints.cols());
  both << tool, joints / std::max(1e-300, per_unit_mm);
  both *= std::sqrt(0.5);
  for (const bool of_stops : {false, true}) {
    if (of_stops && stops.size() == samples.size()) break;
    if (leaves_enough(tool.cols())) add(ScatterOf::kTool, of_stops, tool);
    if (leaves_enough(joints.cols())) add(ScatterOf::kJoints, of_stops, joints);
    if (per_unit_mm > 0 && leaves_enough(both.cols())) {
      add(ScatterOf::kTool, of_stops, both);
    }
  }
  return result;
}

bool at_same_pose(const Readings& readings, Eigen::Index a, Eigen::Index b) {
  const auto trial_of = [&](Eigen::Index row) -> const simulation::Trial& {
    const int trial = readings.rows()[static_cast<std::size_t>(row)].trial;
    return readings.trials()[static_cast<std::size_t>(trial)];
  };
  const simulation::Trial& first = trial_of(a);
  const simulation::Trial& other = trial_of(b);
  const auto& joints = readings.model().robot().joints;
  for (Eigen::Index j = 0; j < first.q.size(); ++j) {
    const auto joint = static_cast<std::size_t>(j);
    if (first.approach_of(joint) * other.approach_of(joint) < 0) return false;
    const double apart = std::abs(first.q[j] - other.q[j]);
    if (apart > geometry::same_pose(joints[joint].unit())) return false;
  }
  return true;
}

bool comes_back(
    const Readings& readings, const ScatterColumns& columns, const LeftAtRepeats& left) {
  const Eigen::VectorXd own = left.residual_mm.cwiseQuotient(left.noise);
  const double variance = left.weight.dot(own.cwiseAbs2()) / std::max(1e-12, left.weight.sum());
  // By point and channel: rows of different arrivals.
  std::map<std::pair<int, int>, std::vector<Eigen::Index>> groups;
  for (std::size_t b = 0; b < columns.blocks(); ++b) {
    for (Eigen::Index row = columns.first_row[b]; row < columns.first_row[b + 1]; ++row) {
      if (left.weight[row] <= kGoodWeight) continue;
      const Row& each = readings.rows()[static_cast<std::size_t>(row)];
      const int point = readings.trials()[static_cast<std::size_t>(each.trial)].point;
      auto& group = groups[{point, each.dial}];
      const bool another = group.empty() || group.back() < columns.first_row[b];
      if (another && (group.empty() || at_same_pose(readings, group.front(), row))) {
        group.push_back(row);
      }
    }
  }
  double squares = 0.0;
  double freedom = 0.0;
  for (const auto& [key, rows] : groups) {
    if (rows.size() < 2) continue;
    squares += (own(rows).array() - own(rows).mean()).square().sum();
    freedom += static_cast<double>(rows.size()) - 1;
  }
  // Readings of one arrival are no independent witnesses of its shift.
  constexpr double kReadingsOfAShift = 3.0;
  constexpr double kLevel = 1e-3;
  const double told = freedom / kReadingsOfAShift;
  if (told < 3 || !(variance > 0.0)) return false;
  const boost::math::chi_squared law(told);
  return squares / (variance * freedom) * told < boost::math::quantile(law, kLevel);
}

double tool_motion_mm(
    const Readings& readings, const simulation::ModelVector& at, ScatterOf of) {
  if (of == ScatterOf::kTool) return 1.0;
  const simulation::ForwardModel& model = readings.model();
  const bool free = model.rig().cuboid.mount == geometry::Mount::kFree;
  double squares = 0.0;
  int counted = 0;
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    if (!readings.has_rows(t)) continue;
    const simulation::Trial& trial = readings.trials()[t];
    const auto gamma = free ? trial.gamma_rad : std::nullopt;
    const auto here = model.predict(at, trial.q, trial.assembly, gamma, false);
    if (!here) continue;
    bool whole = true;
    double sum = 0.0;
    for (Eigen::Index j = 0; j < trial.q.size() && whole; ++j) {
      constexpr double kStep = 1e-6;
      Eigen::VectorXd q = trial.q;
      q[j] += kStep;
      const auto moved = model.predict(at, q, trial.assembly, gamma, false);
      whole = moved.has_value();
      if (!whole) break;
      const Eigen::Vector3d way = moved->frames.X[0].p - here->frames.X[0].p;
      sum += (alike(model.robot().joints, j) / kStep * way).squaredNorm();
    }
    if (!whole) continue;
    squares += sum / static_cast<double>(readings.axes());
    ++counted;
  }
  return counted > 0 ? std::sqrt(squares / counted) : 0.0;
}

}  // namespace sixdial::diagnosis
