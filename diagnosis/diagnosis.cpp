#include "diagnosis/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "calibration/crew.h"
#include "calibration/pose_groups.h"
#include "diagnosis/baseline.h"
#include "diagnosis/command_fit.h"
#include "diagnosis/drawn_samples.h"
#include "diagnosis/held_out.h"
#include "diagnosis/judging.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// G2 must show a cause with odds of ten to one to confirm it.
const double kConfirms = std::log(10.0);

/// One name for a finding and all it is tied with.
bool shares_a_name(const Finding& a, const Finding& b) {
  const auto names = [](const Finding& each) {
    std::vector<Hypothesis> all{each.hypothesis};
    for (const Rival& rival : each.tied_with) all.push_back(rival.hypothesis);
    return all;
  };
  for (const Hypothesis& x : names(a)) {
    for (const Hypothesis& y : names(b)) {
      if (x == y) return true;
    }
  }
  return false;
}

/// Takes a session through the stages of a verdict. Each stage fills its part of `result_`.
class Diagnoser {
 public:
  Diagnoser(
      const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
      std::vector<bool> held_out, const DiagnosisSettings& settings,
      const std::function<void(const DiagnosisProgress&)>& progress,
      const std::stop_token& stop)
      : settings_(settings),
        progress_(progress),
        stop_(stop),
        held_out_(sides_of(trials, std::move(held_out))),
        drawn_(draw(model, trials)),
        measured_(model, std::move(trials), drawn_),
        readings_(measured_),
        fewest_(model.parameter_count() + kFewestToSpare) {
    if (measured_.count() < fewest_) {
      throw std::invalid_argument(
          "a diagnosis needs at least " + std::to_string(fewest_) +
          " readings; this session has " + std::to_string(measured_.count()));
    }
  }

  [[nodiscard]] Diagnosis run() {
    using Stage = std::pair<const char*, void (Diagnoser::*)()>;
    constexpr Stage kStages[] = {
        {"naming causes", &Diagnoser::name_causes},
        {"confirming on G1 alone", &Diagnoser::confirm_and_judge},
        {"what is confirmed", &Diagnoser::tell_causes},
        {"limits", &Diagnoser::find_limits}};
    constexpr int kCount = static_cast<int>(std::size(kStages));
    for (int done = 0; done < kCount; ++done) {
      if (progress_) progress_({kStages[done].first, done, kCount});
      if (stop_.stop_requested()) return std::move(result_);
      (this->*kStages[done].second)();
    }
    if (progress_) progress_({"done", kCount, kCount});
    return std::move(result_);
  }

 private:
  /// Which samples are G2. A session without any gets every third pose, with all its repeats: a
  /// repeat of a fitted pose is not held out.
  std::vector<bool> sides_of(
      const std::vector<simulation::Trial>& trials, std::vector<bool> held_out) {
    result_.seed = settings_.seed;
    held_out.resize(trials.size(), false);
    if (std::none_of(held_out.begin(), held_out.end(), [](bool out) { return out; })) {
      result_.held_out_by_program = true;
      Eigen::MatrixXd joints(std::ssize(trials), trials.empty() ? 0 : trials[0].q.size());
      for (std::size_t t = 0; t < trials.size(); ++t) {
        joints.row(static_cast<Eigen::Index>(t)) = trials[t].q.transpose();
      }
      const std::vector<int> pose = calibration::pose_groups(joints);
      for (std::size_t t = 0; t < trials.size(); ++t) held_out[t] = pose[t] % 3 == 2;
    }
    return held_out;
  }

  std::vector<bool> draw(
      const simulation::ForwardModel& model, const std::vector<simulation::Trial>& trials) {
    // A free mount brings an unknown angle with each sample.
    constexpr std::size_t kMostFree = 600;
    const bool free = model.rig().cuboid.mount == geometry::Mount::kFree;
    // An arm has three times the parameters of a five-bar, and more places for each cause.
    constexpr std::size_t kMostInSpace = 700;
    std::size_t most = settings_.most_samples;
    if (most > 0 && free) most = std::min(most, kMostFree);
    if (most > 0 && model.robot().axes > 2) most = std::min(most, kMostInSpace);
    std::vector<bool> drawn = drawn_samples(trials, held_out_, most, settings_.seed);
    for (std::size_t t = 0; t < drawn.size(); ++t) {
      if (drawn[t]) ++(held_out_[t] ? result_.g2_samples : result_.g1_samples);
      if (!drawn[t]) result_.drawn_of = trials.size();
    }
    return drawn;
  }

  [[nodiscard]] FittedAndJudged split(const Readings& readings) const {
    std::vector<bool> fitted = held_out_;
    fitted.flip();
    return {readings.counting(fitted), readings.counting(held_out_)};
  }

  void name_causes() {
    result_.named = diagnosis::name_causes(readings_, settings_.search);
    const auto& swap = found().swap;
    result_.readings =
        swap ? measured_.with_swapped_dials(swap->place.dial, swap->place.other_dial)
        : found().joints_set_right ? readings_
                                   : measured_;
    result_.readings->place_tool(found().extended.model);
  }

  /// Asks G1 alone; and judges on G2 what was found, which does not depend on that: with a crew
  /// at the same time.
  void confirm_and_judge() {
    sides_ = split(readings_);
    enough_g1_ = sides_->fitted.count() >= fewest_;
    const bool anything = !found().findings.empty() || found().swap || found().rig_geometry ||
                          !found().dial_curves.empty() || !found().joint_curves.empty();
    const bool asks_g1 = enough_g1_ && anything;
    // More threads than two are better shared by the parts of each.
    const bool both = asks_g1 && calibration::crew_size() == 2;
    calibration::in_parallel(both ? 2 : 1, [&](int part) {
      if (part == 0) {
        if (asks_g1) name_on_g1();
      }
      if (part == 1 || !both) {
        describe_remainder();
        judge_on_g2();
      }
    });
  }

  void name_on_g1() {
    // An exchange has to show itself there too.
    const bool set_right = found().swap || found().joints_set_right;
    Readings on_g1 =
        (set_right ? split(measured_).fitted : sides_->fitted).allowing_rig(std::nullopt);
    alone_ = diagnosis::name_causes(on_g1, settings_.search);
  }

  /// A curve is confirmed where G1 alone names it and G2 alone shows that something smooth goes
  /// by that dial's reading, or that joint's value.
  void confirm_curves() {
    std::vector<DialCurve>& dials = result_.named.dial_curves;
    std::vector<JointCurve>& joints = result_.named.joint_curves;
    if ((dials.empty() && joints.empty()) || !alone_) return;
    if (sides_->judged.count() < fewest_) return;
    const Readings g2 = split(as_read()).judged;
    const JointFit fit = fit_jointly(g2, found().extended.model, found().extended.effects);
    const std::vector<UnknownCandidate> seen = score_unknown(g2, fit);
    const auto confirm = [&](OwnCurve& curve, bool on_g1) {
      curve.on_g1 = on_g1;
      const auto own = std::ranges::find_if(seen, [&](const UnknownCandidate& each) {
        return each.enters == curve.smooth.enters &&
               each.covariates == curve.smooth.covariates &&
               same_wave(curve, sine_length(each.kernel));
      });
      if (own != seen.end()) curve.g2_log_odds = own->evidence;
      curve.confirmed = curve.on_g1 && curve.g2_log_odds > kConfirms && curve.certain();
    };
    for (DialCurve& curve : dials) {
      confirm(
          curve, std::ranges::find(alone_->dial_curves, curve.dial, &DialCurve::dial) !=
                     alone_->dial_curves.end());
    }
    for (JointCurve& curve : joints) {
      confirm(curve, std::ranges::any_of(alone_->joint_curves, [&](const JointCurve& each) {
                return each.place.joint == curve.place.joint && same_wave(curve, each.period);
              }));
    }
  }

  /// Whether a curve of other samples has the same strongest wave, or as this one none.
  [[nodiscard]] static bool same_wave(const OwnCurve& curve, std::optional<double> other) {
    constexpr double kTold = 1.5;  // waves over the range that may be the same one
    const auto& own = curve.period;
    if (!own || !other) return own.has_value() == other.has_value();
    return std::abs(curve.smooth.kernel.range() * (1 / *own - 1 / *other)) < kTold;
  }

  void describe_remainder() {
    result_.rig = rig_as_seen(readings_, found().extended);
    result_.noise = noise_of(readings_, found().extended);
    add_dependence();
    // Something smooth without a name counts as left over.
    result_.commanding = command_fit(as_read(), found());
    result_.commanding_rig = rig_as_seen(readings_, result_.commanding);
    const JointFit& names = result_.commanding;
    add_parameters();
    result_.not_testable = found().not_testable;
    const JointFit& extended = found().extended;
    const bool smooth = !found().unknown.empty();
    Remainder& left = result_.unexplained;
    left.rms_mm = std::sqrt(
        names.weight.dot(residual_at_rest_mm(as_read(), names).cwiseAbs2()) /
        std::max(1.0, names.weight.sum()));
    left.depends_on = found().depends_on();
    Scatter scatter = scatter_of(readings_, extended, result_.noise);
    const bool shared = extended.shared != nullptr;
    left.scatter = (!smooth && scatter.of_all) || shared || !scatter.dials.empty();
    if (shared || !smooth) left.scatter_size = scatter.found;
    left.noisy_dials = std::move(scatter.dials);
    left.significant = smooth || left.scatter;
  }

  void judge_on_g2() {
    // Whether G2 shows a cause too does not depend on the table that the user may leave out.
    if (enough_g1_ && (settings_.with_gain || !found().findings.empty())) {
      GainQuestion question{as_read(),        split(as_read()), std::nullopt,
                            found().baseline, found().extended, found().curves()};
      if (found().swap) question.as_measured = split(measured_);
      GainSettings how;
      how.draws = settings_.gain_draws;
      how.seed = settings_.seed;
      how.noise_mm = result_.noise.sigma_mm;
      how.table = settings_.with_gain;
      study_ = study_gain(question, how, stop_);
      result_.gain = study_.rows;
      for (std::size_t i = 0; i < study_.g2_log_odds.size(); ++i) {
        against_.push_back(speaks_against(
            question.explained.judged, study_.extended, study_.without[i],
            study_.g2_log_odds[i]));
      }
      if (settings_.with_gain && !stop_.stop_requested()) {
        result_.choice = cross_validated(question, how, stop_);
        result_.on_top = trained_on(as_read(), result_.commanding, settings_.seed, stop_);
      }
    }
  }

  void tell_causes() {
    result_.rig_confirmed = alone_ && alone_->rig_geometry;
    confirm_curves();
    for (std::size_t i = 0; i < found().findings.size(); ++i) {
      result_.causes.push_back(cause_of(i));
    }
    std::stable_sort(
        result_.causes.begin(), result_.causes.end(),
        [](const Cause& a, const Cause& b) { return a.finding.evidence > b.finding.evidence; });
    if (found().swap) result_.causes.insert(result_.causes.begin(), exchanged_dials());
  }

  void find_limits() {
    std::vector<NotTestable> ignored;
    const std::vector<Hypothesis> testable = hypotheses_for(readings_, ignored);
    if (settings_.with_limits) {
      std::vector<Hypothesis> open;
      for (const Hypothesis& each : testable) {
        const bool named = std::any_of(
            result_.causes.begin(), result_.causes.end(),
            [&](const Cause& cause) { return cause.finding.hypothesis == each; });
        if (!named) open.push_back(each);
      }
      result_.limits = limits_of(as_read(), result_.commanding, open, settings_.search);
      for (const Limit& limit : result_.limits) {
        if (limit.detect < kBelievableSizes * limit.plausible) continue;
        result_.not_testable.push_back({limit.hypothesis, WhyNotTestable::kAbsorbed});
      }
    }
    result_.false_alarm_probability = found().family_p_value;
    if (settings_.null_draws > 0) {
      result_.false_alarm_probability = simulated_false_alarm(
          as_read(), found().baseline, testable, found().family_p_value, settings_.null_draws,
          settings_.seed);
    }
  }

  /// What is left along each smooth function, before and after the causes.
  void add_dependence() {
    const auto left = score_unknown(readings_, found().extended);
    for (const UnknownCandidate& first : score_unknown(as_read(), found().baseline)) {
      // A joint's curve and its waves depend on the same: the best of them counts, the first.
      const auto same = [&](const auto& other) {
        return other.covariates == first.covariates && other.enters == first.enters;
      };
      if (std::ranges::any_of(result_.dependence, same)) continue;
      Dependence each{first.covariates, first.enters, first.evidence, 0.0, first.rms_mm, 0.0};
      const auto second = std::ranges::find_if(left, same);
      if (second != left.end()) {
        each.log_odds_after = second->evidence;
        each.rms_after_mm = second->rms_mm;
      }
      result_.dependence.push_back(std::move(each));
    }
  }

  void add_parameters() {
    const simulation::ForwardModel& model = readings_.model();
    const simulation::ModelVector nominal = readings_.nominal();
    const JointFit& baseline = found().baseline;
    const JointFit& extended = result_.commanding;
    const auto sd = [](const JointFit& fit, Eigen::Index i) {
      return std::sqrt(std::max(0.0, fit.covariance(i, i)));
    };
    for (Eigen::Index i = 0; i < model.parameter_count(); ++i) {
      // Those of the instrument have no part in positions.
      const bool of_robot = i < model.robot_parameter_count();
      if (!of_robot && readings_.of() == Readings::Of::kPositions) continue;
      const auto& info = model.parameters()[static_cast<std::size_t>(i)];
      result_.parameters.push_back(
          {info.name, info.unit, nominal[i], baseline.model[i], sd(baseline, i),
           extended.model[i], sd(extended, i)});
    }
  }

  /// Mean position error on G2 of a model without a network; NaN if it was not judged.
  [[nodiscard]] double mean_mm(
      GainModel which, const std::optional<Hypothesis>& without = {}) const {
    for (const GainRow& row : result_.gain) {
      if (row.model == which && !row.network && row.without == without) return row.mean_mm;
    }
    return kNan;
  }

  [[nodiscard]] Cause cause_of(std::size_t i) const {
    Cause cause;
    cause.finding = found().findings[i];
    cause.estimate = estimates_of(found().extended, i);
    cause.delta_bic = 2 * cause.finding.evidence;
    cause.visible_ratio = visible_ratio(readings_, found().extended, i);
    cause.on_g1 =
        alone_ && std::any_of(
                      alone_->findings.begin(), alone_->findings.end(),
                      [&](const Finding& each) { return shares_a_name(each, cause.finding); });
    if (i < study_.g2_log_odds.size()) cause.g2_log_odds = study_.g2_log_odds[i];
    if (i < against_.size() && against_[i]) {
      // What is not where it must show may as well be nothing, and these odds say so.
      cause.finding.tied_with_nothing = true;
      cause.finding.evidence = cause.g2_log_odds;
    }
    // G2 is asked with and without the name, not with something smooth in its place.
    const bool its_own = cause.finding.tied_with_unknown.empty();
    cause.confirmed =
        cause.on_g1 && cause.g2_log_odds > kConfirms && its_own && !cause.finding.of_a_part();
    cause.gain_mm =
        mean_mm(GainModel::kWithout, cause.finding.hypothesis) - mean_mm(GainModel::kExtended);
    return cause;
  }

  /// As a cause: held against the readings as they came.
  [[nodiscard]] Cause exchanged_dials() const {
    Cause cause;
    cause.finding = {*found().swap, at_rest(*found().swap), 0.0, {}, false};
    cause.finding.left_out = found().extended.left_out();
    const JointFit as_it_came = fit_baseline(measured_);
    cause.finding.evidence = found().baseline.log_likelihood - as_it_came.log_likelihood;
    cause.delta_bic = 2 * cause.finding.evidence;
    const auto count = static_cast<double>(measured_.count());
    cause.visible_ratio = std::sqrt(as_it_came.residual_mm.squaredNorm() / count) /
                          std::max(1e-12, result_.noise.sigma_mm);
    cause.on_g1 = alone_ && alone_->swap == found().swap;
    if (enough_g1_) {
      const auto likelihood = [&](const Readings& g2) {
        return fit_jointly(g2, found().baseline.model, {}).log_likelihood;
      };
      const double crossed = likelihood(measured_.counting(held_out_));
      cause.g2_log_odds = likelihood(sides_->judged) - crossed;
    }
    cause.confirmed =
        cause.on_g1 && cause.g2_log_odds > kConfirms && !cause.finding.of_a_part();
    cause.gain_mm = mean_mm(GainModel::kCalibrated) - mean_mm(GainModel::kExtended);
    return cause;
  }

  [[nodiscard]] const NamedCauses& found() const { return result_.named; }
  /// With the joint values as they were read: models that bend the joints are fitted to these.
  [[nodiscard]] const Readings& as_read() const {
    return found().joints_set_right ? measured_ : readings_;
  }

  Diagnosis result_;
  const DiagnosisSettings& settings_;
  const std::function<void(const DiagnosisProgress&)>& progress_;
  const std::stop_token& stop_;
  std::vector<bool> held_out_;
  std::vector<bool> drawn_;
  Readings measured_;
  Readings readings_;  // as they were explained: exchanged dials set right
  Eigen::Index fewest_;
  std::optional<FittedAndJudged> sides_;  // of readings_
  bool enough_g1_ = false;
  std::optional<NamedCauses> alone_;  // what G1 alone shows
  GainStudy study_;                   // what G2 shows
  std::vector<bool> against_;         // by cause: G2 does not show what it must
};

}  // namespace

Diagnosis diagnose(
    const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
    std::vector<bool> held_out, const DiagnosisSettings& settings,
    const std::function<void(const DiagnosisProgress&)>& progress,
    const std::stop_token& stop) {
  return Diagnoser(model, std::move(trials), std::move(held_out), settings, progress, stop)
      .run();
}

}  // namespace sixdial::diagnosis
