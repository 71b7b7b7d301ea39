#include "studies/live_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "session/trials.h"

namespace sixdial::studies {
namespace {

constexpr int kGrid = 7;  // poses along each side of the workspace
// The filter judges the noise by residuals from ten degrees of freedom on: ten positions.
constexpr int kLeastSamples = 10;

void add_once(std::vector<geometry::WorkingMode>& modes, geometry::WorkingMode mode) {
  if (std::ranges::find(modes, mode) == modes.end()) modes.push_back(mode);
}

}  // namespace

WorkingArea working_area(const geometry::Rig& rig, std::span<const session::PlanPoint> points) {
  WorkingArea area;
  area.low_mm.setZero(rig.instrument.dimensions);
  area.low_mm.head<2>() = rig.cuboid.reference_pose_mm;
  area.high_mm = area.low_mm;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const geometry::Position& target = points[i].target_mm;
    area.low_mm = i == 0 ? target : geometry::Position(area.low_mm.cwiseMin(target));
    area.high_mm = i == 0 ? target : geometry::Position(area.high_mm.cwiseMax(target));
    add_once(area.measured, session::branch_of(rig, points[i]).mode);
  }
  const bool rigs_own =
      std::ranges::find(area.measured, rig.robot.working_mode) != area.measured.end();
  if (area.measured.empty() || rigs_own) {
    area.used = {rig.robot.working_mode};
  } else {
    area.used = area.measured;
  }
  return area;
}

std::vector<session::PlanPoint> points_of(const session::Session& session) {
  std::vector<session::PlanPoint> points;
  for (const session::Sample& sample : session.samples) {
    std::optional<session::Position> place = sample.target_mm;
    if (!place) {
      const auto measured = session::trial_of(session.rig, sample).position_mm;
      if (measured) place = *measured;
    }
    if (!place) continue;
    points.push_back({sample.set, sample.point, sample.repeat, *place, sample.q, {}});
  }
  return points;
}

double unusual_from(int freedom) {
  constexpr double kOnceIn = 1e6;
  if (freedom < 1) return std::numeric_limits<double>::infinity();
  // P(F(2, n) > f) = (1 + 2 f / n)^(-n / 2)
  const double f = 0.5 * freedom * (std::pow(kOnceIn, 2.0 / freedom) - 1);
  return std::max(kUnusual, std::sqrt(f));
}

LiveEstimate::LiveEstimate(const geometry::Rig& rig, std::span<const session::PlanPoint> points)
    : rig_(rig),
      area_(working_area(rig, points)),
      filter_(geometry::Tool(rig), rig.robot.nominal),
      workspace_(calibration::workspace_grid(
          filter_.tool(), rig.robot.nominal, area_.low_mm, area_.high_mm, kGrid, kGrid,
          area_.used)),
      uncertainty_(filter_.predicted(workspace_)) {
  if (!workspace_.empty()) return;
  // The nominal robot reaches no place of a grid with its tool turned as it comes: the points
  // themselves then.
  const std::size_t step = std::max<std::size_t>(1, points.size() / (kGrid * kGrid));
  for (std::size_t i = 0; i < points.size(); i += step) {
    const session::Branch branch = session::branch_of(rig, points[i]);
    workspace_.push_back({points[i].target_mm, points[i].q, branch.assembly, branch.mode});
  }
  uncertainty_ = filter_.predicted(workspace_);
}

bool LiveEstimate::add(const session::Sample& sample) {
  if (sample.set != "G1") return false;
  const int measured = filter_.tool().axes() * filter_.samples();
  const double from = unusual_from(measured - filter_.tool().robot().parameter_count());
  const auto told = filter_.add(session::trial_of(rig_, sample));
  if (!told) return false;
  unusual_from_ = from;
  last_times_usual_ = told->times_usual;
  uncertainty_ = filter_.predicted(workspace_);
  return true;
}

bool LiveEstimate::below(double limit_mm) const {
  return filter_.samples() >= kLeastSamples && uncertainty_.poses > 0 &&
         uncertainty_.max_mm < limit_mm;
}

EstimateSummary LiveEstimate::summary() const {
  EstimateSummary summary{
      .samples = filter_.samples(),
      .set_aside = filter_.set_aside(),
      .noise_times = std::sqrt(filter_.variance_factor()),
      .position_sd_mean_mm = uncertainty_.mean_mm,
      .position_sd_max_mm = uncertainty_.max_mm,
      .last_times_usual = last_times_usual_,
      .last_unusual = last_unusual()};
  const auto& infos = filter_.tool().robot().parameters;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EstimatedParameter& row = summary.parameters.emplace_back(EstimatedParameter{
        .name = infos[i].name,
        .unit = infos[i].unit,
        .value = filter_.v()[k],
        .sd = std::sqrt(filter_.P()(k, k))});
    if (!infos[i].plainly.empty()) row.meaning = infos[i].plainly;
  }
  if (uncertainty_.poses > 0) summary.worst_mm = workspace_[uncertainty_.worst].target_mm;
  if (const double condition = filter_.condition(); std::isfinite(condition)) {
    summary.condition = condition;
  }
  for (const int i : filter_.undetermined()) {
    summary.undetermined.push_back(infos[static_cast<std::size_t>(i)].name);
  }
  return summary;
}

}  // namespace sixdial::studies
