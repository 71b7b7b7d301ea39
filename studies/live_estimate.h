// What is known of the robot while its session is being collected: the filter of
// calibration/online.h over the samples of G1 as they come, and how well the tool's position
// would be known over the workspace. The same for a session that is done: where plan next
// begins. Positions are of the rig as the samples so far see it (rig_so_far.h), and what is not
// known of the rig is in every standard deviation.
//
// Example:
//   LiveEstimate estimate(rig, points_of(session));
//   estimate.see_rig(session.samples);
//   for (const session::Sample& sample : session.samples) estimate.add(sample);
//   show(estimate.uncertainty().max_mm);
//   estimate.below(1.0);  // -> true
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/online.h"
#include "diagnosis/rig_seen.h"
#include "session/plan.h"
#include "session/session.h"
#include "studies/rig_so_far.h"

namespace sixdial::studies {

/// Where the robot will be used: the rectangle of the targets; in the rig's working mode if any
/// point is in it, else in the modes of the points.
struct WorkingArea {
  geometry::Position low_mm, high_mm;  // in W
  std::vector<geometry::WorkingMode> used;
  std::vector<geometry::WorkingMode> measured;  // that any point has, in order of appearance
};
[[nodiscard]] WorkingArea working_area(
    const geometry::Rig& rig, std::span<const session::PlanPoint> points);
/// The samples as planned points: those without a target at their measured position, without
/// both left out.
[[nodiscard]] std::vector<session::PlanPoint> points_of(const session::Session& session);

/// A sample whose residual is at least this many times the usual one is worth another look.
inline constexpr double kUnusual = 6.0;
/// From how many times the usual residual on a sample is unusual: kUnusual, or more while few
/// samples say what is usual, such that noise alone goes beyond it once in a million samples (F
/// distribution with 2 and `freedom` degrees of freedom). Infinite without any.
[[nodiscard]] double unusual_from(int freedom);

struct EstimatedParameter {
  std::string name{};
  std::string unit{};                    // of value and sd: "mm" or "rad"
  std::optional<std::string> meaning{};  // for who stands at the rig, if the kind has words
  double value = 0.0;
  double sd = 0.0;
};

/// What is told of the estimate after a sample.
struct EstimateSummary {
  int samples = 0;           // of G1, that told something
  int set_aside = 0;         // of them, that did not fit at all
  double noise_times = 0.0;  // the residuals' noise, in times of the dials' own
  std::vector<EstimatedParameter> parameters{};
  double position_sd_mean_mm = 0.0, position_sd_max_mm = 0.0;  // over the workspace
  /// The part of position_sd_max_mm that what is not known of the rig makes, which no number of
  /// samples averages out; empty: the rig file states nothing of it.
  std::optional<double> position_sd_rig_mm{};
  /// The rig as the samples so far see it; empty: as its file says.
  std::optional<std::vector<diagnosis::RigSeen>> rig{};
  std::optional<geometry::Position>
      worst_mm{};                            // where it is largest; empty: no pose is reachable
  std::optional<double> condition{};         // empty: infinite
  std::vector<std::string> undetermined{};   // parameters that nothing has told of yet
  std::optional<double> last_times_usual{};  // as LiveEstimate::last_times_usual
  bool last_unusual = false;
};

class LiveEstimate {
 public:
  /// `points`: what is, or was, to be measured.
  LiveEstimate(const geometry::Rig& rig, std::span<const session::PlanPoint> points);

  /// Fits the rig once to samples that are there already and are added after this.
  void see_rig(std::span<const session::Sample> samples);
  /// Adds a sample; true if it told something (a sample of G1 with a position). Where there are
  /// enough new ones, the rig is fitted anew (tenths of a second) and all are measured by it.
  bool add(const session::Sample& sample);

  /// Standard deviation of the tool's position over the workspace [mm].
  [[nodiscard]] const calibration::WorkspaceUncertainty& uncertainty() const {
    return uncertainty_;
  }
  /// True if the uncertainty at the worst place is below the limit, and there are enough
  /// samples to judge their own noise.
  [[nodiscard]] bool below(double limit_mm) const;

  /// How many times the usual residual that of the newest sample is; empty as long as nothing
  /// is usual yet.
  [[nodiscard]] std::optional<double> last_times_usual() const {
    return taken_.last_times_usual;
  }
  /// True if that sample is worth another look.
  [[nodiscard]] bool last_unusual() const {
    return taken_.last_times_usual && *taken_.last_times_usual > taken_.unusual_from;
  }
  [[nodiscard]] const calibration::OnlineEstimator& filter() const { return taken_.filter; }
  [[nodiscard]] const RigSoFar& rig() const { return rig_; }
  [[nodiscard]] const WorkingArea& area() const { return area_; }
  [[nodiscard]] const std::vector<calibration::WorkspacePose>& workspace() const {
    return workspace_;
  }

  [[nodiscard]] EstimateSummary summary() const;

 private:
  /// A filter that has taken in samples, and what it said of the newest.
  struct Taken {
    calibration::OnlineEstimator filter;
    std::optional<double> last_times_usual{};
    double unusual_from = 0.0;  // by the samples before it
    bool take_in(const RigSoFar::Measured& sample);
  };
  void measure_by(RigSoFar rig);

  RigSoFar rig_;
  WorkingArea area_;
  Taken taken_;
  std::vector<calibration::WorkspacePose> workspace_;
  calibration::WorkspaceUncertainty uncertainty_;
};

}  // namespace sixdial::studies
