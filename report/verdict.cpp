#include "report/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "report/text.h"
#include "report/words/conformity_words.h"
#include "report/words/warning_words.h"

namespace sixdial::report {
namespace {

constexpr std::pair<CalibrationState, std::string_view> kStates[] = {
    {CalibrationState::kUnknown, "unknown"},
    {CalibrationState::kCalibrated, "calibrated"},
    {CalibrationState::kImproved, "improved"},
    {CalibrationState::kNotImproved, "not_improved"},
    {CalibrationState::kNotValidated, "not_validated"},
    {CalibrationState::kNotCalibrated, "not_calibrated"}};

constexpr double kClearGain = 2.0;   // before / after from which "calibrated" is said
constexpr double kNoChange = 0.05;   // relative: a residual model that changes less is neutral
constexpr double kOverfit = 1.5;     // G2 over G1 from which the fit is called too close
constexpr double kAtTheNoise = 1.5;  // error over noise up to which only noise is left
constexpr double kFarFromNoise =
    25.0;  // over the noise: no robot is like that, something is wrong
constexpr double kAtTheMinimum_mm = 1e-5;  // the accuracy asked of QPSO-2 (issue 2, part 7)
constexpr double kPoorCondition = 1000.0;

std::string times(double factor) {
  return fmt::format("{} times", fixed(factor, factor < 10.0 ? 1 : 0));
}

struct Compared {
  const ShownMethod* before = nullptr;
  const ShownMethod* result = nullptr;
  const ShownMethod* kinematic = nullptr;  // the last one without a residual model
  bool on_g2 = false;
  [[nodiscard]] const ErrorStatistics& of(const ShownMethod& m) const {
    return on_g2 ? *m.g2 : *m.g1;
  }
  [[nodiscard]] bool has(const ShownMethod& m) const {
    return (on_g2 ? m.g2 : m.g1).has_value();
  }
};

Compared compared(const ReportData& data) {
  Compared out;
  const auto index = result_index(data);
  if (!index || *index == 0) return out;
  const ShownMethod& before = data.methods.front();
  const ShownMethod& result = data.methods[*index];
  out.on_g2 = before.g2 && result.g2;
  if (!out.on_g2 && !(before.g1 && result.g1)) return out;
  out.before = &before;
  out.result = &result;
  for (std::size_t i = 1; i < *index; ++i) {
    if (!data.methods[i].has_residual_model && out.has(data.methods[i])) {
      out.kinematic = &data.methods[i];
    }
  }
  return out;
}

/// Also where the noise is not known: then nothing speaks against it.
bool is_at_the_noise(const ReportData& data, double after_mm) {
  return !data.position_noise_mm || !(*data.position_noise_mm > 0.0) ||
         after_mm <= kAtTheNoise * *data.position_noise_mm;
}

bool is_far_from_noise(const ReportData& data, double after_mm) {
  return data.position_noise_mm && *data.position_noise_mm > 0.0 &&
         after_mm > kFarFromNoise * *data.position_noise_mm;
}

/// "50 targets, commanded again and measured (session demo.validation); predicted were 3.0 µm".
std::string basis_of_measured(const Headline& headline) {
  std::string basis = fmt::format(
      "{}, commanded again and measured (session {})",
      counted(headline.after.points, "target", "targets"), headline.measured_in.value());
  if (headline.predicted_mm && std::isfinite(*headline.predicted_mm)) {
    basis += fmt::format(
        "; predicted were {}, reached are {}", length(*headline.predicted_mm),
        length(headline.after.mean_mm));
  }
  return basis;
}

void judge(const ReportData& data, const Compared& c, Verdict& out) {
  const ErrorStatistics& before = data.headline ? data.headline->before : c.of(*c.before);
  const ErrorStatistics& after = data.headline ? data.headline->after : c.of(*c.result);
  out.before_mm = before.mean_mm;
  out.after_mm = after.mean_mm;
  out.basis = fmt::format(
      "{} ({}), {}",
      c.on_g2 ? counted(after.points, "validation point", "validation points")
              : counted(after.points, "calibration point", "calibration points"),
      c.on_g2 ? "G2" : "G1", c.on_g2 ? "not used in the fit" : "the ones that were fitted");
  out.by_tool_shift = data.headline && data.headline->by_tool_shift;
  if (data.measured_again) out.basis = basis_of_measured(*data.headline);
  const double factor = after.mean_mm > 0.0 ? before.mean_mm / after.mean_mm : HUGE_VAL;
  const std::string missed = fmt::format(
      "The robot missed its positions by {} on average and {} at worst", length(before.mean_mm),
      length(before.max_mm));
  const std::string_view now =
      data.measured_again ? "Commanded by the recommended model and measured again, it misses"
      : data.headline     ? "With the recommended model the remaining error is"
                          : "With the result of this calibration the remaining error is";
  if (!(factor > 1.0)) {
    out.state = CalibrationState::kNotImproved;
    out.title = "Not improved";
    out.headline = fmt::format(
        "{}. {} {} on average: the calibration does not help.", missed, now,
        length(after.mean_mm));
    out.to_do.emplace_back(
        "Do not use the result. Check the rig file, the dials' order and the joint angles' "
        "signs first.");
    return;
  }
  out.state = !c.on_g2               ? CalibrationState::kNotValidated
              : factor >= kClearGain ? CalibrationState::kCalibrated
                                     : CalibrationState::kImproved;
  if (is_far_from_noise(data, after.mean_mm)) {
    out.state = CalibrationState::kNotImproved;
    out.title = "Not calibrated: something is wrong";
    out.headline = fmt::format(
        "{}. {} still {} on average and {} at worst, {} what the dials can tell ({}). A robot "
        "that only needs new parameters does not look like that.",
        missed, now, length(after.mean_mm), length(after.max_mm),
        times(after.mean_mm / *data.position_noise_mm), length(*data.position_noise_mm));
    out.to_do.emplace_back(
        "Do not use the result. Check first that no two dials are exchanged, that each stands "
        "where the rig file says, and the signs and zeros of the joint angles.");
    return;
  }
  out.title = out.state == CalibrationState::kNotValidated ? "Fitted, not validated"
              : out.state == CalibrationState::kCalibrated ? "Calibrated"
                                                           : "Slightly improved";
  out.headline = fmt::format(
      "{}. {} {} on average and {} at worst, {}.", missed, now, length(after.mean_mm),
      length(after.max_mm),
      std::isfinite(factor) ? fmt::format("{} less", times(factor)) : "nothing");
}

void advise(const ReportData& data, const Compared& c, Verdict& out) {
  if (out.state == CalibrationState::kNotImproved) return;
  if (!data.first_to_do.empty()) {
    out.to_do.insert(out.to_do.end(), data.first_to_do.begin(), data.first_to_do.end());
    return;
  }
  out.to_do.emplace_back("Enter the identified parameters in the controller.");
  if (c.result->has_residual_model && c.kinematic != nullptr) {
    const double without = c.of(*c.kinematic).mean_mm;
    const double with = out.after_mm;
    if (with > without * (1.0 + kNoChange)) {
      out.cautions.push_back(fmt::format(
          "The residual model makes these points worse: {} with it, {} with the parameters "
          "alone. Use the parameters alone.",
          length(with), length(without)));
    } else if (with > without * (1.0 - kNoChange)) {
      out.cautions.push_back(fmt::format(
          "The residual model makes no difference here ({} with it, {} without): {}.",
          length(with), length(without),
          is_at_the_noise(data, with)
              ? "the parameters already explain all but the noise"
              : "what is left does not depend on the joint angles alone"));
    } else {
      out.to_do.push_back(fmt::format(
          "Use the residual model on top, inside the measured area only: the parameters alone "
          "leave {}.",
          length(without)));
    }
  }
  if (!data.measured_again) {
    out.to_do.emplace_back(
        "Confirm on the robot: command compensated angles and measure again. The figures here "
        "compare measured with modelled positions.");
  }
}

void limit(const ReportData& data, const Compared& c, Verdict& out) {
  if (data.position_noise_mm && *data.position_noise_mm > 0.0) {
    const double noise = *data.position_noise_mm;
    if (out.after_mm <= kAtTheNoise * noise) {
      out.cautions.push_back(fmt::format(
          "What remains ({} on average) is as small as the noise of the "
          "measured "
          "positions ({}, k = 1): this rig cannot show more.",
          length(out.after_mm), length(noise)));
    } else {
      out.cautions.push_back(fmt::format(
          "What remains ({} on average) is {} the noise of the measured "
          "positions ({}, k = 1): there is an error left that this model does not contain.",
          length(out.after_mm), times(out.after_mm / noise), length(noise)));
    }
  }
  if (c.result->g1 && c.result->g2 &&
      c.result->g2->mean_mm > kOverfit * c.result->g1->mean_mm) {
    out.cautions.push_back(fmt::format(
        "The mean error is {} on the fitted points and {} on the others: the fit follows its "
        "own "
        "points too closely. Rely on the second figure.",
        length(c.result->g1->mean_mm), length(c.result->g2->mean_mm)));
  }
}

void question(const ReportData& data, Verdict& out) {
  if (data.rmse_mm && data.least_squares_rmse_mm) {
    const double above = *data.rmse_mm - *data.least_squares_rmse_mm;
    if (above > kAtTheMinimum_mm) {
      out.cautions.push_back(fmt::format(
          "The identification stopped {} above the least-squares minimum of the same "
          "objective: the parameters can still be improved.",
          length(above)));
    }
  }
  if (const std::string words = stand_out_in_words(data.facts.stand_out); !words.empty()) {
    out.cautions.push_back(words + " Look at the list before you trust the largest errors.");
  }
  out.not_judged.insert(out.not_judged.end(), data.not_judged.begin(), data.not_judged.end());
  for (const std::string& direction : data.unidentifiable) {
    out.not_judged.push_back(fmt::format("These poses cannot tell apart: {}.", direction));
  }
  if (data.condition_number && *data.condition_number > kPoorCondition) {
    out.not_judged.push_back(fmt::format(
        "These poses determine the parameters badly (condition number {}): single parameters "
        "are "
        "uncertain, see their U.",
        fixed(*data.condition_number, 0)));
  }
  if (const int lost = points_without_position(data); lost > 0) {
    out.not_judged.push_back(fmt::format(
        "{} of {} gave no position, as fewer than three dials touched; they are kept, but not "
        "compared.",
        lost, counted(data.samples, "sample", "samples")));
  }
  if (!data.rejected.empty()) {
    out.not_judged.push_back(fmt::format(
        "{} left out of the data file as unreadable; see the list.",
        counted(static_cast<long long>(data.rejected.size()), "row was", "rows were")));
  }
}

/// Larger than the noise: an error is left that the model does not contain.
bool has_structure(const ReportData& data, const Verdict& v) {
  return !is_at_the_noise(data, v.after_mm) || data.cause_remains;
}

void decide(const ReportData& data, Verdict& out) {
  if (out.state == CalibrationState::kUnknown) return;
  const bool usable = out.state == CalibrationState::kCalibrated ||
                      out.state == CalibrationState::kImproved ||
                      out.state == CalibrationState::kNotValidated;
  out.mood = Mood::kBad;
  if (!usable) return;
  out.decision = conformity_in_words(data.conformity);
  out.title += ", " + conformity_title(data.conformity);
  if (data.conformity && data.conformity->decision == studies::Decision::kRejected) return;
  out.mood = Mood::kOpen;
  if (has_structure(data, out) || out.state == CalibrationState::kNotValidated) return;
  if (!data.conformity) {
    out.mood = Mood::kPlain;
  } else if (data.conformity->decision == studies::Decision::kAccepted) {
    out.mood = Mood::kGood;
  }
}

/// The figures are those of the result, and nobody has looked whether its data are plausible.
void leave_open(Verdict& out) {
  out.state = CalibrationState::kUnknown;
  out.title = "Not judged";
  out.headline +=
      " This result is of an earlier version, which did not look whether the data are "
      "plausible.";
  out.to_do = {"Calibrate this session again before you use the result."};
  out.cautions.clear();
}

/// A session that contradicts itself calibrates nothing, whatever its figures say.
void doubt(const ReportData& data, Verdict& out) {
  const auto first = std::ranges::find_if(data.warnings, [](const studies::Warning& each) {
    return each.severity != studies::Severity::kNote;
  });
  if (first == data.warnings.end()) {
    if (!data.plausibility_judged) leave_open(out);
    return;
  }
  out.state = CalibrationState::kNotCalibrated;
  out.title = first->code == studies::kTooFewPoses
                  ? "Not calibrated: too few different poses"
                  : "Not calibrated: the data are not plausible";
  out.headline = warning_text(*first);
  out.to_do = {
      "Do not use the result. Settle what is listed as not plausible first, then calibrate "
      "again."};
  out.cautions.clear();
  out.decision.clear();
}

}  // namespace

std::string_view mood_name(Mood mood) {
  switch (mood) {
    case Mood::kPlain:
      return "plain";
    case Mood::kGood:
      return "good";
    case Mood::kOpen:
      return "open";
    case Mood::kBad:
      return "bad";
  }
  return "open";
}

std::string_view state_name(CalibrationState state) {
  const auto found =
      std::ranges::find(kStates, state, &std::pair<CalibrationState, std::string_view>::first);
  return found == std::end(kStates) ? "unknown" : found->second;
}

CalibrationState state_from(std::string_view name) {
  const auto found =
      std::ranges::find(kStates, name, &std::pair<CalibrationState, std::string_view>::second);
  return found == std::end(kStates) ? CalibrationState::kUnknown : found->first;
}

Verdict verdict(const ReportData& data) {
  Verdict out;
  const Compared c = compared(data);
  if (c.result == nullptr) {
    out.title = "Not calibrated";
    out.headline =
        "This session has no calibration result yet, so there is nothing to compare with.";
    out.to_do.emplace_back("Run a calibration of this session and make the report again.");
  } else {
    judge(data, c, out);
    for (const std::string& more : data.headline_more) out.headline += " " + more;
    advise(data, c, out);
    limit(data, c, out);
    doubt(data, out);
    if (!c.on_g2) {
      out.not_judged.emplace_back(
          "There are no validation points (G2), so nobody knows how accurate the robot is away "
          "from "
          "the fitted points. Measure some.");
    }
  }
  decide(data, out);
  out.to_do.insert(out.to_do.end(), data.to_do.begin(), data.to_do.end());
  question(data, out);
  return out;
}

}  // namespace sixdial::report
