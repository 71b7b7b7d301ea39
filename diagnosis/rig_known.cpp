#include "diagnosis/rig_known.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "diagnosis/rig_seen.h"
#include "simulation/rig_kinds.h"

namespace sixdial::diagnosis {
namespace {

constexpr int kMostSteps = 12;
constexpr double kSettled = 0.03;  // of a kind's t from step to step

struct Kind {
  double squares = 1.0;  // the workshop's own figure
  int count = 1;
  void add(double x, double sd) {
    squares += x * x + sd * sd;
    ++count;
  }
  [[nodiscard]] double t() const { return std::sqrt(squares / count); }
};

/// One number for each claimed quantity of the readings, by what `fit` says of its kind.
std::vector<double> next_step(const Readings& readings, const JointFit& fit) {
  std::map<std::string_view, Kind> kinds;
  const auto quantities = readings.rig_quantities();
  const std::vector<RigSeen> seen = rig_as_seen(readings, fit);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k].stated) continue;
    kinds[simulation::kind_of(quantities[k])].add(
        seen[k].off / seen[k].known_sd, seen[k].sd / seen[k].known_sd);
  }
  std::vector<double> result;
  for (const auto& each : quantities) {
    if (!each.stated) result.push_back(kinds[simulation::kind_of(each)].t());
  }
  return result;
}

double largest_change(const std::vector<double>& before, const std::vector<double>& now) {
  double change = 0.0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    change = std::max(change, std::abs(std::log(now[k] / before[k])));
  }
  return change;
}

}  // namespace

RigKnown rig_known(const Readings& readings, const JointFit& fit) {
  const Eigen::MatrixXd smooth = fit.random.rightCols(fit.random.cols() - fit.known);
  const auto quantities = readings.rig_quantities();
  const auto claimed =
      std::ranges::count_if(quantities, [](const auto& each) { return !each.stated; });
  RigKnown result{std::vector<double>(static_cast<std::size_t>(claimed), 1.0), {}};
  Readings allowing = readings.allowing_rig_by(result.of_a_workshop);
  result.fit = fit_jointly(allowing, fit.model, fit.effects, &fit, smooth);
  for (int step = 0; step < kMostSteps; ++step) {
    std::vector<double> now = next_step(allowing, result.fit);
    const bool settled = largest_change(result.of_a_workshop, now) < kSettled;
    allowing = readings.allowing_rig_by(now);
    JointFit next =
        fit_jointly(allowing, result.fit.model, result.fit.effects, &result.fit, smooth);
    if (!next.converged) break;
    result = {std::move(now), std::move(next)};
    if (settled) break;
  }
  return result;
}

}  // namespace sixdial::diagnosis
