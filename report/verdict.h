// The state of the robot in words: what a metrologist reads first. Every sentence follows from
// figures in the report; nothing here is an opinion that the tables do not bear out.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/report_data.h"

namespace sixdial::report {

enum class CalibrationState {
  kUnknown,        // nothing to compare, or nobody has looked whether the data are plausible
  kCalibrated,     // at least twice as accurate on points that were not fitted
  kImproved,       // more accurate, by less than that
  kNotImproved,    // the calibration does not help
  kNotValidated,   // better on the fitted points; there are no others
  kNotCalibrated,  // something about the session forbids to believe its figures
};
/// "calibrated", "not_calibrated": `state` in documents.
[[nodiscard]] std::string_view state_name(CalibrationState state);
/// kUnknown for a word that is none of them.
[[nodiscard]] CalibrationState state_from(std::string_view name);

/// The colour of the box that is read first. doc/manual/report.md says the same.
enum class Mood {
  kPlain,  // blue: no tolerance is stated, and nothing is left open
  kGood,   // green: within tolerance, and nothing is left open
  kOpen,   // ochre: a cause or structure remains, or the tolerance cannot be decided
  kBad,    // red: outside tolerance, or the result is not to be used
};
/// "plain", "good", "open", "bad".
[[nodiscard]] std::string_view mood_name(Mood mood);

struct Verdict {
  CalibrationState state = CalibrationState::kUnknown;
  Mood mood = Mood::kOpen;
  std::string decision{};  // on the tolerance, one or two sentences; empty: nothing to decide
  std::string title{};     // "Calibrated"
  std::string headline{};  // one sentence with the figures
  double before_mm = 0.0, after_mm = 0.0;  // mean position errors behind it
  bool by_tool_shift = false;              // they are mean tool shifts
  std::string basis{};                     // "50 validation points (G2), not used in the fit"
  std::vector<std::string> to_do{};        // what to do now
  std::vector<std::string> cautions{};     // what limits the result
  std::vector<std::string> not_judged{};   // what could not be judged, and why
};

[[nodiscard]] Verdict verdict(const ReportData& data);

}  // namespace sixdial::report
