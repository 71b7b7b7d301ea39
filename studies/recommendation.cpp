#include "studies/recommendation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "studies/method_name.h"

namespace sixdial::studies {
namespace {

constexpr double kQuantile95 = 1.959963984540054;

/// From simple to complex.
constexpr std::array kWays{
    CompensateBy::kKinematics, CompensateBy::kExtended, CompensateBy::kFull,
    CompensateBy::kExtendedFull};

bool has_residual_model(const CalibrationResult& calibration) {
  return calibration.networks.has_value() || calibration.residual_model.has_value();
}

std::string residual_model_of(const CalibrationResult& calibration) {
  if (calibration.networks) return "anfis";
  return calibration.residual_model ? calibration.residual_model->name : "";
}

std::optional<double> mean_of(const std::optional<SetErrors>& errors) {
  if (!errors || !std::isfinite(errors->mean_mm)) return std::nullopt;
  return errors->mean_mm;
}

std::optional<double> g2_of(
    const CalibrationResult& calibration, const DiagnosisResult* diagnosis, CompensateBy by) {
  if (is_extended(by)) {
    const GainRow* row = diagnosis == nullptr ? nullptr
                                              : gain_row(
                                                    *diagnosis, diagnosis::GainModel::kExtended,
                                                    by == CompensateBy::kExtendedFull);
    return row == nullptr ? std::nullopt : std::optional(row->mean_mm);
  }
  const std::string id = by == CompensateBy::kBefore ? "before"
                         : by == CompensateBy::kFull
                             ? calibration.result_method
                             : without_residual_model(calibration.result_method);
  const MethodRow* row = calibration.method(id);
  return row == nullptr ? std::nullopt : mean_of(row->g2);
}

const ValidatedWay* way_of(const ValidationResult* validation, CompensateBy by) {
  if (validation == nullptr) return nullptr;
  const auto found = std::ranges::find(validation->methods, by, &ValidatedWay::by);
  return found == validation->methods.end() || !found->errors ? nullptr : &*found;
}

/// Whether the calibration has what this way commands by, and the diagnosis.
bool can_command(
    const CalibrationResult& calibration, const DiagnosisResult* diagnosis, CompensateBy by) {
  switch (by) {
    case CompensateBy::kBefore:
    case CompensateBy::kKinematics:
      return true;
    case CompensateBy::kFull:
      return has_residual_model(calibration);
    case CompensateBy::kExtended:
      return diagnosis != nullptr && !diagnosis->extended_fit.effects.empty();
    case CompensateBy::kExtendedFull:
      return diagnosis != nullptr && !diagnosis->extended_fit.effects.empty() &&
             diagnosis->extended_fit.residual_model.has_value();
  }
  return false;
}

/// A model that is better by less than this share of the error is not worth its complexity.
constexpr double kWorthwhile = 0.05;

/// The simplest of `ways` that the best of them betters by no more than a standard error, or by
/// no more than is worthwhile.
std::optional<CompensateBy> chosen_of(
    const CrossValidation& checked, const std::vector<CompensateBy>& ways) {
  std::optional<CompensateBy> best;
  for (const CompensateBy by : ways) {
    const auto mean = mean_error(checked, by);
    if (!mean) continue;
    if (!best || mean->mean_mm < mean_error(checked, *best)->mean_mm) best = by;
  }
  if (!best) return best;
  for (const CompensateBy by : ways) {
    const auto more = difference(checked, by, *best);
    if (by == *best) return by;
    if (!more) continue;
    const double enough_mm = kWorthwhile * mean_error(checked, *best)->mean_mm;
    if (more->mean_mm <= std::max(more->standard_error_mm, enough_mm)) return by;
  }
  return best;
}

/// Chooses among the candidates of one session.
class Choice {
 public:
  Choice(
      const CalibrationResult& calibration, const DiagnosisResult* diagnosis,
      const ValidationResult* validation)
      : calibration_(calibration), diagnosis_(diagnosis), validation_(validation) {}

  [[nodiscard]] Recommendation run() {
    add_candidates();
    choose();
    add_parameters();
    return std::move(result_);
  }

 private:
  [[nodiscard]] const CrossValidation* by_calibration() const {
    return calibration_.cross_validation ? &*calibration_.cross_validation : nullptr;
  }
  [[nodiscard]] const CrossValidation* by_diagnosis() const {
    return diagnosis_ != nullptr && diagnosis_->cross_validation
               ? &*diagnosis_->cross_validation
               : nullptr;
  }

  /// The cross-validation that has all candidates: the diagnosis' where it names causes that
  /// can be commanded by, else the calibration's.
  [[nodiscard]] const CrossValidation* checked() const {
    const CrossValidation* diagnosed = by_diagnosis();
    const bool causes = can_command(calibration_, diagnosis_, CompensateBy::kExtended);
    return causes && diagnosed != nullptr && diagnosed->of(CompensateBy::kExtended) != nullptr
               ? diagnosed
               : by_calibration();
  }

  /// A diagnosis learns with its own residual model: it judges `full` only where that is the
  /// calibration's too.
  [[nodiscard]] bool is_judged(CompensateBy by) const {
    const CrossValidation* checked = this->checked();
    if (checked == nullptr || checked->of(by) == nullptr) return false;
    return by != CompensateBy::kFull || checked == by_calibration() ||
           checked->residual_model == residual_model_of(calibration_);
  }

  void add_candidates() {
    const ValidatedWay* plain = way_of(validation_, CompensateBy::kKinematics);
    const ValidatedWay* before = way_of(validation_, CompensateBy::kBefore);
    std::vector<CompensateBy> ways{CompensateBy::kBefore};
    ways.insert(ways.end(), kWays.begin(), kWays.end());
    for (const CompensateBy by : ways) {
      if (!can_command(calibration_, diagnosis_, by)) continue;
      RecommendedWay candidate{.by = by, .g2_mm = g2_of(calibration_, diagnosis_, by)};
      if (is_judged(by)) candidate.held_out_mm = mean_error(*checked(), by)->mean_mm;
      if (const ValidatedWay* way = way_of(validation_, by)) {
        candidate.reached_mm = way->errors->mean_mm;
        const ValidatedWay* against = by == CompensateBy::kKinematics ? before : plain;
        candidate.ruled_out = by != CompensateBy::kBefore && against != nullptr &&
                              way->errors->mean_mm > against->errors->mean_mm;
      }
      result_.candidates.push_back(candidate);
    }
  }

  /// Plain kinematics was commanded again and did worse than the nominal parameters: then what
  /// was not commanded again is not believed either.
  [[nodiscard]] bool is_refuted() const {
    const RecommendedWay* plain = result_.of(CompensateBy::kKinematics);
    return plain != nullptr && plain->ruled_out;
  }

  [[nodiscard]] std::vector<CompensateBy> judged(bool with_ruled_out) const {
    std::vector<CompensateBy> ways;
    for (const RecommendedWay& each : result_.candidates) {
      if (!with_ruled_out && is_refuted() && !each.reached_mm) continue;
      if (each.held_out_mm && (with_ruled_out || !each.ruled_out)) ways.push_back(each.by);
    }
    return ways;
  }

  void choose() {
    const CrossValidation* checked = this->checked();
    if (checked != nullptr) {
      result_.by_diagnosis = checked == by_diagnosis();
      result_.folds = checked->folds;
      const auto mean = mean_error(*checked, CompensateBy::kKinematics);
      result_.samples = mean ? mean->samples : 0;
    }
    if (nothing_helps()) {
      result_.by = CompensateBy::kBefore;
      result_.because = ChosenBecause::kNothingHelps;
      return;
    }
    const std::vector<CompensateBy> all = judged(true);
    if (checked == nullptr || all.empty()) return;
    for (const CompensateBy by : all) {
      const double mean_mm = result_.of(by)->held_out_mm.value();
      if (!result_.best || mean_mm < result_.of(*result_.best)->held_out_mm.value()) {
        result_.best = by;
      }
    }
    const auto free_choice = chosen_of(*checked, all);
    const auto chosen = chosen_of(*checked, judged(false));
    result_.by = chosen.value_or(CompensateBy::kKinematics);
    result_.because = result_.by != free_choice    ? ChosenBecause::kRuledOut
                      : all.size() == 1            ? ChosenBecause::kOnlyOne
                      : result_.by == result_.best ? ChosenBecause::kBest
                                                   : ChosenBecause::kSimplest;
  }

  /// No candidate is better than the nominal parameters: as measured again where both were,
  /// else as poses that were not fitted tell.
  [[nodiscard]] bool nothing_helps() const {
    const RecommendedWay* before = result_.of(CompensateBy::kBefore);
    const MethodRow* row = calibration_.method("before");
    const std::optional<double> on_g1 = row == nullptr ? std::nullopt : mean_of(row->g1);
    bool compared = false;
    for (const RecommendedWay& each : result_.candidates) {
      if (each.by == CompensateBy::kBefore) continue;
      const bool again = each.reached_mm && before->reached_mm;
      if (!again && is_refuted()) continue;
      const std::optional<double> reference = again ? before->reached_mm : on_g1;
      const std::optional<double> own = again ? each.reached_mm : each.held_out_mm;
      if (!reference || !own) continue;
      compared = true;
      if (*own < *reference) return false;
    }
    return compared;
  }

  void add_parameters() {
    result_.parameters = calibration_.parameters;
    if (result_.by == CompensateBy::kFull) {
      result_.residual_model = residual_model_of(calibration_);
    }
    if (!is_extended(result_.by)) return;
    for (const FittedEffect& each : diagnosis_->extended_fit.effects) {
      result_.causes.push_back(each.id);
    }
    if (result_.by == CompensateBy::kExtendedFull) {
      result_.residual_model = diagnosis_->extended_fit.residual_model->name;
    }
    for (ParameterRow& row : result_.parameters) {
      const auto found = std::ranges::find(
          diagnosis_->parameters, row.name, &diagnosis::ParameterChange::name);
      if (found == diagnosis_->parameters.end()) continue;
      row.identified = found->extended;
      row.sd = found->extended_sd;
      row.low_95 = row.identified - kQuantile95 * row.sd;
      row.high_95 = row.identified + kQuantile95 * row.sd;
      row.fixed = false;
    }
  }

  const CalibrationResult& calibration_;
  const DiagnosisResult* diagnosis_;
  const ValidationResult* validation_;
  Recommendation result_;
};

}  // namespace

const RecommendedWay* Recommendation::of(CompensateBy way) const {
  const auto found = std::ranges::find(candidates, way, &RecommendedWay::by);
  return found == candidates.end() ? nullptr : &*found;
}

Recommendation recommend(
    const CalibrationResult& calibration, const DiagnosisResult* diagnosis,
    const ValidationResult* validation) {
  const std::string& data = calibration.inputs.data_hash;
  if (diagnosis != nullptr && diagnosis->inputs.data_hash != data) diagnosis = nullptr;
  if (validation != nullptr && validation->inputs.calibration_data_hash != data) {
    validation = nullptr;
  }
  return Choice(calibration, diagnosis, validation).run();
}

}  // namespace sixdial::studies
