#include "tests/blind/gain_truth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/gain.h"
#include "diagnosis/tool_shift.h"

namespace sixdial::blind {
namespace {

/// Position error of each trial by a fit to other readings of the same rig.
Eigen::VectorXd errors_of(const diagnosis::Readings& readings, const diagnosis::JointFit& fit) {
  diagnosis::JointFit here = fit;
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  here.residual_mm = readings.measured_mm() - readings.simulate(fit.model, extended);
  here.noise = readings.relative_noise();
  here.random.resize(readings.count(), 0);
  here.u.resize(0);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(readings.count());
  return diagnosis::tool_shift(readings, here, here.residual_mm, ones)
      .colwise()
      .norm()
      .transpose();
}

}  // namespace

std::optional<StatedGain> stated_gain(
    const diagnosis::Diagnosis& found, const std::vector<bool>& held_out) {
  if (found.named.findings.empty() || found.named.swap) return std::nullopt;
  std::vector<bool> fitted = held_out;
  fitted.flip();
  const diagnosis::GainQuestion question{
      *found.readings,
      {found.readings->counting(fitted), found.readings->counting(held_out)},
      std::nullopt,
      found.named.baseline,
      found.named.extended};
  diagnosis::GainSettings how;
  how.seed = found.seed;
  how.noise_mm = found.noise.sigma_mm;
  how.networks = false;
  diagnosis::GainStudy study = diagnosis::study_gain(question, how);
  const auto row = std::ranges::find(
      study.rows, diagnosis::GainModel::kExtended, &diagnosis::GainRow::model);
  if (row == study.rows.end()) return std::nullopt;
  return StatedGain{
      row->low_mm, row->high_mm, std::move(study.calibrated), std::move(study.extended)};
}

std::vector<double> differences_on(
    const StatedGain& stated, std::vector<simulation::Trial> trials,
    const std::vector<bool>& held_out, const simulation::ForwardModel& model) {
  diagnosis::Readings readings(model, std::move(trials));
  readings.place_tool(stated.extended.model);
  const Eigen::VectorXd difference =
      errors_of(readings, stated.extended) - errors_of(readings, stated.calibrated);
  std::vector<double> result;
  for (std::size_t t = 0; t < held_out.size(); ++t) {
    const double each = difference[static_cast<Eigen::Index>(t)];
    if (held_out[t] && std::isfinite(each)) result.push_back(each);
  }
  return result;
}

}  // namespace sixdial::blind
