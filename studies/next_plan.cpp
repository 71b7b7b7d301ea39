#include "studies/next_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/long_work.h"
#include "session/plan_in_space.h"
#include "studies/error.h"
#include "studies/live_estimate.h"
#include "studies/plausibility.h"

namespace sixdial::studies {
namespace {

constexpr int kCandidates = 21;  // along each side, in each working mode
constexpr double kRounding_mm = 1e6;
constexpr double kRounding_rad = 1e9;

// To what a plan file holds.
Eigen::VectorXd rounded(const Eigen::VectorXd& v, double per_unit) {
  return (v * per_unit).array().round() / per_unit;
}

/// How far from the target the tool may be: as plan grid has it, more where the estimate says
/// so (near singular poses small errors of the links grow).
double robot_error_mm(
    const calibration::OnlineEstimator& filter, const calibration::WorkspacePose& pose) {
  constexpr int kEnough = 6;
  constexpr double kSigmas = 3.0;
  const double usual_mm = session::PlanOptions{}.robot_error_mm;
  if (filter.samples() < kEnough) return usual_mm;
  const auto there = filter.tool().position(filter.v(), pose.q, pose.assembly);
  if (!there) return usual_mm;
  const double sd_mm =
      calibration::position_sd_mm(filter.tool(), filter.v(), filter.covariance(), pose);
  return std::max(usual_mm, (*there - pose.target_mm).norm() + kSigmas * sd_mm);
}

/// What plan next chooses from, in one working mode, and why not from more.
struct Candidates {
  std::vector<calibration::WorkspacePose> poses;
  std::string why = "the robot cannot go there";
  std::string advice = "Leave this mode out, or give another rectangle.";
};

Candidates in_plane(
    const geometry::Rig& rig, const session::Rectangle& area, geometry::WorkingMode mode,
    const calibration::OnlineEstimator& filter) {
  Candidates found;
  const std::vector<geometry::WorkingMode> modes{mode};
  // Joint angles turn on from there without a jump at +-pi.
  const auto home =
      filter.tool().inverse(rig.robot.nominal, rig.cuboid.reference_pose_mm, mode);
  for (calibration::WorkspacePose& pose : calibration::workspace_grid(
           filter.tool(), rig.robot.nominal, area.min_mm, area.max_mm, kCandidates, kCandidates,
           modes)) {
    pose.target_mm = rounded(pose.target_mm, kRounding_mm);
    const auto q = session::measurable(
        rig, pose.target_mm, mode, robot_error_mm(filter, pose), home ? *home : pose.q);
    if (!q) {
      found.why = q.error().reason;
      continue;
    }
    pose.q = rounded(*q, kRounding_rad);
    found.poses.push_back(pose);
  }
  return found;
}

/// In the box, or anywhere in the joints' ranges; by chance, the same each time.
Candidates in_space(
    const geometry::Rig& rig, const std::optional<session::TargetBox>& box,
    geometry::WorkingMode mode) {
  Candidates found;
  session::Uniform random(1, "plan next");
  const auto drawn = session::drawn_in_space(rig, mode, box, kCandidates * kCandidates, random);
  if (!drawn) {
    found.why = drawn.error().reason;
    found.advice = drawn.error().advice;
    return found;
  }
  if (!drawn->why.empty()) found.why = drawn->why;
  for (const session::PlanPose& pose : drawn->poses) {
    found.poses.push_back({pose.target_mm, pose.q, rig.robot.assembly, mode});
  }
  return found;
}

/// The box around the session's targets; empty where there are none.
std::optional<session::TargetBox> box_of(
    const session::Session& session, const WorkingArea& area) {
  if (session.samples.empty() || area.low_mm.size() != 3) return std::nullopt;
  return session::TargetBox{area.low_mm, area.high_mm};
}

std::vector<calibration::DesignCandidate> candidates_in(
    const geometry::Rig& rig, const Candidates& found, const std::string& where,
    geometry::WorkingMode mode, const calibration::OnlineEstimator& filter) {
  std::vector<calibration::DesignCandidate> candidates;
  for (const calibration::WorkspacePose& pose : found.poses) {
    candidates.push_back(
        {pose, filter.axis_variance_mm2() *
                   Eigen::MatrixXd::Identity(filter.tool().axes(), filter.tool().axes())});
  }
  if (candidates.empty()) {
    const std::string name(rig.robot.model->mode_name(mode));
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format(
            "no pose{} can be measured in working mode {}: {}", where,
            name.empty() ? to_string(mode) : name, found.why),
        {{"mode", name.empty() ? to_string(mode) : name}}, found.advice);
  }
  return candidates;
}

/// Where a session without samples would be measured, for its modes and places.
std::vector<session::PlanPoint> usual_points(const geometry::Rig& rig) {
  std::vector<session::PlanPoint> points;
  if (session::works_in_space(rig)) {
    for (const auto& pose : in_space(rig, {}, rig.robot.working_mode).poses) {
      points.push_back({"G1", 0, 0, pose.target_mm, pose.q, {}});
    }
    return points;
  }
  const session::PlanOptions usual;  // as for plan grid
  const Eigen::Vector2d margin(usual.margin_mm, usual.margin_mm);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(usual.rectangle.min_mm + margin),
        Eigen::Vector2d(usual.rectangle.max_mm - margin)}) {
    const auto q =
        geometry::Tool(rig).inverse(rig.robot.nominal, corner, rig.robot.working_mode);
    if (q) points.push_back({"G1", 0, 0, corner, *q, {}});
  }
  return points;
}

PositionSd sd_of(const calibration::WorkspaceUncertainty& uncertainty) {
  return {.mean_mm = uncertainty.mean_mm, .max_mm = uncertainty.max_mm};
}

}  // namespace

NextPlan next_plan(const session::Session& session, const NextPlanRequest& request) {
  const geometry::Rig& rig = session.rig;
  const session::Session used = in_rig_frame(plausible(session), rig);
  std::vector<session::PlanPoint> places = points_of(used);
  if (places.empty()) places = usual_points(rig);
  LiveEstimate estimate(used.rig, places);
  estimate.see_rig(used.samples);
  int first = 0;
  for (const session::Sample& sample : used.samples) {
    geometry::check_end();
    if (!sample.left_out) estimate.add(sample);
    if (sample.set == "G1") first = std::max(first, sample.point + 1);
  }
  const WorkingArea& known = estimate.area();
  std::vector<geometry::WorkingMode> modes = request.modes;
  if (modes.empty()) modes = known.measured;
  if (modes.empty()) modes = {rig.robot.working_mode};
  std::vector<calibration::DesignCandidate> candidates;
  for (const geometry::WorkingMode mode : modes) {
    Candidates found;
    std::string where;
    if (session::works_in_space(rig)) {
      found = in_space(rig, box_of(used, known), mode);
    } else {
      const session::Rectangle area = request.rectangle.value_or(
          session::Rectangle{known.low_mm.head<2>(), known.high_mm.head<2>()});
      found = in_plane(rig, area, mode, estimate.filter());
      where = fmt::format(
          " of x {:.1f}..{:.1f}, y {:.1f}..{:.1f} mm", area.min_mm.x(), area.max_mm.x(),
          area.min_mm.y(), area.max_mm.y());
    }
    const auto more = candidates_in(rig, found, where, mode, estimate.filter());
    candidates.insert(candidates.end(), more.begin(), more.end());
  }
  const auto steps = calibration::greedy_design(
      estimate.filter().tool(), estimate.filter().v(), estimate.filter().information(),
      candidates, estimate.workspace(), request.points, request.criterion, 1,
      estimate.filter().shared_covariance());

  NextPlan next;
  next.figures = {
      .samples = estimate.filter().samples(),
      .points = static_cast<int>(steps.size()),
      .criterion = request.criterion,
      .now = sd_of(estimate.uncertainty())};
  for (const calibration::DesignStep& step : steps) {
    const calibration::WorkspacePose& pose = candidates[step.candidate].pose;
    next.figures.after = sd_of(step.uncertainty);
    next.figures.steps.push_back(
        {.target_mm = pose.target_mm, .mode = pose.mode, .after = sd_of(step.uncertainty)});
    next.plan.points.push_back({"G1", 0, 0, pose.target_mm, pose.q, {}});
  }
  order_by_branch(rig, next.plan, first);
  return next;
}

void order_by_branch(const geometry::Rig& rig, session::Plan& plan, int first) {
  std::vector<session::Branch> branches;
  for (const session::PlanPoint& point : plan.points) {
    const session::Branch branch = session::branch_of(rig, point);
    if (std::ranges::find(branches, branch) == branches.end()) branches.push_back(branch);
  }
  std::ranges::stable_sort(plan.points, {}, [&](const session::PlanPoint& point) {
    return std::ranges::find(branches, session::branch_of(rig, point)) - branches.begin();
  });
  for (session::PlanPoint& point : plan.points) point.point = first++;
}

}  // namespace sixdial::studies
