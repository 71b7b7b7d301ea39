// Which model to command by, and the one set of parameters that belongs to it: the advice, the
// report's table, the export, the default of `compensate` and the live page all ask here.
//
//   candidates     kinematics; robot and named causes; each with a residual model on top
//   chosen         by cross-validation within G1, whole poses left out: the simplest one whose
//                  mean error is within a standard error, or a twentieth, of the best one's
//   ruled out      what was commanded again and missed by more than plain kinematics
//   G2             only reports
//
// Example:
//   const CalibrationResult result = calibrate(session, {.method = "lm"});
//   const Recommendation recommended = recommend(result);
//   recommended.by == CompensateBy::kKinematics;  // -> true
//   show(recommended.parameters.front().identified);
#pragma once

#include <optional>
#include <vector>

#include "studies/calibration_result.h"
#include "studies/diagnosis_result.h"
#include "studies/validate.h"

namespace sixdial::studies {

struct RecommendedWay {
  CompensateBy by = CompensateBy::kKinematics;
  std::optional<double> held_out_mm{};  // mean error on poses of G1 that were left out in turn
  std::optional<double> g2_mm{};        // mean error on G2, modelled
  std::optional<double> reached_mm{};   // mean error when it was commanded again
  /// Missed by more than plain kinematics (these: than nominal, and the untried go with them).
  bool ruled_out = false;
};

enum class ChosenBecause {
  kNotCompared,  // there is no cross-validation: plain kinematics
  kOnlyOne,      // no other model there is to choose from
  kBest,         // no simpler one is as good
  kSimplest,     // a more complex one is better by no more than chance, or by next to nothing
  kRuledOut,     // the better ones were ruled out by a validation
  kNothingHelps  // plain kinematics is no better than the nominal parameters
};

struct Recommendation {
  CompensateBy by = CompensateBy::kKinematics;  // kBefore where nothing helps
  ChosenBecause because = ChosenBecause::kNotCompared;
  std::optional<CompensateBy> best{};           // by cross-validation alone
  bool by_diagnosis = false;                    // whose cross-validation compared them
  int folds = 0, samples = 0;                   // of the cross-validation; 0: none
  std::vector<RecommendedWay> candidates{};     // "before" first, then from simple to complex
  std::vector<ParameterRow> parameters{};       // of the robot, identified even for kBefore
  std::vector<HypothesisId> causes{};           // that belong to the parameters
  std::optional<std::string> residual_model{};  // that belongs to the parameters, "anfis"

  [[nodiscard]] const RecommendedWay* of(CompensateBy way) const;
};

/// `diagnosis`, `validation`: null where there is none; left aside where made from other data.
[[nodiscard]] Recommendation recommend(
    const CalibrationResult& calibration, const DiagnosisResult* diagnosis = nullptr,
    const ValidationResult* validation = nullptr);

}  // namespace sixdial::studies
