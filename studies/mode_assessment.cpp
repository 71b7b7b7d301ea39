#include "studies/mode_assessment.h"

#include <Eigen/SVD>
#include <algorithm>
#include <map>
#include <vector>

#include "calibration/identifiability.h"
#include "geometry/tool.h"

namespace sixdial::studies {
namespace {

std::optional<double> condition_of(
    const calibration::LeastSquaresFit& fit, const std::vector<int>& rows) {
  std::vector<int> free;
  for (int i = 0; i < fit.directions.rows(); ++i) {
    if (fit.directions.row(i).norm() > 0.0) free.push_back(i);
  }
  if (free.empty() || rows.size() < free.size()) return std::nullopt;
  Eigen::MatrixXd A = fit.J(rows, free);
  for (std::size_t i = 0; i < free.size(); ++i) {
    A.col(static_cast<Eigen::Index>(i)) *= fit.scale[free[i]];
  }
  const Eigen::VectorXd values = A.jacobiSvd().singularValues();
  const double least = values[values.size() - 1];
  if (!(least * calibration::kOpenCondition > values[0])) return std::nullopt;
  return values[0] / least;
}

}  // namespace

std::vector<WorkingModeRow> working_modes_of(
    const calibration::ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  std::map<int, const simulation::Trial*> by_sample;
  for (const simulation::Trial& trial : trials) by_sample[trial.sample] = &trial;
  const geometry::Tool tool(rig);
  struct Rows {
    geometry::WorkingMode mode;
    int samples = 0;
    std::vector<int> rows;
  };
  std::vector<Rows> modes;
  for (int i = 0; i < space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto found = by_sample.find(space.sample[k]);
    if (found == by_sample.end()) continue;
    const simulation::Trial& trial = *found->second;
    const auto mode = tool.mode_of(rig.robot.nominal, trial.q, trial.assembly);
    if (!mode) continue;
    auto here = std::ranges::find(modes, *mode, &Rows::mode);
    if (here == modes.end()) here = modes.insert(modes.end(), {*mode, 0, {}});
    ++here->samples;
    for (int row = space.first_row[k]; row < space.first_row[k + 1]; ++row) {
      here->rows.push_back(row);
    }
  }
  std::vector<WorkingModeRow> rows;
  for (const Rows& each : modes) {
    rows.push_back(
        {.mode = each.mode,
         .samples = each.samples,
         .condition = condition_of(fit, each.rows)});
  }
  return rows;
}

}  // namespace sixdial::studies
