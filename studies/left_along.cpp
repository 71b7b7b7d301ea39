#include "studies/left_along.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace sixdial::studies {
namespace {

/// Sums of squares of the good readings that fall in a class.
class Sums {
 public:
  void add(const DiagnosedReadings& data, Eigen::Index row) {
    const double w0 = data.before.weight[row];
    const double w1 = data.after.weight[row];
    before_ += w0 * data.before.residual_mm[row] * data.before.residual_mm[row];
    after_ += w1 * data.left_mm[row] * data.left_mm[row];
    smooth_ += w1 * data.after.residual_mm[row] * data.after.residual_mm[row];
    weight_before_ += w0;
    weight_after_ += w1;
    ++readings_;
  }
  [[nodiscard]] int readings() const { return readings_; }
  [[nodiscard]] LeftInClass left() const {
    const auto rms = [](double squares, double weight) {
      return weight > 0.0 ? std::sqrt(squares / weight) : std::nan("");
    };
    return {
        .readings = readings_,
        .before_mm = rms(before_, weight_before_),
        .after_mm = rms(after_, weight_after_),
        .smooth_mm = rms(smooth_, weight_after_)};
  }

 private:
  double before_ = 0.0, after_ = 0.0, smooth_ = 0.0;
  double weight_before_ = 0.0, weight_after_ = 0.0;
  int readings_ = 0;
};

int sign_of(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

}  // namespace

const simulation::Trial& LeftSorter::trial_of(Eigen::Index row) const {
  const diagnosis::Row& each = data_.readings.rows()[static_cast<std::size_t>(row)];
  return data_.readings.trials()[static_cast<std::size_t>(each.trial)];
}

void LeftSorter::by_number(const Along& along, const Eigen::VectorXd& of_row) {
  constexpr std::size_t kClasses = 10;
  std::vector<Eigen::Index> order;
  for (Eigen::Index row = 0; row < of_row.size(); ++row) {
    if (std::isfinite(of_row[row])) order.push_back(row);
  }
  std::ranges::stable_sort(
      order, [&](Eigen::Index a, Eigen::Index b) { return of_row[a] < of_row[b]; });
  if (order.size() < kClasses || !(of_row[order.back()] > of_row[order.front()])) return;
  LeftAlong left{.along = along, .has_smooth = data_.has_unknown};
  for (std::size_t k = 0; k < kClasses; ++k) {
    const std::size_t begin = k * order.size() / kClasses;
    const std::size_t end = (k + 1) * order.size() / kClasses;
    Sums sums;
    double at = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      sums.add(data_, order[i]);
      at += of_row[order[i]];
    }
    LeftInClass each = sums.left();
    each.at = at / sums.readings();
    each.low = of_row[order[begin]];
    each.high = of_row[order[end - 1]];
    left.classes.push_back(std::move(each));
  }
  all_.push_back(std::move(left));
}

void LeftSorter::by_key(CurveAxis axis, const std::function<Key(Eigen::Index)>& key_of) {
  std::map<Key, Sums> classes;
  for (Eigen::Index row = 0; row < data_.readings.count(); ++row) {
    const Key key = key_of(row);
    if (!key.empty()) classes[key].add(data_, row);
  }
  if (classes.empty()) return;
  LeftAlong left{.along = {.axis = axis}, .has_smooth = data_.has_unknown};
  for (const auto& [key, sums] : classes) {
    LeftInClass each = sums.left();
    each.at = static_cast<double>(left.classes.size());
    each.signs = key.signs;
    each.dial = key.dial;
    left.classes.push_back(std::move(each));
  }
  all_.push_back(std::move(left));
}

void LeftSorter::by_arrival() {
  by_key(CurveAxis::kJointArrival, [this](Eigen::Index row) -> Key {
    const simulation::Trial& trial = trial_of(row);
    Key key;
    bool known = false;
    for (Eigen::Index joint = 0; joint < trial.q.size(); ++joint) {
      key.signs.push_back(sign_of(trial.approach_of(static_cast<std::size_t>(joint))));
      known = known || key.signs.back() != 0;
    }
    if (!known) return {};
    return key;
  });
}

void LeftSorter::by_plunger_travel() {
  by_key(CurveAxis::kPlungerTravel, [this](Eigen::Index row) -> Key {
    const diagnosis::Row& each = data_.readings.rows()[static_cast<std::size_t>(row)];
    const auto& sample = data_.readings.circumstances()[static_cast<std::size_t>(each.trial)];
    const int sign = sign_of(sample.plunger_direction[static_cast<std::size_t>(each.dial)]);
    if (sign == 0) return {};
    return {.signs = {sign}};
  });
}

void LeftSorter::by_dial() {
  by_key(CurveAxis::kDial, [this](Eigen::Index row) -> Key {
    const diagnosis::Row& each = data_.readings.rows()[static_cast<std::size_t>(row)];
    return {.dial = data_.readings.model().rig().dials[static_cast<std::size_t>(each.dial)].id};
  });
}

}  // namespace sixdial::studies
