#include "report/words/diagnosis_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/thresholds.h"
#include "report/words/diagnosis_words.h"
#include "report/words/rig_words.h"
#include "simulation/effect_words.h"

namespace sixdial::report {
namespace {

using diagnosis::GainModel;
using studies::Certainty;
using studies::DiagnosisResult;
using studies::FoundCause;
using studies::Rival;
using studies::RivalKind;
using studies::Standing;
using studies::VerdictKind;

/// "2.3", "12", "1000".
std::string odds_text(double log_odds) {
  const double odds = std::exp(std::clamp(log_odds, 0.0, 20.0));
  return odds < 10.0 ? fmt::format("{:.1f}", odds) : fmt::format("{:.0f}", odds);
}

std::string found_line(const FoundCause& cause) {
  const std::string size = size_in_words(cause);
  if (cause.is_doubtful() && cause.tied_with.front().log_odds < 0) {
    return fmt::format(
        "Perhaps {}: {}. The points that were not fitted do not show it, though they must if "
        "it has this size.",
        named(cause), size);
  }
  if (cause.is_doubtful()) {
    return fmt::format(
        "Perhaps {}: {}. Too weak to be sure (odds of {} to 1 that there is anything).",
        named(cause), size, odds_text(cause.tied_with.front().log_odds));
  }
  std::string line = capital(named(cause));
  if (!size.empty()) line += ": " + size;
  if (cause.certainty() == Certainty::kTied) {
    std::vector<std::string> rivals;
    for (const Rival& rival : cause.tied_with) {
      rivals.push_back(
          rival.kind == RivalKind::kNothing ? std::string("nothing at all")
          : rival.kind == RivalKind::kUnsettled || rival.kind == RivalKind::kLeftOut
              ? named(rival)
              : fmt::format("{} (odds {} to 1)", named(rival), odds_text(rival.log_odds)));
    }
    line += fmt::format("; these data do not tell it from {}", list_of(rivals, "or"));
  }
  if (cause.is_data_fault()) return line + ".";
  return line + (cause.standing == Standing::kConfirmed ? "; confirmed." : "; suspected.");
}

std::string gain_sentence(const DiagnosisResult& result) {
  const studies::GainRow* calibrated = gain_row(result, GainModel::kCalibrated);
  const studies::GainRow* extended = gain_row(result, GainModel::kExtended);
  if (calibrated == nullptr) return "";
  const std::string where = fmt::format(
      "on {} {} that were not fitted", result.judged_on.samples,
      result.judged_on.held_out_by_program ? "samples set aside by the program"
                                           : "samples of G2");
  const studies::GainRow* network = gain_row(result, GainModel::kCalibrated, true);
  const std::string by_network = network == nullptr
                                     ? std::string()
                                     : fmt::format(
                                           "; a network that learns from the joint angles "
                                           "instead (ANFIS) leaves {}",
                                           millimetres(network->mean_mm));
  if (extended == nullptr || !studies::names_an_effect(result)) {
    return fmt::format(
        "With the robot's parameters alone the mean tool shift {} is {}{}.", where,
        millimetres(calibrated->mean_mm), by_network);
  }
  return fmt::format(
      "The mean tool shift {} falls from {} with the robot's parameters alone to {} with the "
      "causes "
      "(95 % interval of the change: {:+.4f} to {:+.4f} mm){}.",
      where, millimetres(calibrated->mean_mm), millimetres(extended->mean_mm), extended->low_mm,
      extended->high_mm, by_network);
}

/// "dial C that scatters too much".
std::string noisy_dials_in_words(const DiagnosisResult& result) {
  std::vector<std::string> dials;
  for (const diagnosis::NoisyDial& each : result.unexplained.noisy_dials) {
    dials.push_back("dial " + each.dial);
  }
  return fmt::format(
      "{} that {} too much", list_of(dials), dials.size() > 1 ? "scatter" : "scatters");
}

/// "Perhaps backlash of joint 2", "either a or b": a cause in the title.
std::string title_of_cause(const FoundCause& cause) {
  if (cause.is_doubtful()) return "perhaps " + named(cause);
  std::vector<std::string> either{named(cause)};
  for (const Rival& rival : cause.tied_with) either.push_back(named(rival));
  constexpr std::size_t kMost = 2;
  if (either.size() > kMost + 1) {
    const std::size_t more = either.size() - kMost;
    either.resize(kMost);
    either.push_back(fmt::format("one of {} more", more));
  }
  return (either.size() > 1 ? "either " : "") + list_of(either, "or");
}

std::string title_of(const DiagnosisResult& result, VerdictKind kind) {
  std::vector<std::string> names;
  for (const FoundCause& cause : result.causes) {
    if (!cause.is_data_fault()) names.push_back(title_of_cause(cause));
  }
  if (!result.unexplained.noisy_dials.empty()) {
    names.push_back(noisy_dials_in_words(result));
  } else if (kind == VerdictKind::kScatter) {
    names.emplace_back("scatter above the noise");
  }
  if (kind == VerdictKind::kUnknown) {
    names.push_back(
        "something unnamed that depends on " +
        covariates_in_words(result.unexplained.depends_on));
  }
  // What readings went wrong comes last: it says nothing of the robot.
  std::string title = list_of(names);
  for (const FoundCause& cause : result.causes) {
    if (cause.is_data_fault()) title += (title.empty() ? "" : "; ") + named(cause);
  }
  return title.empty() ? "Nothing found" : capital(title);
}

/// "Dial C scatters by 0.0080 mm, where the rig file says 0.0020 mm."
std::string noisy_dials_sentence(const DiagnosisResult& result) {
  std::string said;
  const bool repeats = result.noise.source == diagnosis::NoiseSource::kRepeats;
  for (const diagnosis::NoisyDial& each : result.unexplained.noisy_dials) {
    said += fmt::format(
        " Dial {} scatters by {}, where {} {}.", each.dial, millimetres(each.sigma_mm),
        repeats ? "its repeats say" : "the rig file says", millimetres(each.expected_mm));
  }
  return said;
}

/// "by 5.1 µm (one standard deviation; 95 % interval 4.6 to 5.7 µm)"
std::string by_micrometres(const diagnosis::ScatterFound& scatter) {
  static constexpr double kUmPerMm = 1000.0;
  const auto um = [](double mm) { return simulation::in_digits(kUmPerMm * mm, 2); };
  return fmt::format(
      "by {} µm (one standard deviation; 95 % interval {} to {} µm)", um(scatter.sd_mm),
      um(scatter.low_mm), um(scatter.high_mm));
}

/// Of a robot that works in space there are three axes.
std::string_view in_each_axis(const DiagnosisResult& result) {
  return result.tool_shifts.z_mm ? "in x, in y and in z" : "in x and in y";
}

/// " Each arrival of the robot is off by ...": what scatters, and how much.
std::string scatter_sentence(const DiagnosisResult& result) {
  const auto& scatter = result.unexplained.scatter_size;
  if (!scatter) return "";
  switch (scatter->in) {
    case diagnosis::ScatterIn::kTool:
      return fmt::format(
          " The robot does not come to the same place twice: each arrival is off {} {}, and "
          "all {} of a sample see the same shift.",
          by_micrometres(*scatter), in_each_axis(result),
          result.has_dials ? "dials" : "readings");
    case diagnosis::ScatterIn::kJoints:
      return fmt::format(
          " The joint values that were recorded are not quite where the joints stood: by "
          "chance "
          "from sample to sample, which moves the tool {} {}.",
          by_micrometres(*scatter), in_each_axis(result));
    case diagnosis::ScatterIn::kReadings:
      return fmt::format(
          " Besides the noise each {} scatters by itself {}.",
          result.has_dials ? "reading" : "coordinate", by_micrometres(*scatter));
  }
  return "";
}

std::string remainder_sentence(const DiagnosisResult& result) {
  const studies::Unexplained& left = result.unexplained;
  const std::string rms = millimetres(left.rms_mm);
  const std::string noise = noise_in_words(result);
  if (!(result.noise.sigma_mm > 0.0)) {
    return fmt::format("What is left: {} rms. The noise is {}.", rms, noise);
  }
  if (!left.significant) {
    return fmt::format(
        "What is left ({} rms) is the {} noise ({}).", rms,
        result.has_dials ? "dials'" : "positions'", noise);
  }
  if (left.depends_on.empty() && !left.noisy_dials.empty()) {
    return fmt::format(
        "What is left: {} rms.{}{}", rms, noisy_dials_sentence(result),
        scatter_sentence(result));
  }
  if (left.depends_on.empty()) {
    return fmt::format(
        "What is left ({} rms) scatters more than noise ({}), but does not depend on anything "
        "that was recorded.{}",
        rms, noise, scatter_sentence(result));
  }
  // A rig file may allow more noise than there is.
  const bool more = left.rms_mm > result.noise.sigma_mm;
  return fmt::format(
      "What is left ({} rms) is {} the noise ({}) {} depends on {}; no known cause "
      "explains it.{}{}",
      rms, more ? "more than" : "within", noise, more ? "and" : "but",
      covariates_in_words(result.unexplained.depends_on), noisy_dials_sentence(result),
      scatter_sentence(result));
}

/// What could not be tested, by reason: "a, b and c: the session has no time_utc column."
std::vector<std::string> not_judged(const DiagnosisResult& result) {
  std::map<std::string, std::vector<std::string>> by_reason;
  for (const studies::NotTestable& each : result.not_testable) {
    by_reason[why_not_testable(each.why)].push_back(named(each.id));
  }
  std::vector<std::string> lines;
  for (auto& [reason, names] : by_reason) {
    constexpr std::size_t kMost = 6;
    const std::size_t all = names.size();
    if (all > kMost) {
      names.resize(kMost);
      names.push_back(fmt::format("{} more", all - kMost));
    }
    lines.push_back(capital(fmt::format("{}: {}.", list_of(names), reason)));
  }
  return lines;
}

std::string what_to_do_about(const std::optional<diagnosis::ScatterFound>& scatter) {
  if (scatter && scatter->in == diagnosis::ScatterIn::kTool) {
    return "No model can foretell what differs from arrival to arrival: no command will be "
           "better than that. If the robot's maker states a better repeatability, look for "
           "play, loose screws, vibration and a controller that has not settled when the dials "
           "are read.";
  }
  if (scatter && scatter->in == diagnosis::ScatterIn::kJoints) {
    return "Record joint values that are better than that: the mean of several readings of the "
           "encoders while the robot stands, not one of them.";
  }
  return "Repeat some poses, driving away and back each time: that shows whether the dials "
         "scatter or the robot.";
}

std::vector<Line> to_do(const DiagnosisResult& result, VerdictKind kind) {
  std::vector<Line> lines;
  if (result.warnings && !studies::is_clean(*result.warnings)) {
    lines.push_back(
        {"First settle what is said of the data at the top: all that follows rests on it."});
  }
  for (std::size_t i = 0; i < result.causes.size(); ++i) {
    const FoundCause& cause = result.causes[i];
    const std::string_view advice = texts_of(cause).advice;
    if (advice.empty()) continue;
    const std::string name = capital(named(cause));
    lines.push_back(
        {cause.is_doubtful() ? fmt::format(
                                   "{}: do nothing yet. Measure again, with more points, and "
                                   "see whether it comes "
                                   "back.",
                                   name)
                             : fmt::format("{}: {}", name, advice),
         i});
  }
  const auto& noisy_dials = result.unexplained.noisy_dials;
  if (kind == VerdictKind::kUnknown) {
    lines.push_back({fmt::format(
        "Look for something that changes with {}; the charts of what is left show how. Until "
        "it is "
        "found, a residual model (ANFIS) can make up for what depends on the pose.",
        covariates_in_words(result.unexplained.depends_on, "or"))});
  }
  for (const diagnosis::NoisyDial& each : noisy_dials) {
    lines.push_back({fmt::format(
        "Dial {}: look at its clamping, cable and tip, and whether it moves freely; its "
        "readings count for less here.",
        each.dial)});
  }
  if (kind == VerdictKind::kScatter && noisy_dials.empty()) {
    lines.push_back({what_to_do_about(result.unexplained.scatter_size)});
  }
  const bool rivals = std::ranges::any_of(result.causes, [](const FoundCause& cause) {
    return cause.certainty() == Certainty::kTied && !cause.is_doubtful();
  });
  if (rivals) {
    lines.push_back(
        {"Before repairing anything that these data do not tell apart, measure poses that do: "
         "other "
         "working modes, a wider range of joint angles, both sides of approach."});
  }
  if (lines.empty()) {
    lines.push_back(
        {"Nothing to repair. The limits say how small a cause would have been seen."});
  }
  return lines;
}

/// How likely pure noise would have looked as much like a cause.
std::string chance_sentence(const DiagnosisResult& result) {
  constexpr double kAboutOneDraw = 1.5;
  constexpr double kMillionth = 1e-6;
  const double chance = result.false_alarm_probability;
  const int draws = result.settings.null_draws;
  if (draws > 0 && chance * (draws + 1) < kAboutOneDraw) {
    return fmt::format(
        "None of {} simulated sessions of pure noise looked as much like a cause as this one.",
        draws);
  }
  if (chance < kMillionth) {
    return "Fewer than one in a million sessions with nothing but noise would look as much "
           "like a "
           "cause (by formula, none were simulated).";
  }
  constexpr double kRare = 0.01;
  const std::string share = chance < kRare
                                ? fmt::format("About one in {:.0f}", 1.0 / chance)
                                : fmt::format("About {:.2g} % of the", 100.0 * chance);
  return share + " sessions with nothing but noise would look as much like a cause.";
}

std::vector<std::string> trust(const DiagnosisResult& result) {
  std::vector<std::string> lines;
  // The chance is of the effects' search: readings that are set right are left to it, and
  // curves are not in it.
  const bool physical = std::ranges::any_of(
      result.extended_fit.effects,
      [](const studies::FittedEffect& each) { return !is_curve(each.id); });
  if (physical || result.unexplained.significant) lines.push_back(chance_sentence(result));
  const auto of_standing = [&](Standing standing) {
    std::vector<std::string> names;
    for (const FoundCause& cause : result.causes) {
      if (!cause.is_data_fault() && cause.standing == standing) names.push_back(named(cause));
    }
    return names;
  };
  if (const auto names = of_standing(Standing::kConfirmed); !names.empty()) {
    lines.push_back(capital(fmt::format(
        "{}: confirmed, as the points that were fitted and those that were not both show it.",
        list_of(names))));
  }
  if (const auto names = of_standing(Standing::kSuspected); !names.empty()) {
    lines.push_back(capital(fmt::format(
        "{}: suspected only, {}", list_of(names),
        result.gain.empty()
            ? "as no points were kept back to check it (no gain was computed)."
            : "as either the fitted points or the others alone do not show it clearly, or "
              "something smooth without a name would do as well; measure more before spending "
              "money on it.")));
  }
  if (result.rig) {
    if (std::string rig = rig_in_words(*result.rig); !rig.empty()) {
      lines.push_back(std::move(rig));
    }
  }
  if (const double share = studies::left_out(result); share > diagnosis::kMostLeftOut) {
    lines.push_back(fmt::format(
        "All of this rests on leaving out {:.0f} % of the readings, so nothing of it is "
        "certain: "
        "these readings may say something else.",
        100.0 * share));
  }
  if (!result.unexplained.significant) lines.push_back(remainder_sentence(result));
  return lines;
}

/// Causes first, then what is left, then what readings went wrong.
std::vector<Line> found_lines(const DiagnosisResult& result) {
  std::vector<Line> found;
  for (const bool faults : {false, true}) {
    for (std::size_t i = 0; i < result.causes.size(); ++i) {
      const FoundCause& cause = result.causes[i];
      if (cause.is_data_fault() == faults) found.push_back({found_line(cause), i});
    }
    if (!faults && result.unexplained.significant) {
      found.push_back({remainder_sentence(result)});
    }
  }
  if (found.empty()) {
    found.push_back({"No cause of the catalogue shows itself in this session."});
  }
  return found;
}

}  // namespace

DiagnosisVerdict verdict_in_words(const DiagnosisResult& result) {
  const VerdictKind kind = studies::verdict_kind(result);
  DiagnosisVerdict verdict{
      .kind = kind,
      .title = title_of(result, kind),
      .gain = gain_sentence(result),
      .found = found_lines(result),
      .to_do = to_do(result, kind),
      .trust = trust(result),
      .not_judged = not_judged(result)};
  if (kind == VerdictKind::kNothing) {
    verdict.headline = fmt::format(
        "Nothing was found that the simulation gets wrong. {}", remainder_sentence(result));
  } else {
    for (const Line& line : verdict.found) {
      verdict.headline += (verdict.headline.empty() ? "" : " ") + line.text;
    }
  }
  if (!verdict.gain.empty()) verdict.headline += " " + verdict.gain;
  return verdict;
}

std::vector<std::string> texts_of(const std::vector<Line>& lines) {
  std::vector<std::string> texts;
  for (const Line& line : lines) texts.push_back(line.text);
  return texts;
}

}  // namespace sixdial::report
