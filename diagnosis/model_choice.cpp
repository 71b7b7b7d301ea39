#include "diagnosis/model_choice.h"

#include <algorithm>
#include <optional>

#include "calibration/crew.h"
#include "calibration/pose_groups.h"
#include "diagnosis/judging.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

/// Fold of each sample that has fitted readings, -1 of the others: all repeats of a pose are in
/// one fold.
std::vector<int> folds_of(const Readings& g1) {
  const std::vector<simulation::Trial>& trials = g1.trials();
  std::vector<std::size_t> used;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    if (g1.first_row(t + 1) > g1.first_row(t)) used.push_back(t);
  }
  std::vector<int> fold(trials.size(), -1);
  if (used.empty()) return fold;
  Eigen::MatrixXd joints(std::ssize(used), trials[used[0]].q.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    joints.row(static_cast<Eigen::Index>(i)) = trials[used[i]].q.transpose();
  }
  const std::vector<int> pose = calibration::pose_groups(joints);
  for (std::size_t i = 0; i < used.size(); ++i) fold[used[i]] = pose[i] % kChoiceFolds;
  return fold;
}

/// Everything but one fold, and that fold.
FittedAndJudged split(const Readings& readings, const std::vector<int>& fold, int out) {
  std::vector<bool> fitted;
  std::vector<bool> judged;
  for (const int each : fold) {
    fitted.push_back(each >= 0 && each != out);
    judged.push_back(each == out);
  }
  return {readings.counting(fitted), readings.counting(judged)};
}

/// One fold's answers go to the end of each candidate's.
class Folds {
 public:
  Folds(const GainQuestion& question, const GainSettings& settings, const std::stop_token& stop)
      : question_(question), settings_(settings), stop_(stop) {}

  [[nodiscard]] std::vector<CandidateErrors> run() {
    const std::vector<int> fold = folds_of(question_.explained.fitted);
    std::vector<std::optional<std::vector<CandidateErrors>>> answers(kChoiceFolds);
    calibration::in_parallel(kChoiceFolds, [&](int out) {
      if (!stop_.stop_requested()) answers[static_cast<std::size_t>(out)] = judged(fold, out);
    });
    for (const auto& fold_answers : answers) {
      if (stop_.stop_requested() || !fold_answers) return {};
      for (const CandidateErrors& each : *fold_answers) append(each);
    }
    // A candidate that one fold could not train is none.
    std::erase_if(candidates_, [&](const CandidateErrors& each) {
      return each.error_mm.size() != candidates_.front().error_mm.size();
    });
    return std::move(candidates_);
  }

 private:
  /// Of the candidates that this fold can train; empty if it has too few readings.
  [[nodiscard]] std::optional<std::vector<CandidateErrors>> judged(
      const std::vector<int>& fold, int out) const {
    const FittedAndJudged here = split(question_.explained.fitted, fold, out);
    const Eigen::Index fewest = here.fitted.model().parameter_count() + kFewestToSpare;
    if (here.fitted.count() < fewest || here.judged.count() == 0) return std::nullopt;
    const JointFit& extended = question_.extended;
    const double s_mm = std::max(extended.s_mm, settings_.noise_mm);
    const Eigen::VectorXd weight = weights_to_judge(question_.all, extended, here.judged, s_mm);
    int excluded = 0;
    const std::vector<std::size_t> poses = poses_to_judge(here.judged, weight, excluded);
    std::optional<FittedAndJudged> measured;
    if (question_.as_measured) measured = split(question_.as_measured->fitted, fold, out);
    const FittedAndJudged& as_measured = measured ? *measured : here;
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(as_measured.judged.count());
    const JointFit plain = fit_jointly(
        as_measured.fitted, measured ? as_measured.fitted.nominal() : question_.baseline.model,
        {}, measured ? nullptr : &question_.baseline);
    std::vector<CandidateErrors> result;
    add(result, GainModel::kCalibrated, {as_measured, measured ? ones : weight}, poses, plain);
    if (!extended.effects.empty() || measured || !question_.curves.empty()) {
      const JointFit set_right =
          measured ? fit_jointly(here.fitted, question_.baseline.model, {}) : plain;
      add(result, GainModel::kExtended, {here, weight}, poses,
          extended_on(here.fitted, extended, question_.curves, set_right));
    }
    return result;
  }

  void add(
      std::vector<CandidateErrors>& to, GainModel model, const Side& side,
      const std::vector<std::size_t>& poses, const JointFit& fit) const {
    to.push_back({model, false, judged_on(side, poses, fit, nullptr).error_mm});
    if (!settings_.networks) return;
    const auto network = trained_on(side.readings.fitted, fit, settings_.seed, stop_);
    if (network) to.push_back({model, true, judged_on(side, poses, fit, &*network).error_mm});
  }

  void append(const CandidateErrors& more) {
    auto at = std::ranges::find_if(candidates_, [&](const CandidateErrors& each) {
      return each.model == more.model && each.network == more.network;
    });
    if (at == candidates_.end()) at = candidates_.insert(at, {more.model, more.network, {}});
    const Eigen::Index before = at->error_mm.size();
    at->error_mm.conservativeResize(before + more.error_mm.size());
    at->error_mm.tail(more.error_mm.size()) = more.error_mm;
  }

  const GainQuestion& question_;
  const GainSettings& settings_;
  const std::stop_token& stop_;
  std::vector<CandidateErrors> candidates_;
};

}  // namespace

std::vector<CandidateErrors> cross_validated(
    const GainQuestion& question, const GainSettings& settings, const std::stop_token& stop) {
  return Folds(question, settings, stop).run();
}

}  // namespace sixdial::diagnosis
