// What a session's rig and instrument bring into every fit: where unknown parts start, and what
// is known of the others to within something.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "diagnosis/readings.h"
#include "diagnosis/rig_columns.h"
#include "geometry/instrument_frame.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kFinestNoise_mm = 1e-6;

}  // namespace

/// What nobody knows of the instrument starts where the samples put it.
void Readings::set_nominal() {
  nominal_ = model_->nominal();
  const geometry::InstrumentModel& instrument = model_->instrument();
  if (of_ != Of::kChannels || !instrument.kind->start) return;
  const geometry::RobotModel& robot = model_->robot();
  const Eigen::Index of_robot = model_->robot_parameter_count();
  std::vector<std::vector<geometry::Pose<double>>> frames;
  std::vector<std::size_t> reached;
  for (std::size_t t = 0; t < trials_->size(); ++t) {
    const simulation::Trial& trial = (*trials_)[t];
    if (trial.reading.size() != channels_) continue;
    std::vector<geometry::Pose<double>> X(robot.frames.size());
    if (!robot.forward(nominal_.head(of_robot), trial.q, trial.assembly, X)) continue;
    frames.push_back(std::move(X));
    reached.push_back(t);
  }
  std::vector<geometry::SeenSample> seen;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    seen.push_back({frames[i], (*trials_)[reached[i]].reading});
  }
  if (seen.empty()) return;
  Eigen::VectorXd x = instrument.nominal;
  instrument.kind->start(instrument, seen, x);
  nominal_.tail(x.size()) = x;
}

const Eigen::MatrixXd& Readings::nuisance() const {
  const std::lock_guard lock(kept_->making);
  std::optional<Eigen::MatrixXd>& kept = kept_->nuisance;
  if (kept) return *kept;
  const Eigen::MatrixXd of_rig = rig_columns(*this, placed_at_, rig_quantities());
  const Eigen::MatrixXd angles =
      model_->rig().on_cuboid() ? angles_of_free_mount() : known_parts_of_instrument();
  kept.emplace(count(), of_rig.cols() + angles.cols());
  kept->leftCols(of_rig.cols()) = of_rig / std::max(kFinestNoise_mm, rig_noise_mm_);
  kept->rightCols(angles.cols()) = angles;
  return *kept;
}

simulation::ModelVector Readings::as_known(const simulation::ModelVector& at) const {
  if (known_.empty()) return at;
  simulation::ModelVector result = at;
  const Eigen::Index count = model_->instrument().parameter_count();
  const Eigen::Index first = model_->robot_parameter_count();
  result.segment(first, count) = geometry::at_known_values(known_, at.segment(first, count));
  return result;
}

/// Touches all read the same: the only lengths among them are those of known places and
/// distances.
bool Readings::tells_a_length() const {
  return !known_.empty() || (measured_mm_.array() != measured_mm_[0]).any();
}

std::vector<Eigen::Index> Readings::what_it_keeps() const {
  if (of_ != Of::kChannels || measured_mm_.size() == 0) return {};
  if (geometry::knows_the_frame(model_->rig())) return {};
  const auto& parameters = model_->robot().parameters;
  std::vector<Eigen::Index> result;
  std::optional<Eigen::Index> longest;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (parameters[i].stands) result.push_back(k);
    if (parameters[i].unit != "mm" || parameters[i].stands) continue;
    if (!longest || std::abs(nominal_[k]) > std::abs(nominal_[*longest])) longest = k;
  }
  if (longest && !tells_a_length()) result.push_back(*longest);
  return result;
}

void Readings::leave_what_is_known(
    const simulation::ModelVector& at, Eigen::MatrixXd& J) const {
  for (const Eigen::Index each : keeps_) J.col(each).setZero();
  if (known_.empty()) return;
  const Eigen::Index count = model_->instrument().parameter_count();
  const Eigen::Index first = model_->robot_parameter_count();
  const Eigen::MatrixXd slopes = geometry::slopes_of(known_, at.segment(first, count));
  const Eigen::MatrixXd back = slopes.completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::MatrixXd of_instrument = J.middleCols(first, count);
  J.middleCols(first, count) = of_instrument - (of_instrument * back) * slopes;
}

/// One column for each thing that is known: what its standard deviation does to the readings.
Eigen::MatrixXd Readings::known_parts_of_instrument() const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(count(), std::ssize(known_));
  if (known_.empty() || of_ != Of::kChannels) return result;
  const Eigen::Index parameters = model_->instrument().parameter_count();
  const Eigen::Index first = model_->robot_parameter_count();
  const simulation::ModelVector at = as_known(placed_at_);
  Eigen::MatrixXd moves = geometry::slopes_of(known_, at.segment(first, parameters))
                              .completeOrthogonalDecomposition()
                              .pseudoInverse();
  for (std::size_t k = 0; k < known_.size(); ++k) {
    moves.col(static_cast<Eigen::Index>(k)) *=
        known_[k].sd / std::max(kFinestNoise_mm, rig_noise_mm_);
  }
  simulation::ExtendedSlopes slopes({*model_, {}}, {});
  simulation::ExtendedSlopes::Slopes seen;
  simulation::Scene scene;
  for (std::size_t t = 0; t < trials_->size(); ++t) {
    if (!has_rows(t)) continue;
    if (!slopes.at(at, (*trials_)[t], (*circumstances_)[t], scene, seen)) continue;
    for (Eigen::Index row = first_row_[t]; row < first_row_[t + 1]; ++row) {
      const int channel = rows_[static_cast<std::size_t>(row)].dial;
      const Eigen::RowVectorXd by_x = seen.reading.row(channel).segment(first, parameters);
      result.row(row) = per_unit_[static_cast<std::size_t>(channel)] * by_x * moves;
    }
  }
  return result;
}

Eigen::MatrixXd Readings::angles_of_free_mount() const {
  if (model_->rig().cuboid.mount != geometry::Mount::kFree || of_ != Of::kDials) {
    return Eigen::MatrixXd(count(), 0);
  }
  constexpr double kPriorAngle_rad = 0.01;
  const double per_noise = kPriorAngle_rad / std::max(kFinestNoise_mm, rig_noise_mm_);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(count(), places_);
  for (std::size_t t = 0; t < trials_->size(); ++t) {
    if (!has_rows(t)) continue;
    const auto seen = model_->predict(
        model_->nominal(), (*trials_)[t].q, (*trials_)[t].assembly, (*trials_)[t].gamma_rad,
        false);
    if (!seen) continue;
    for (Eigen::Index row = first_row_[t]; row < first_row_[t + 1]; ++row) {
      result(row, (*place_of_trial_)[t]) =
          per_noise * seen->reading_J_gamma[rows_[static_cast<std::size_t>(row)].dial];
    }
  }
  return result;
}

}  // namespace sixdial::diagnosis
