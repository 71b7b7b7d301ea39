#include "diagnosis/readings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/crew.h"
#include "geometry/lever.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

/// Trials: in long sessions it is looked at every so many whether the work is to end, and each
/// thread takes so many.
constexpr std::size_t kStretch = 256;

}  // namespace

Readings::Readings(
    const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
    std::vector<bool> counts)
    : model_(&model),
      trials_(std::make_shared<const std::vector<simulation::Trial>>(std::move(trials))),
      counts_(std::move(counts)) {
  counts_.resize(trials_->size(), counts_.empty());
  std::vector<Eigen::Index> places;
  for (const bool each : counts_) places.push_back(each ? places_++ : -1);
  place_of_trial_ = std::make_shared<const std::vector<Eigen::Index>>(std::move(places));
  const bool has_readings = std::ranges::any_of(*trials_, [](const simulation::Trial& trial) {
    return std::ranges::any_of(
        trial.reading, [](const auto& reading) { return reading.has_value(); });
  });
  if (has_readings) of_ = model.rig().on_cuboid() ? Of::kDials : Of::kChannels;
  axes_ = model.rig().on_cuboid() ? 2 : model.robot().axes;
  if (of_ != Of::kPositions) channels_ = model.instrument().channels.size();
  for (const geometry::ChannelInfo& channel : model.instrument().channels) {
    per_unit_.push_back(channel.unit == "rad" ? geometry::lever_mm(model.instrument()) : 1.0);
  }
  if (!model.rig().on_cuboid()) known_ = geometry::known_parts(model.instrument());
  choose_rows();
  set_nominal();
  keeps_ = what_it_keeps();
  place_tool(nominal_);
  for (std::size_t d = 0; of_ != Of::kPositions && d < channels_; ++d) {
    noise_of_dial_.push_back(rig_noise_of(d));
  }
  set_noise();
}

std::string Readings::channel_name(std::size_t channel) const {
  static constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  if (of_ == Of::kPositions) return kAxes.at(channel);
  return model_->instrument().channels.at(channel).name;
}

void Readings::add_channels(std::size_t trial, std::vector<double>& values, double& variance) {
  const auto& reading = (*trials_)[trial].reading;
  for (std::size_t i = 0; i < reading.size() && i < channels_; ++i) {
    if (!reading[i]) continue;
    rows_.push_back({static_cast<int>(trial), static_cast<int>(i)});
    values.push_back(*reading[i] * per_unit_[i]);
    variance += rig_noise_of(i) * rig_noise_of(i);
  }
}

void Readings::add_position(std::size_t trial, std::vector<double>& values, double& variance) {
  const simulation::Trial& each = (*trials_)[trial];
  if (!each.position_mm) return;
  const Eigen::MatrixXd covariance = each.covariance_or_zero();
  channels_ = static_cast<std::size_t>(each.position_mm->size());
  axes_ = each.position_mm->size();
  for (int axis = 0; axis < static_cast<int>(channels_); ++axis) {
    rows_.push_back({static_cast<int>(trial), axis});
    values.push_back((*each.position_mm)[axis]);
    row_sd_mm_.push_back(std::sqrt(covariance(axis, axis)));
    variance += covariance(axis, axis);
  }
}

void Readings::choose_rows() {
  rows_.clear();
  first_row_.clear();
  row_sd_mm_.clear();
  std::vector<double> values;
  double variance = 0.0;
  for (std::size_t t = 0; t < trials_->size(); ++t) {
    first_row_.push_back(static_cast<Eigen::Index>(values.size()));
    if (!counts_[t]) continue;
    if (of_ == Of::kPositions) {
      add_position(t, values, variance);
    } else {
      add_channels(t, values, variance);
    }
  }
  first_row_.push_back(static_cast<Eigen::Index>(values.size()));
  measured_mm_ = Eigen::Map<const Eigen::VectorXd>(
      values.data(), static_cast<Eigen::Index>(values.size()));
  rig_noise_mm_ =
      values.empty() ? 0.0 : std::sqrt(variance / static_cast<double>(values.size()));
  used_.clear();
  place_of_row_.clear();
  for (const Row& row : rows_) {
    if (used_.empty() || used_.back() != row.trial) used_.push_back(row.trial);
    place_of_row_.push_back(std::ssize(used_) - 1);
  }
  rows_of_dial_.assign(of_ == Of::kPositions ? 0 : channels_, {});
  for (std::size_t row = 0; of_ != Of::kPositions && row < rows_.size(); ++row) {
    rows_of_dial_[static_cast<std::size_t>(rows_[row].dial)].push_back(
        static_cast<Eigen::Index>(row));
  }
}

double Readings::sd_of_channel(std::size_t channel) const {
  const geometry::ChannelInfo& info = model_->instrument().channels[channel];
  return info.sd * per_unit_[channel];
}

double Readings::rig_noise_of(std::size_t dial) const {
  if (of_ != Of::kDials) return sd_of_channel(dial);
  const auto& instrument = model_->rig().dials[dial];
  return std::hypot(instrument.repeatability_mm, instrument.resolution_mm / std::sqrt(12.0));
}

void Readings::set_noise() {
  relative_noise_ = Eigen::VectorXd::Ones(count());
  std::vector<double> ordered = of_ == Of::kPositions ? row_sd_mm_ : noise_of_dial_;
  if (ordered.empty()) return;
  std::ranges::sort(ordered);
  const double middle = ordered[ordered.size() / 2];
  if (!(middle > 0)) return;
  constexpr double kLeast = 0.05;  // a dial without noise would outvote all others
  for (Eigen::Index row = 0; row < count(); ++row) {
    const auto at = static_cast<std::size_t>(row);
    const double own = of_ == Of::kPositions
                           ? row_sd_mm_[at]
                           : noise_of_dial_[static_cast<std::size_t>(rows_[at].dial)];
    relative_noise_[row] = std::max(kLeast, own / middle);
  }
}

Readings Readings::with_noise(std::vector<double> of_dials) const {
  Readings result = *this;
  result.noise_of_dial_ = std::move(of_dials);
  result.set_noise();
  return result;
}

Readings Readings::allowing_rig(std::optional<double> of_a_workshop) const {
  Readings result = *this;
  result.rig_allowance_.reset();
  result.kept_ = std::make_shared<Kept>();
  if (!of_a_workshop) return result;
  const std::size_t claimed = simulation::claimed_quantities(model_->rig()).size();
  return result.allowing_rig_by(std::vector<double>(claimed, *of_a_workshop));
}

Readings Readings::allowing_rig_by(std::vector<double> of_a_workshop) const {
  Readings result = *this;
  result.rig_allowance_ = std::move(of_a_workshop);
  result.kept_ = std::make_shared<Kept>();
  return result;
}

std::vector<simulation::RigQuantity> Readings::rig_quantities() const {
  if (of_ != Of::kDials) return {};
  auto result = simulation::stated_quantities(model_->rig());
  if (!rig_allowance_) return result;
  std::size_t k = 0;
  for (simulation::RigQuantity& each : simulation::claimed_quantities(model_->rig())) {
    each.times = rig_allowance_->at(k++);
    each.sd *= each.times;
    if (each.sd > 0.0) result.push_back(std::move(each));
  }
  return result;
}

Readings Readings::with_swapped_dials(int dial, int other) const {
  std::vector<simulation::Trial> trials = *trials_;
  for (auto& trial : trials) {
    std::swap(
        trial.reading[static_cast<std::size_t>(dial)],
        trial.reading[static_cast<std::size_t>(other)]);
  }
  // A dial's noise goes with its cable: its numbers come under the other's name.
  Readings result{*model_, std::move(trials), counts_};
  result.rig_allowance_ = rig_allowance_;
  if (!noise_of_dial_.empty()) {
    std::vector<double> noise = noise_of_dial_;
    std::swap(noise[static_cast<std::size_t>(dial)], noise[static_cast<std::size_t>(other)]);
    return result.with_noise(std::move(noise));
  }
  return result;
}

Readings Readings::with_joints_bent(
    const std::vector<simulation::ActiveEffect>& effects) const {
  std::vector<simulation::Trial> trials = *trials_;
  simulation::Scene scene;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    scene.q = trials[t].q;
    for (const simulation::ActiveEffect& each : effects) {
      each.effect->before_kinematics(each.x, each.place, (*circumstances_)[t], scene);
    }
    trials[t].q = scene.q;
  }
  Readings result(*model_, std::move(trials), counts_);
  result.place_tool(placed_at_);
  return result;
}

Readings Readings::without_dial(std::size_t dial) const {
  std::vector<simulation::Trial> trials = *trials_;
  for (auto& trial : trials) trial.reading[dial].reset();
  const Readings others(*model_, std::move(trials), counts_);
  Readings result = others.with_noise(noise_of_dial_);
  result.rig_allowance_ = rig_allowance_;
  return result;
}

Readings Readings::counting(std::vector<bool> counts) const {
  Readings result = *this;
  for (std::size_t t = 0; t < counts_.size(); ++t) {
    result.counts_[t] = t < counts.size() && counts[t] && counts_[t];
  }
  result.choose_rows();
  result.set_noise();
  result.kept_ = std::make_shared<Kept>();
  result.shareable_.clear();
  for (const auto& each : shareable_) result.shareable_.push_back(rows_of(*each, result));
  return result;
}

/// The part of the columns that another choice of trials needs.
std::shared_ptr<const ScatterColumns> Readings::rows_of(
    const ScatterColumns& all, const Readings& chosen) const {
  ScatterColumns result{all.of, all.of_stops, {}, {}};
  result.columns.setZero(chosen.count(), all.columns.cols());
  std::size_t block = 0;
  for (std::size_t t = 0; t < trials_->size(); ++t) {
    const Eigen::Index rows = first_row_[t + 1] - first_row_[t];
    const Eigen::Index here = chosen.first_row_[t];
    if (rows == 0 || chosen.first_row_[t + 1] - here != rows) continue;
    bool begins = result.first_row.empty();
    while (block + 1 < all.first_row.size() && all.first_row[block + 1] <= first_row_[t]) {
      ++block;
      begins = true;
    }
    if (begins) result.first_row.push_back(here);
    result.columns.middleRows(here, rows) = all.columns.middleRows(first_row_[t], rows);
  }
  result.first_row.push_back(chosen.count());
  return std::make_shared<const ScatterColumns>(std::move(result));
}

std::shared_ptr<const ScatterColumns> Readings::shareable_like(
    const ScatterColumns* other) const {
  for (const auto& each : shareable_) {
    if (other && each->of == other->of && each->of_stops == other->of_stops &&
        each->columns.cols() == other->columns.cols()) {
      return each;
    }
  }
  return nullptr;
}

void Readings::place_tool(const simulation::ModelVector& at) {
  auto circumstances = std::make_shared<const std::vector<simulation::Circumstance>>(
      simulation::circumstances_of(*model_, at, *trials_));
  std::vector<simulation::Doubt> doubts = simulation::doubts_of(*circumstances);
  std::erase_if(doubts, [&](const simulation::Doubt& each) { return !has_rows(each.trial); });
  circumstances_ = std::move(circumstances);
  doubts_ = std::make_shared<const std::vector<simulation::Doubt>>(std::move(doubts));
  kept_ = std::make_shared<Kept>();
  placed_at_ = at;
}

void Readings::pick(
    const simulation::Scene& scene, std::size_t trial, Eigen::VectorXd& into) const {
  for (Eigen::Index row = first_row_[trial]; row < first_row_[trial + 1]; ++row) {
    const int channel = rows_[static_cast<std::size_t>(row)].dial;
    const auto k = static_cast<std::size_t>(channel);
    into[row] = of_ == Of::kPositions ? scene.p_WE[channel] : scene.reading[k] * per_unit_[k];
  }
}

void Readings::for_stretches(const std::function<void(std::size_t, std::size_t)>& run) const {
  const std::size_t trials = trials_->size();
  calibration::in_parallel(static_cast<int>((trials + kStretch - 1) / kStretch), [&](int k) {
    geometry::check_end();
    const std::size_t first = static_cast<std::size_t>(k) * kStretch;
    run(first, std::min(first + kStretch, trials));
  });
}

Eigen::VectorXd Readings::simulate(
    const simulation::ModelVector& at, const simulation::ExtendedModel& extended,
    const simulation::ActiveEffect* extra) const {
  Eigen::VectorXd result =
      Eigen::VectorXd::Constant(count(), std::numeric_limits<double>::quiet_NaN());
  const simulation::ModelVector known = as_known(at);
  for_stretches([&](std::size_t first, std::size_t last) {
    simulation::Scene scene;
    for (std::size_t t = first; t < last; ++t) {
      if (!has_rows(t)) continue;
      if (extended.run(known, (*trials_)[t], (*circumstances_)[t], scene, extra))
        pick(scene, t, result);
    }
  });
  return result;
}

Eigen::MatrixXd Readings::jacobian(const simulation::ModelVector& at) const {
  if (!model_->rig().on_cuboid()) return jacobian(at, {*model_, {}}, {});
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(count(), model_->parameter_count());
  const bool free = model_->rig().cuboid.mount == geometry::Mount::kFree;
  for_stretches([&](std::size_t first, std::size_t last) {
    simulation::Prediction seen;
    for (std::size_t t = first; t < last; ++t) {
      if (!has_rows(t)) continue;
      const auto reached = model_->predict(
          at, (*trials_)[t].q, (*trials_)[t].assembly,
          free ? (*trials_)[t].gamma_rad : std::nullopt, false, seen);
      if (!reached) continue;
      for (Eigen::Index row = first_row_[t]; row < first_row_[t + 1]; ++row) {
        const int dial = rows_[static_cast<std::size_t>(row)].dial;
        if (of_ == Of::kDials) {
          J.row(row) = seen.reading_J.row(dial);
        } else {
          J.row(row) = seen.position_J.row(dial);
        }
      }
    }
  });
  return J;
}

Eigen::MatrixXd Readings::jacobian(
    const simulation::ModelVector& at, const simulation::ExtendedModel& extended,
    const std::vector<simulation::EffectNumber>& numbers) const {
  if (extended.effects().empty() && model_->rig().on_cuboid()) return jacobian(at);
  Eigen::MatrixXd J =
      Eigen::MatrixXd::Zero(count(), simulation::ExtendedSlopes(extended, numbers).count());
  const simulation::ModelVector known = as_known(at);
  for_stretches([&](std::size_t first, std::size_t last) {
    simulation::ExtendedSlopes slopes(extended, numbers);
    simulation::ExtendedSlopes::Slopes seen;
    simulation::Scene scene;
    for (std::size_t t = first; t < last; ++t) {
      if (!has_rows(t)) continue;
      if (!slopes.at(known, (*trials_)[t], (*circumstances_)[t], scene, seen)) continue;
      for (Eigen::Index row = first_row_[t]; row < first_row_[t + 1]; ++row) {
        const int channel = rows_[static_cast<std::size_t>(row)].dial;
        if (of_ == Of::kPositions) {
          J.row(row) = seen.tool.row(channel);
        } else {
          J.row(row) = seen.reading.row(channel) * per_unit_[static_cast<std::size_t>(channel)];
        }
      }
    }
  });
  leave_what_is_known(known, J);
  return J.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

Eigen::VectorXd Readings::doubt_mm(
    const simulation::ModelVector& at, const simulation::ExtendedModel& extended) const {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(count());
  if (extended.effects().empty()) return squares;
  simulation::Scene scene;
  const simulation::ModelVector known = as_known(at);
  Eigen::VectorXd as_taken(count());
  Eigen::VectorXd otherwise(count());
  std::size_t last = trials_->size();
  for (const simulation::Doubt& doubt : *doubts_) {
    const std::size_t t = doubt.trial;
    if (t % kStretch == 0) geometry::check_end();
    const Eigen::Index first = first_row_[t];
    const Eigen::Index rows = first_row_[t + 1] - first;
    if (rows == 0) continue;
    if (t != last) {
      if (!extended.run(known, (*trials_)[t], (*circumstances_)[t], scene)) continue;
      pick(scene, t, as_taken);
      last = t;
    }
    if (!extended.run(known, (*trials_)[t], doubt.otherwise, scene)) continue;
    pick(scene, t, otherwise);
    squares.segment(first, rows) += (otherwise - as_taken).segment(first, rows).cwiseAbs2();
  }
  return squares.cwiseSqrt();
}

const Eigen::MatrixXd& Readings::reading_columns(
    const simulation::ActiveEffect& candidate, int count) const {
  const auto dial = static_cast<std::size_t>(candidate.place.dial);
  const std::string key = fmt::format(
      "{}@{}:{}", candidate.effect->cause, candidate.place.name,
      candidate.effect->searched ? candidate.x.back() : 0.0);
  const std::lock_guard lock(kept_->making);
  auto& kept = kept_->reading_columns;
  if (const auto known = kept.find(key); known != kept.end()) return known->second;
  const auto& rows = rows_of_dial_[dial];
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), count);
  simulation::Scene scene;
  scene.reading.assign(model_->rig().dials.size(), 0.0);
  for (int i = 0; i < count; ++i) {
    geometry::check_end();
    const auto k = static_cast<std::size_t>(i);
    simulation::ActiveEffect moved = candidate;
    const double step = 1e-3 * candidate.effect->parameters[k].sigma;
    moved.x[k] += step;
    for (std::size_t at = 0; at < rows.size(); ++at) {
      const Row& row = rows_[static_cast<std::size_t>(rows[at])];
      const double before = measured_mm_[rows[at]];
      scene.reading[dial] = before;
      candidate.effect->after_reading(
          moved.x, moved.place, (*circumstances_)[static_cast<std::size_t>(row.trial)], scene);
      columns(static_cast<Eigen::Index>(at), i) = (scene.reading[dial] - before) / step;
    }
  }
  return kept.emplace(key, std::move(columns)).first->second;
}

}  // namespace sixdial::diagnosis
