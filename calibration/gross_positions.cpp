// Positions that stand out: an instrument that gives nothing else, or balls in sockets, whose
// places are fitted along.
#include <algorithm>
#include <memory>
#include <optional>

#include "calibration/gross_error_parts.h"
#include "calibration/reading_space.h"

namespace sixdial::calibration {
namespace {

using Eigen::VectorXd;
using simulation::Trial;

constexpr int kHidden = 3;  // bad positions that could hide each other and are not seen yet

/// The sample of `trials` that stands out most, and by how much.
struct Suspect {
  int sample = 0;
  PositionJudge::Verdict verdict;
};

std::optional<Suspect> most_suspect(
    const ObservationSpace& space, const std::vector<PositionJudge::Verdict>& verdicts) {
  const auto worst = std::ranges::min_element(verdicts, {}, &PositionJudge::Verdict::chance);
  if (worst == verdicts.end()) return std::nullopt;
  const auto at = static_cast<std::size_t>(worst - verdicts.begin());
  return Suspect{space.sample[at], *worst};
}

LeastSquaresFit plain_fit(
    const ObservationSpace& space, const IdentifySettings& settings, const VectorXd& start) {
  return solve_least_squares(
      space.problem(Weighting::kByCovariance), start, core_settings(space, settings));
}

void without(std::vector<Trial>& trials, const std::vector<int>& samples) {
  std::erase_if(trials, [&](const Trial& trial) {
    return std::ranges::find(samples, trial.sample) != samples.end();
  });
}

}  // namespace

void list(
    const ObservationSpace& space, const std::vector<PositionJudge::Verdict>& verdicts,
    double chance, GrossErrorCheck& result) {
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    if (verdicts[i].chance >= chance) continue;
    result.found.push_back({space.sample[i], -1, verdicts[i].size_mm, verdicts[i].times_sigma});
  }
}

/// Sequential removal (Rosner 1983): the worst goes out and the rest is fitted again, on beyond
/// the first that could be chance, as bad ones can hide each other. All up to the last that
/// cannot be chance are bad; in the end each is judged once more by the good ones.
GrossErrorCheck check_positions(
    std::span<const Trial> trials, const geometry::Rig& rig, const IdentifySettings& settings) {
  GrossErrorCheck result;
  const ObservationSpace all = measured_space(trials, rig, settings.noise_mm);
  const int samples = measured_samples(all);
  result.readings = samples;
  if (!PositionJudge::can_judge(all)) {
    result.not_possible = "the instrument's readings are no positions of the tool";
    return result;
  }
  const double chance = kFalseAlarms / std::max(samples, 1);
  const int most = static_cast<int>(kMostAccidents * samples) + kHidden;
  std::vector<Trial> good(trials.begin(), trials.end());
  std::vector<int> out;  // samples, in order of removal
  std::size_t bad = 0;
  VectorXd start = all.nominal;
  while (static_cast<int>(out.size()) <= most && out.size() < bad + kHidden) {
    const ObservationSpace space = measured_space(good, rig, settings.noise_mm);
    if (space.rows() - space.parameters() <= space.position_axes) break;
    const LeastSquaresFit fit = plain_fit(space, settings, start);
    if (fit.status == FitStatus::kBadStart) break;
    start = fit.x;
    const PositionJudge judge(space, fit);
    const auto suspect = most_suspect(space, judge.each_by_the_others());
    if (!suspect) break;
    out.push_back(suspect->sample);
    without(good, {suspect->sample});
    if (suspect->verdict.chance < chance) bad = out.size();
  }
  good.assign(trials.begin(), trials.end());
  out.resize(bad);
  without(good, out);
  const ObservationSpace space = measured_space(good, rig, settings.noise_mm);
  if (space.rows() - space.parameters() <= space.position_axes) {
    result.not_possible = too_few(samples, all.parameters(), "positions");
    return result;
  }
  const LeastSquaresFit fit = plain_fit(space, settings, all.nominal);
  if (fit.status == FitStatus::kBadStart) {
    result.not_possible = "the nominal robot cannot reach all poses";
    return result;
  }
  const auto judge = std::make_shared<const PositionJudge>(space, fit);
  result.x = fit.x;
  result.sigma_mm = judge->sigma_mm();
  result.limit_times_sigma = judge->limit(chance);
  result.positions = judge;
  std::vector<Trial> suspects(trials.begin(), trials.end());
  std::erase_if(suspects, [&](const Trial& trial) {
    return std::ranges::find(out, trial.sample) == out.end();
  });
  if (!suspects.empty()) {
    const ObservationSpace of = measured_space(suspects, rig, settings.noise_mm);
    list(of, judge->others(of), chance, result);
  }
  judge_number(samples, result);
  sort(result.found);
  return result;
}

}  // namespace sixdial::calibration
