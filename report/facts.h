// Figures that more than one place of a report shows: each is worked out once, under one
// definition. Sections and sentences read it from here, so that no two of them can differ.
// ReportData::methods (position errors) and ReportData::parameters are of the same kind.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/calibration_result.h"
#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// A reading, or a position as a whole, that does not agree with the rest of its session.
struct StandsOut {
  std::string set{};
  int point = 0, repeat = 0;
  std::string dial{};          // empty: the position as a whole
  double off_mm = 0.0;         // measured minus modelled, by the diagnosis where there is one
  double times_noise = 0.0;    // |off| over the usual size, of whichever study found it
  bool not_fitted = false;     // the calibration left it out
  bool not_diagnosed = false;  // the diagnosis left it out
  std::string remark{};
};

/// The robot's parameters as one fit found them, in shown units (mm, deg) and in the order of
/// the report's parameter table.
struct Fit {
  std::string key{};   // in CSV: "calibration", "least_squares", "robot_alone", "with_causes"
  std::string name{};  // "robot alone, raw readings"
  std::vector<std::optional<double>> value{}, sd{};
};

struct Facts {
  std::vector<StandsOut> stand_out{};           // by set, point, repeat and dial
  std::optional<studies::GrossErrors> check{};  // how the calibration looked for them
  std::vector<Fit> fits{};                      // the delivered one first
};

/// Readings that either study found, each once.
[[nodiscard]] std::vector<StandsOut> stand_out_of(
    const std::optional<studies::GrossErrors>& check,
    const studies::DiagnosisResult* diagnosis);

/// Every fit that the report speaks of. Least squares only where it differs from the delivered
/// parameters by more than a tenth of a standard deviation.
[[nodiscard]] std::vector<Fit> fits_of(
    const studies::CalibrationResult& result, const studies::DiagnosisResult* diagnosis);

/// "3 readings do not agree with the rest: 2 were left out of the fit, ..."; empty: none.
[[nodiscard]] std::string stand_out_in_words(const std::vector<StandsOut>& all);

}  // namespace sixdial::report
