// What is left of the readings, sorted along numbers and by kinds, before and after the causes.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "studies/diagnosis_curves.h"

namespace sixdial::studies {

/// Each call adds one LeftAlong to the list; by_number() nothing if its number does not vary,
/// the others even a single class. `data` must outlive it.
class LeftSorter {
 public:
  explicit LeftSorter(const DiagnosedReadings& data) : data_(data) {}

  /// Ten classes of equally many readings, by the number of each reading.
  void by_number(const Along& along, const Eigen::VectorXd& of_row);
  /// By the signs of the joints' last moves.
  void by_arrival();
  /// By the sign of the plunger's last move.
  void by_plunger_travel();
  void by_dial();
  [[nodiscard]] std::vector<LeftAlong> take() { return std::move(all_); }

 private:
  /// What a reading falls under: signs, or a name. Sorted by both.
  struct Key {
    std::vector<int> signs{};
    std::string dial{};
    friend auto operator<=>(const Key&, const Key&) = default;
    [[nodiscard]] bool empty() const { return signs.empty() && dial.empty(); }
  };
  void by_key(CurveAxis axis, const std::function<Key(Eigen::Index)>& key_of);
  [[nodiscard]] const simulation::Trial& trial_of(Eigen::Index row) const;

  const DiagnosedReadings& data_;
  std::vector<LeftAlong> all_;
};

}  // namespace sixdial::studies
