#include "studies/live_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "session/trials.h"
#include "studies/seen_rig.h"

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
      taken_{calibration::OnlineEstimator(geometry::Tool(rig), rig.robot.nominal)},
      workspace_(calibration::workspace_grid(
          filter().tool(), rig.robot.nominal, area_.low_mm, area_.high_mm, kGrid, kGrid,
          area_.used)),
      uncertainty_(filter().predicted(workspace_)) {
  if (!workspace_.empty()) return;
  // The nominal robot reaches no place of a grid with its tool turned as it comes: the points
  // themselves then.
  const std::size_t step = std::max<std::size_t>(1, points.size() / (kGrid * kGrid));
  for (std::size_t i = 0; i < points.size(); i += step) {
    const session::Branch branch = session::branch_of(rig, points[i]);
    workspace_.push_back({points[i].target_mm, points[i].q, branch.assembly, branch.mode});
  }
  uncertainty_ = filter().predicted(workspace_);
}

bool LiveEstimate::Taken::take_in(const RigSoFar::Measured& sample) {
  const int measured = filter.tool().axes() * filter.samples();
  const double from = studies::unusual_from(measured - filter.tool().robot().parameter_count());
  const auto told = filter.add(sample.trial, sample.shared);
  if (!told) return false;
  unusual_from = from;
  last_times_usual = told->times_usual;
  return true;
}

void LiveEstimate::see_rig(std::span<const session::Sample> samples) {
  RigSoFar rig = rig_;
  rig.fit(samples);
  measure_by(std::move(rig));
}

/// Everything anew; only complete it takes the place of what was.
void LiveEstimate::measure_by(RigSoFar rig) {
  Taken anew{calibration::OnlineEstimator(geometry::Tool(rig.rig()), rig.rig().robot.nominal)};
  for (const RigSoFar::Measured& each : rig.measured(rig.samples())) anew.take_in(each);
  rig_ = std::move(rig);
  taken_ = std::move(anew);
  uncertainty_ = filter().predicted(workspace_);
}

bool LiveEstimate::add(const session::Sample& sample) {
  if (sample.set != "G1") return false;
  rig_.add(sample);
  const bool told = taken_.take_in(rig_.measured({&sample, 1}).front());
  if (told) uncertainty_ = filter().predicted(workspace_);
  if (!rig_.is_due()) return told;
  RigSoFar rig = rig_;
  if (rig.fit()) {
    measure_by(std::move(rig));
  } else {
    rig_ = std::move(rig);  // which is due again later
  }
  return told;
}

bool LiveEstimate::below(double limit_mm) const {
  return filter().samples() >= kLeastSamples && uncertainty_.poses > 0 &&
         uncertainty_.max_mm < limit_mm;
}

EstimateSummary LiveEstimate::summary() const {
  EstimateSummary summary{
      .samples = filter().samples(),
      .set_aside = filter().set_aside(),
      .noise_times = std::sqrt(filter().variance_factor()),
      .position_sd_mean_mm = uncertainty_.mean_mm,
      .position_sd_max_mm = uncertainty_.max_mm,
      .last_times_usual = last_times_usual(),
      .last_unusual = last_unusual()};
  const Eigen::MatrixXd by_rig = filter().shared_covariance();
  const Eigen::MatrixXd covariance = filter().P() + by_rig;
  const auto& infos = filter().tool().robot().parameters;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EstimatedParameter& row = summary.parameters.emplace_back(EstimatedParameter{
        .name = infos[i].name,
        .unit = infos[i].unit,
        .value = filter().v()[k],
        .sd = std::sqrt(covariance(k, k))});
    if (!infos[i].plainly.empty()) row.meaning = infos[i].plainly;
  }
  if (uncertainty_.poses > 0) {
    const calibration::WorkspacePose& worst = workspace_[uncertainty_.worst];
    summary.worst_mm = worst.target_mm;
    if (filter().has_shared()) {
      summary.position_sd_rig_mm =
          calibration::position_sd_mm(filter().tool(), filter().v(), by_rig, worst);
    }
  }
  if (rig_.seen()) summary.rig = seen_of(*rig_.seen());
  if (const double condition = filter().condition(); std::isfinite(condition)) {
    summary.condition = condition;
  }
  for (const int i : filter().undetermined()) {
    summary.undetermined.push_back(infos[static_cast<std::size_t>(i)].name);
  }
  return summary;
}

}  // namespace sixdial::studies
