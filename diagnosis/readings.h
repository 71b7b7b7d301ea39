// A session's measured numbers as one vector, and the simulation's answer to each: every dial
// in contact of every sample; every channel of another instrument; or the coordinates of the
// tool where the session has positions only. An angle counts as the length that it moves at
// the end of a lever, which is such that both are known equally well.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/sample_scatter.h"
#include "geometry/known_parts.h"
#include "simulation/extended_model.h"
#include "simulation/extended_slopes.h"
#include "simulation/forward_model.h"
#include "simulation/rig_quantities.h"
#include "simulation/trial.h"

namespace sixdial::diagnosis {

/// One measured number.
struct Row {
  int trial = 0;  // index into the trials
  int dial = 0;   // the channel: index into rig.dials or into the instrument's channels; of
                  // positions the axis
};

class Readings {
 public:
  /// `trials` are in time order; the model must outlive this object. Dial readings are used if
  /// any trial has one, else positions. `counts` says which trials are fitted (empty: all); the
  /// others are still needed as the past of those after them.
  Readings(
      const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
      std::vector<bool> counts = {});
  /// The same session, only some of the trials fitted that are fitted here.
  [[nodiscard]] Readings counting(std::vector<bool> counts) const;

  /// The same session as if one dial had never touched.
  [[nodiscard]] Readings without_dial(std::size_t dial) const;

  /// The same session with joint values set right by these effects of single joints.
  [[nodiscard]] Readings with_joints_bent(
      const std::vector<simulation::ActiveEffect>& effects) const;

  /// The same session with two dials' readings exchanged.
  [[nodiscard]] Readings with_swapped_dials(int dial, int other) const;

  /// What was measured.
  enum class Of { kDials, kChannels, kPositions };
  [[nodiscard]] Of of() const { return of_; }
  [[nodiscard]] bool has_dials() const { return of_ == Of::kDials; }
  /// In how many coordinates the tool moves and is measured: 2 or 3.
  [[nodiscard]] Eigen::Index axes() const { return axes_; }
  /// "C", "x", "distance_K1".
  [[nodiscard]] std::string channel_name(std::size_t channel) const;
  /// The nominal model, what is not known of the instrument put where the samples say.
  [[nodiscard]] const simulation::ModelVector& nominal() const { return nominal_; }
  /// Number of channels: dials, or the axes of a position. Row::dial is below it.
  [[nodiscard]] std::size_t channel_count() const { return channels_; }
  [[nodiscard]] Eigen::Index count() const { return measured_mm_.size(); }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  [[nodiscard]] const Eigen::VectorXd& measured_mm() const { return measured_mm_; }
  [[nodiscard]] const std::vector<simulation::Trial>& trials() const { return *trials_; }
  /// A column of the trials, only of those that have rows; and of each row its place there.
  [[nodiscard]] Eigen::VectorXd of_used(const Eigen::VectorXd& by_trial) const {
    return by_trial(used_);
  }
  [[nodiscard]] Eigen::Index place_of(Eigen::Index row) const {
    return place_of_row_[static_cast<std::size_t>(row)];
  }
  [[nodiscard]] bool has_rows(std::size_t trial) const {
    return first_row_[trial] != first_row_[trial + 1];
  }
  [[nodiscard]] const simulation::ForwardModel& model() const { return *model_; }
  [[nodiscard]] const std::vector<simulation::Circumstance>& circumstances() const {
    return *circumstances_;
  }
  /// Standard deviation of one number at rest by the rig file, with its rounding [mm].
  [[nodiscard]] double rig_noise_mm() const { return rig_noise_mm_; }
  /// What a dial's rounding and repeatability come to by the rig file [mm].
  [[nodiscard]] double rig_noise_of(std::size_t dial) const;
  /// Standard deviation of each number over the common one, by the rig file's figures of the
  /// dials until something else is said; of the middle dial it is 1.
  [[nodiscard]] const Eigen::VectorXd& relative_noise() const { return relative_noise_; }
  /// Standard deviation of each dial's readings [mm] that relative_noise comes from.
  [[nodiscard]] const std::vector<double>& noise_of_dial() const { return noise_of_dial_; }
  /// The same session, dial d's noise so many times the common one.
  [[nodiscard]] Readings with_noise(std::vector<double> of_dials) const;
  /// The same session, on a rig whose file claims more than holds: each quantity without a
  /// stated deviation is known to `of_a_workshop` times what a workshop knows of it
  /// (simulation/rig_quantities.h). 0: it is taken as exact. Empty: not decided yet.
  [[nodiscard]] Readings allowing_rig(std::optional<double> of_a_workshop) const;
  /// The same, one number for each of simulation::claimed_quantities, in their order.
  [[nodiscard]] Readings allowing_rig_by(std::vector<double> of_a_workshop) const;
  [[nodiscard]] bool has_rig_allowance() const { return rig_allowance_.has_value(); }
  /// The quantities behind the first columns of nuisance(), with their standard deviations.
  [[nodiscard]] std::vector<simulation::RigQuantity> rig_quantities() const;
  /// Directions of travel and of plungers depend on where the tool was: set it again after a
  /// fit.
  void place_tool(const simulation::ModelVector& at);
  /// What readings of an arrival may share (shareable.h); empty: they are independent.
  void share(std::vector<std::shared_ptr<const ScatterColumns>> columns) {
    shareable_ = std::move(columns);
  }
  [[nodiscard]] const std::vector<std::shared_ptr<const ScatterColumns>>& shareable() const {
    return shareable_;
  }
  /// The one of the same kind as another session's; null if there is none.
  [[nodiscard]] std::shared_ptr<const ScatterColumns> shareable_like(
      const ScatterColumns* other) const;
  /// Rows of trial t: [first_row(t), first_row(t + 1)).
  [[nodiscard]] Eigen::Index first_row(std::size_t trial) const { return first_row_[trial]; }

  /// Simulated values [mm]; NaN where the pose does not exist.
  [[nodiscard]] Eigen::VectorXd simulate(
      const simulation::ModelVector& at, const simulation::ExtendedModel& extended,
      const simulation::ActiveEffect* extra = nullptr) const;
  /// d(simulated)/d(model), count x parameters, of the plain model.
  [[nodiscard]] Eigen::MatrixXd jacobian(const simulation::ModelVector& at) const;
  /// d(simulated)/d(model, numbers of the effects), with all that the effects make of the
  /// model.
  [[nodiscard]] Eigen::MatrixXd jacobian(
      const simulation::ModelVector& at, const simulation::ExtendedModel& extended,
      const std::vector<simulation::EffectNumber>& numbers) const;
  /// Standard deviation of each simulated value for what nobody knows of its sample (the side
  /// that a joint came from, a temperature that was not recorded) [mm]; mostly 0.
  [[nodiscard]] Eigen::VectorXd doubt_mm(
      const simulation::ModelVector& at, const simulation::ExtendedModel& extended) const;
  /// Random columns that every fit has, each scaled so that rig_noise_mm() is the standard
  /// deviation of its number: what the rig file says of the rig's own geometry to within a
  /// standard deviation (rig_quantities(), in that order); with a free mount, the
  /// angle of each sample around the one that its active three gave, known to 10 mrad; of
  /// another instrument its parameters, and distances of its places, that are known to within
  /// something (geometry/known_parts.h).
  [[nodiscard]] const Eigen::MatrixXd& nuisance() const;
  /// Rows of one dial.
  [[nodiscard]] const std::vector<Eigen::Index>& rows_of_dial(std::size_t dial) const {
    return rows_of_dial_[dial];
  }
  /// d(reading)/d(first `count` parameters) of an effect that changes one dial's reading only,
  /// at the measured readings, on rows_of_dial: the same for every fit, so kept.
  [[nodiscard]] const Eigen::MatrixXd& reading_columns(
      const simulation::ActiveEffect& candidate, int count) const;
  /// Takes this session's numbers out of a scene.
  void pick(const simulation::Scene& scene, std::size_t trial, Eigen::VectorXd& into) const;

 private:
  /// Calls run(first, last) for stretches of trials, by the threads of this work's crew.
  void for_stretches(const std::function<void(std::size_t, std::size_t)>& run) const;
  /// The rows of the trials that count.
  void choose_rows();
  void set_noise();
  [[nodiscard]] std::shared_ptr<const ScatterColumns> rows_of(
      const ScatterColumns& all, const Readings& chosen) const;

  const simulation::ForwardModel* model_;
  // Shared by copies: of a long session they are larger than all else.
  std::shared_ptr<const std::vector<simulation::Trial>> trials_;
  std::shared_ptr<const std::vector<simulation::Circumstance>> circumstances_;
  std::shared_ptr<const std::vector<simulation::Doubt>> doubts_;  // of trials that count
  std::vector<bool> counts_;
  // Of each trial that counted when this was made: its place among them.
  std::shared_ptr<const std::vector<Eigen::Index>> place_of_trial_;
  Eigen::Index places_ = 0;
  std::vector<Row> rows_;
  std::vector<Eigen::Index> used_;          // trials that have rows
  std::vector<Eigen::Index> place_of_row_;  // of its trial among them
  std::vector<Eigen::Index> first_row_;
  std::vector<std::vector<Eigen::Index>> rows_of_dial_;
  /// Made when first asked for, by whichever thread; shared by copies that would make the same.
  struct Kept {
    std::mutex making;
    std::optional<Eigen::MatrixXd> nuisance;
    std::map<std::string, Eigen::MatrixXd> reading_columns;
  };
  std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();
  [[nodiscard]] Eigen::MatrixXd angles_of_free_mount() const;
  /// The model with what is known of the instrument as it is known: how far from that it is, is
  /// nuisance().
  [[nodiscard]] simulation::ModelVector as_known(const simulation::ModelVector& at) const;
  /// Takes out of a Jacobian the directions in which something is known.
  void leave_what_is_known(const simulation::ModelVector& at, Eigen::MatrixXd& J) const;
  [[nodiscard]] Eigen::MatrixXd known_parts_of_instrument() const;

  simulation::ModelVector placed_at_;
  Eigen::VectorXd measured_mm_;
  std::vector<double> noise_of_dial_;
  Eigen::VectorXd relative_noise_;
  void set_nominal();
  void add_channels(std::size_t trial, std::vector<double>& values, double& variance);
  void add_position(std::size_t trial, std::vector<double>& values, double& variance);
  [[nodiscard]] double sd_of_channel(std::size_t channel) const;  // [mm]

  std::vector<geometry::KnownPart> known_;  // of another instrument than dials
  /// Indices of the robot's parameters that keep their values. Where nothing tells the frame,
  /// those of where it stands: else robot and places would turn together, for ever a little
  /// further, as the gross parts of residuals then lie along other axes. Where nothing tells a
  /// length either, the longest one: else robot, places and residuals would shrink together.
  std::vector<Eigen::Index> keeps_;
  [[nodiscard]] std::vector<Eigen::Index> what_it_keeps() const;
  [[nodiscard]] bool tells_a_length() const;
  Of of_ = Of::kPositions;
  Eigen::Index axes_ = 2;
  std::size_t channels_ = 0;
  std::vector<double> per_unit_;   // of each channel: mm of the residual for one of its unit
  std::vector<double> row_sd_mm_;  // of positions, as the instrument says
  simulation::ModelVector nominal_;
  double rig_noise_mm_ = 0.0;
  std::optional<std::vector<double>> rig_allowance_;  // of each claimed quantity
  std::vector<std::shared_ptr<const ScatterColumns>> shareable_;
};

}  // namespace sixdial::diagnosis
