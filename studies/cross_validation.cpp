#include "studies/cross_validation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/pose_groups.h"
#include "session/trials.h"
#include "studies/assessment.h"
#include "studies/method_name.h"
#include "studies/seen_rig.h"

namespace sixdial::studies {
namespace {

constexpr int kFolds = 5;
/// More poses than this tell no more about which model is better.
constexpr int kMostPoses = 2000;

/// Samples that all models reach.
std::vector<std::size_t> usable(const CrossValidation& checked) {
  std::vector<std::size_t> result;
  if (checked.models.empty()) return result;
  for (std::size_t i = 0; i < checked.models.front().error_mm.size(); ++i) {
    const bool all = std::ranges::all_of(checked.models, [&](const CheckedModel& each) {
      return i < each.error_mm.size() && std::isfinite(each.error_mm[i]);
    });
    if (all) result.push_back(i);
  }
  return result;
}

std::vector<int> poses_of(std::span<const simulation::Trial> trials) {
  Eigen::MatrixXd joints(std::ssize(trials), trials.empty() ? 0 : trials[0].q.size());
  for (std::size_t t = 0; t < trials.size(); ++t) {
    joints.row(static_cast<Eigen::Index>(t)) = trials[t].q.transpose();
  }
  return calibration::pose_groups(joints);
}

/// The same samples, their positions by another rig.
std::vector<simulation::Trial> measured_again(
    const std::vector<simulation::Trial>& trials, const session::Session& seen) {
  std::vector<simulation::Trial> result;
  std::size_t at = 0;
  for (simulation::Trial& each : session::trials_of(seen, "")) {
    if (at < trials.size() && each.sample == trials[at].sample) {
      result.push_back(std::move(each));
      ++at;
    }
  }
  return result;
}

}  // namespace

const CheckedModel* CrossValidation::of(CompensateBy by) const {
  const auto found = std::ranges::find(models, by, &CheckedModel::by);
  return found == models.end() ? nullptr : &*found;
}

std::optional<MeanError> mean_error(const CrossValidation& checked, CompensateBy by) {
  const CheckedModel* model = checked.of(by);
  const std::vector<std::size_t> samples = usable(checked);
  if (model == nullptr || samples.empty()) return std::nullopt;
  double sum = 0.0;
  for (const std::size_t i : samples) sum += model->error_mm[i];
  return MeanError{sum / static_cast<double>(samples.size()), static_cast<int>(samples.size())};
}

std::optional<ErrorDifference> difference(
    const CrossValidation& checked, CompensateBy one, CompensateBy other) {
  const CheckedModel* a = checked.of(one);
  const CheckedModel* b = checked.of(other);
  const std::vector<std::size_t> samples = usable(checked);
  if (a == nullptr || b == nullptr || samples.size() < 2) return std::nullopt;
  const auto count = static_cast<double>(samples.size());
  ErrorDifference result;
  for (const std::size_t i : samples) {
    result.mean_mm += (a->error_mm[i] - b->error_mm[i]) / count;
  }
  double squares = 0.0;
  for (const std::size_t i : samples) {
    squares += std::pow(a->error_mm[i] - b->error_mm[i] - result.mean_mm, 2);
  }
  result.standard_error_mm = std::sqrt(squares / (count - 1) / count);
  return result;
}

std::optional<CrossValidation> cross_validated(
    std::span<const simulation::Trial> g1, const session::Session& session,
    const geometry::Rig* file_rig, const calibration::MethodChoice& method,
    const calibration::ComparisonSettings& settings, const std::stop_token& stop) {
  CrossValidation result{.folds = kFolds};
  std::vector<calibration::MethodChoice> choices{
      {without_residual_model(method.id), method.identifier, nullptr}};
  result.models.push_back({.by = CompensateBy::kKinematics});
  if (method.residual != nullptr) {
    choices.push_back(method);
    result.models.push_back({.by = CompensateBy::kFull});
    result.residual_model = method.residual->name;
  }
  const std::vector<int> pose = poses_of(g1);
  const int poses = pose.empty() ? 0 : *std::ranges::max_element(pose) + 1;
  const int stride = (poses + kMostPoses - 1) / std::max(1, kMostPoses);
  for (int out = 0; out < kFolds; ++out) {
    std::vector<simulation::Trial> fitted;
    std::vector<simulation::Trial> judged;
    for (std::size_t t = 0; t < g1.size(); ++t) {
      if (pose[t] % std::max(1, stride) != 0) continue;
      const bool is_out = pose[t] / std::max(1, stride) % kFolds == out;
      (is_out ? judged : fitted).push_back(g1[t]);
    }
    // Held out means held out: where the dials stand is found without these readings too.
    session::Session seen = session;
    std::optional<diagnosis::RigFit> rig;
    if (file_rig != nullptr) {
      rig = diagnosis::fit_rig(fitted, *file_rig);
      seen.rig = rig ? rig->rig : *file_rig;
      fitted = measured_again(fitted, seen);
      judged = measured_again(judged, seen);
    }
    const auto space = [&](const std::vector<simulation::Trial>& trials) {
      return with_rig_as_seen(
          space_of("positions", trials, seen, settings.identify.noise_mm), trials, rig);
    };
    const calibration::ObservationSpace train = space(fitted);
    if (calibration::trouble_with(train) || judged.empty()) return std::nullopt;
    calibration::ObservationSpace left_out = space(judged);
    left_out.nominal = train.nominal;
    const auto found =
        calibration::compare_methods(train, train, left_out, choices, settings, {}, stop);
    if (!found) return std::nullopt;
    for (std::size_t k = 0; k < choices.size(); ++k) {
      const std::vector<double>& errors = found->methods.at(k).errors.g2_mm;
      std::vector<double>& all = result.models[k].error_mm;
      all.insert(all.end(), errors.begin(), errors.end());
    }
  }
  return result;
}

}  // namespace sixdial::studies
