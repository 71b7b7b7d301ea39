#include "studies/dial_residuals.h"

#include <algorithm>
#include <cmath>

#include "session/trials.h"
#include "simulation/forward_model.h"

namespace sixdial::studies {
namespace {

constexpr double kRobust = 1.4826;  // sd of a normal distribution over its median distance

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// By dial: reading minus simulated reading [mm].
std::vector<std::vector<double>> residuals(
    const session::Session& session, const std::vector<simulation::Trial>& trials,
    const Eigen::VectorXd& v) {
  const simulation::ForwardModel model(session.rig);
  simulation::ModelVector at = model.nominal();
  at.head(v.size()) = v;
  const auto clamp = model.find("clamp");
  const bool free = session.rig.cuboid.mount == geometry::Mount::kFree;
  std::vector<double> turned_rad;
  for (const simulation::Trial& trial : trials) {
    if (free || !trial.gamma_rad) continue;
    const auto seen = model.predict(at, trial.q, trial.assembly, std::nullopt, false);
    if (seen) turned_rad.push_back(*trial.gamma_rad - seen->gamma_rad);
  }
  if (clamp && !turned_rad.empty()) at[*clamp] = median(turned_rad);
  std::vector<std::vector<double>> out(session.rig.dials.size());
  for (const simulation::Trial& trial : trials) {
    if (!trial.gamma_rad) continue;
    const auto seen = model.predict(
        at, trial.q, trial.assembly, free ? trial.gamma_rad : std::nullopt, false);
    if (!seen) continue;
    for (std::size_t i = 0; i < out.size() && i < trial.reading.size(); ++i) {
      if (!trial.reading[i]) continue;
      const double left_mm = *trial.reading[i] - seen->reading[static_cast<Eigen::Index>(i)];
      if (std::isfinite(left_mm)) out[i].push_back(left_mm);
    }
  }
  return out;
}

}  // namespace

std::vector<DialRow> dial_residuals(
    const session::Session& session, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified) {
  if (session.rig.dials.empty()) return {};
  const std::vector<simulation::Trial> trials = session::trials_of(session, "");
  const auto before = residuals(session, trials, nominal);
  const auto after = residuals(session, trials, identified);
  std::vector<DialRow> rows;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].empty() || before[i].empty()) continue;
    DialRow row;
    row.dial = session.rig.dials[i].id;
    row.readings = static_cast<int>(after[i].size());
    row.before_median_mm = median(before[i]);
    row.median_mm = median(after[i]);
    std::vector<double> apart;
    for (const double each : after[i]) {
      apart.push_back(std::abs(each - row.median_mm));
      row.largest_mm = std::max(row.largest_mm, std::abs(each));
    }
    row.spread_mm = kRobust * median(apart);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace sixdial::studies
