#include "diagnosis/readings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sixdial::diagnosis {

using simulation::kModelParameterCount;

Readings::Readings(
    const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
    std::vector<bool> counts)
    : model_(&model), trials_(std::move(trials)), counts_(std::move(counts)) {
  counts_.resize(trials_.size(), counts_.empty());
  for (const auto& trial : trials_) {
    has_dials_ = has_dials_ || std::any_of(
                                   trial.dial_mm.begin(), trial.dial_mm.end(),
                                   [](const auto& reading) { return reading.has_value(); });
  }
  std::vector<double> values;
  double variance = 0.0;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    first_row_.push_back(static_cast<Eigen::Index>(values.size()));
    const auto& trial = trials_[t];
    if (!counts_[t]) continue;
    if (has_dials_) {
      for (std::size_t i = 0; i < trial.dial_mm.size(); ++i) {
        if (!trial.dial_mm[i]) continue;
        rows_.push_back({static_cast<int>(t), static_cast<int>(i)});
        values.push_back(*trial.dial_mm[i]);
        const auto& dial = model.rig().dials[i];
        variance += dial.repeatability_mm * dial.repeatability_mm +
                    dial.resolution_mm * dial.resolution_mm / 12;
      }
    } else if (trial.position_mm) {
      for (int axis = 0; axis < 2; ++axis) {
        rows_.push_back({static_cast<int>(t), axis});
        values.push_back((*trial.position_mm)[axis]);
        variance += trial.position_covariance(axis, axis);
      }
    }
  }
  first_row_.push_back(static_cast<Eigen::Index>(values.size()));
  measured_mm_ = Eigen::Map<const Eigen::VectorXd>(
      values.data(), static_cast<Eigen::Index>(values.size()));
  rig_noise_mm_ =
      values.empty() ? 0.0 : std::sqrt(variance / static_cast<double>(values.size()));
  place_tool(model.nominal());
}

Readings Readings::with_swapped_dials(int dial, int other) const {
  std::vector<simulation::Trial> trials = trials_;
  for (auto& trial : trials) {
    std::swap(
        trial.dial_mm[static_cast<std::size_t>(dial)],
        trial.dial_mm[static_cast<std::size_t>(other)]);
  }
  return {*model_, std::move(trials), counts_};
}

Readings Readings::counting(std::vector<bool> counts) const {
  Readings result(*model_, trials_, std::move(counts));
  result.circumstances_ = circumstances_;
  return result;
}

void Readings::place_tool(const simulation::ModelVector& at) {
  circumstances_ = simulation::circumstances_of(*model_, at, trials_);
}

void Readings::pick(
    const simulation::Scene& scene, std::size_t trial, Eigen::VectorXd& into) const {
  for (Eigen::Index row = first_row_[trial]; row < first_row_[trial + 1]; ++row) {
    const int dial = rows_[static_cast<std::size_t>(row)].dial;
    into[row] =
        has_dials_ ? scene.reading_mm[static_cast<std::size_t>(dial)] : scene.p_WE[dial];
  }
}

Eigen::VectorXd Readings::simulate(
    const simulation::ModelVector& at, const simulation::ExtendedModel& extended,
    const simulation::ActiveEffect* extra) const {
  Eigen::VectorXd result =
      Eigen::VectorXd::Constant(count(), std::numeric_limits<double>::quiet_NaN());
  simulation::Scene scene;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    if (extended.run(at, trials_[t], circumstances_[t], scene, extra)) pick(scene, t, result);
  }
  return result;
}

Eigen::MatrixXd Readings::jacobian(const simulation::ModelVector& at) const {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(count(), kModelParameterCount);
  const bool free = model_->rig().cuboid.mount == geometry::Mount::kFree;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const auto seen = model_->predict(
        at, trials_[t].q_rad, trials_[t].assembly, free ? trials_[t].gamma_rad : std::nullopt);
    if (!seen) continue;
    for (Eigen::Index row = first_row_[t]; row < first_row_[t + 1]; ++row) {
      const int dial = rows_[static_cast<std::size_t>(row)].dial;
      if (has_dials_) {
        J.row(row) = seen->dial_J.row(dial);
      } else {
        J.row(row) = seen->position_J.row(dial);
      }
    }
  }
  return J;
}

Eigen::MatrixXd Readings::nuisance() const {
  if (model_->rig().cuboid.mount != geometry::Mount::kFree || !has_dials_) {
    return Eigen::MatrixXd(count(), 0);
  }
  constexpr double kPriorAngle_rad = 0.01;
  const double per_noise = kPriorAngle_rad / std::max(1e-6, rig_noise_mm_);
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(count(), static_cast<Eigen::Index>(trials_.size()));
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const auto seen = model_->predict(
        model_->nominal(), trials_[t].q_rad, trials_[t].assembly, trials_[t].gamma_rad);
    if (!seen) continue;
    for (Eigen::Index row = first_row_[t]; row < first_row_[t + 1]; ++row) {
      result(row, static_cast<Eigen::Index>(t)) =
          per_noise * seen->dial_J_gamma[rows_[static_cast<std::size_t>(row)].dial];
    }
  }
  return result;
}

}  // namespace sixdial::diagnosis
