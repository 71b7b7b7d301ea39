#include "report/words/diagnosis_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/covariate.h"
#include "geometry/units.h"
#include "simulation/effect.h"
#include "simulation/effect_words.h"

namespace sixdial::report {
namespace {

using diagnosis::Estimate;
using diagnosis::WhyNotTestable;
using studies::CauseKind;
using studies::FoundCause;
using studies::HypothesisId;

/// What is no effect of the catalogue: its words stand here.
struct WordsOfKind {
  CauseKind kind;
  std::string_view in_words;
  CauseTexts texts;
};

const WordsOfKind* words_of_kind(CauseKind kind) {
  static const std::array kWords{
      WordsOfKind{
          CauseKind::kRigGeometry,
          "the rig's own geometry",
          {.signature =
               "The readings of several dials contradict where the rig file says that the "
               "dials stand, how they lean, or what the cuboid measures.",
           .consequence =
               "None on parts. Positions that are computed from the dials are off, and so are "
               "lengths that are fitted to them.",
           .advice =
               "Measure the places and axes of the dials again, those first that the table of "
               "the rig has at its top, and enter them. Then write into the rig file how well "
               "each is known (position_sd_mm, axis_sd_deg): what is known to a tenth of a "
               "millimetre is not known exactly."}},
      WordsOfKind{
          CauseKind::kOutliers,
          "gross reading errors",
          {.signature =
               "Single readings that are far from everything else; their neighbours are not.",
           .consequence =
               "None on parts, as they are not fitted; if they were, they would pull the "
               "parameters.",
           .advice =
               "Nothing, if they are few. Else look at the dials in the list: cable, battery, "
               "dirt on the face, a tip that leaves the face at its edge."}},
      WordsOfKind{
          CauseKind::kStaleReadings,
          "readings handed over twice",
          {.signature =
               "A reading is the same, digit for digit, as at the sample before, though the "
               "tool had moved.",
           .consequence = "None on parts, as they are not fitted.",
           .advice =
               "Let the dial's connection ask for a new value at each sample; look at its time "
               "stamps and time-outs."}}};
  const auto* found = std::ranges::find(kWords, kind, &WordsOfKind::kind);
  return found == kWords.end() ? nullptr : found;
}

std::string rig_size(const FoundCause& cause) {
  if (cause.estimate.empty()) return "nothing by much, many things by a little";
  std::vector<std::string> moved;
  for (const Estimate& each : cause.estimate) {
    moved.push_back(
        fmt::format("{} {}", each.name, quantity_in_words(each.value, each.sd, each.unit)));
  }
  return list_of(moved) + " from what the file says";
}

std::string data_fault_size(const FoundCause& cause) {
  const auto count = static_cast<int>(cause.estimate.at(0).value);
  return fmt::format(
      "{} {}, {:.3f} mm rms", count, count == 1 ? "reading" : "readings",
      cause.estimate.at(1).value);
}

}  // namespace

std::string named(const HypothesisId& id) {
  const simulation::Effect* effect = simulation::find_effect(id.cause);
  return effect != nullptr ? simulation::in_words_at(*effect, id.where) : id.cause;
}

bool is_curve(const HypothesisId& id) {
  const simulation::Effect* effect = simulation::find_effect(id.cause);
  return effect != nullptr && effect->is_curve;
}

std::string kind_in_words(CauseKind kind) {
  const WordsOfKind* words = words_of_kind(kind);
  return words != nullptr ? std::string(words->in_words) : "";
}

std::string named(const FoundCause& cause) {
  const WordsOfKind* fault = words_of_kind(cause.kind);
  return fault != nullptr ? std::string(fault->in_words) : named(cause.id);
}

std::string named(const studies::Rival& rival) {
  switch (rival.kind) {
    case studies::RivalKind::kUnknown:
      return "something unnamed that depends on " + covariates_in_words(rival.depends_on);
    case studies::RivalKind::kNothing:
      return "nothing";
    case studies::RivalKind::kLeftOut:
      return "what the readings say that had to be left out";
    case studies::RivalKind::kUnsettled:
      return "another answer, as the fit had not settled yet";
    case studies::RivalKind::kEffect:
      break;
  }
  return named(rival.id);
}

CauseTexts texts_of(const FoundCause& cause) {
  if (const WordsOfKind* fault = words_of_kind(cause.kind)) return fault->texts;
  const simulation::Effect* effect = simulation::find_effect(cause.id.cause);
  if (effect == nullptr) return {};  // of another version of this program
  return {effect->signature, effect->consequence, effect->advice, effect->why_not_learned};
}

std::string quantity_in_words(double value, double sd, std::string_view unit) {
  return simulation::quantity_in_words(value, sd, unit);
}

std::string size_in_words(const FoundCause& cause) {
  if (cause.estimate.empty() && cause.kind == CauseKind::kEffect) return "";
  if (cause.is_data_fault()) return data_fault_size(cause);
  if (cause.kind == CauseKind::kRigGeometry) return rig_size(cause);
  const simulation::Effect* effect = simulation::find_effect(cause.id.cause);
  static const simulation::Effect kUnknownToThisProgram{};
  std::vector<simulation::FoundParameter> found;
  for (const Estimate& each : cause.estimate) {
    found.push_back({each.name, each.value, each.sd, each.unit});
  }
  return simulation::size_in_words(effect != nullptr ? *effect : kUnknownToThisProgram, found);
}

std::string remark_on_gross(const studies::GrossReading& reading) {
  if (reading.stale) return "the same as at the sample before";
  return reading.near_edge ? "touches at the edge of the face" : "";
}

std::string millimetres(double value_mm) {
  return std::isfinite(value_mm) ? fmt::format("{:.4f} mm", value_mm) : "-";
}

std::string noise_in_words(const studies::DiagnosisResult& result) {
  const diagnosis::Noise& noise = result.noise;
  if (!(noise.sigma_mm > 0.0)) {
    return "not known: the positions came without an uncertainty, and there are too few "
           "repeats";
  }
  if (noise.source == diagnosis::NoiseSource::kRepeats) {
    return fmt::format(
        "{:.4f} mm (k = 1), measured by repeats with {} degrees of freedom", noise.sigma_mm,
        noise.degrees_of_freedom);
  }
  return fmt::format(
      "{:.4f} mm (k = 1), by the {}, as this session has too few repeats to measure it",
      noise.sigma_mm,
      result.has_dials ? "rig file's repeatability and resolution"
                       : "uncertainty of the positions");
}

std::string gain_row_in_words(const studies::GainRow& row) {
  const auto model = [&]() -> std::string {
    switch (row.model) {
      case diagnosis::GainModel::kNominal:
        return "nominal parameters";
      case diagnosis::GainModel::kCalibrated:
        return "robot alone";
      case diagnosis::GainModel::kExtended:
        return "with the causes";
      case diagnosis::GainModel::kWithout:
        break;
    }
    return row.without ? "without " + named(*row.without) : std::string("without one");
  };
  return row.network ? model() + " + ANFIS" : model();
}

std::string gain_row_name(const studies::GainRow& row) {
  const auto model = [&]() -> std::string {
    switch (row.model) {
      case diagnosis::GainModel::kNominal:
        return "nominal";
      case diagnosis::GainModel::kCalibrated:
        return "calibrated";
      case diagnosis::GainModel::kExtended:
        return "extended";
      case diagnosis::GainModel::kWithout:
        break;
    }
    return "without " + (row.without ? row.without->name() : std::string());
  };
  return row.network ? model() + " + ANFIS" : model();
}

std::string covariate_in_words(const std::string& covariate) {
  using diagnosis::DependsOn;
  const auto known = diagnosis::dependence_from(covariate);
  if (!known) return covariate;  // of another version of this program
  switch (known->on) {
    case DependsOn::kJointAngle:
      return fmt::format("the value of joint {}", known->joint + 1);
    case DependsOn::kReading:
      return "the reading of dial " + known->dial;
    case DependsOn::kCuboidAngle:
      return "the cuboid's angle";
    case DependsOn::kApproach:
      return fmt::format("the side that joint {} arrives from", known->joint + 1);
    default:
      return covariate;
  }
}

std::string covariates_in_words(
    const std::vector<std::string>& covariates, std::string_view last) {
  std::vector<std::string> names;
  constexpr std::size_t kFew = 3;  // the likeliest come first
  const std::size_t named = covariates.size() > kFew + 1 ? kFew : covariates.size();
  for (std::size_t i = 0; i < named; ++i) names.push_back(covariate_in_words(covariates[i]));
  if (named == covariates.size()) return list_of(names, last);
  names.push_back(fmt::format("one of {} other quantities", covariates.size() - named));
  return list_of(names, "or");
}

std::string why_not_testable(WhyNotTestable why) {
  switch (why) {
    case WhyNotTestable::kNoDials:
      return "needs raw dial readings; this session has positions only";
    case WhyNotTestable::kNoTemperature:
      return "the session has no temperature_c column";
    case WhyNotTestable::kTemperatureConstant:
      return "the temperature did not change";
    case WhyNotTestable::kNoTime:
      return "the session has no time_utc column";
    case WhyNotTestable::kNoApproach:
      return "the session has no approach column for this joint";
    case WhyNotTestable::kOneApproach:
      return "the joint always arrived from the same side";
    case WhyNotTestable::kAbsorbed:
      break;
  }
  return "on these poses the fitted parameters of the robot do the same";
}

NotTestableWords not_testable_in_words(
    const studies::DiagnosisResult& result, const studies::NotTestable& each) {
  std::string reason = why_not_testable(each.why);
  switch (each.why) {
    case WhyNotTestable::kNoDials:
      return {std::move(reason), "dial columns"};
    case WhyNotTestable::kNoTemperature:
      return {std::move(reason), "temperature_c"};
    case WhyNotTestable::kTemperatureConstant:
      return {std::move(reason), "a session whose temperature changes"};
    case WhyNotTestable::kNoTime:
      return {std::move(reason), "time_utc"};
    case WhyNotTestable::kNoApproach:
      return {std::move(reason), "approach1, approach2"};
    case WhyNotTestable::kOneApproach:
      return {std::move(reason), "points approached from both sides"};
    case WhyNotTestable::kAbsorbed:
      break;
  }
  if (const studies::Limit* limit = studies::limit_of(result, each.id)) {
    constexpr double kPercent = 100.0;
    constexpr double kLeastShown = 0.1;
    const double left =
        std::max(kLeastShown, std::round(10.0 * kPercent * limit->surviving) / 10.0);
    reason = fmt::format(
        "on these poses the fitted parameters ({}) imitate all but {} % of it",
        fmt::join(limit->absorbed_by, ", "), fmt::format("{:f}", left).substr(0, 4));
  }
  return {std::move(reason), "other poses: more working modes, a wider range of joint angles"};
}

bool is_beyond_plausible(const studies::Limit& limit, double size) {
  constexpr double kMostTimes = 50.0;  // the text beside the table says so, too
  return limit.plausible > 0.0 && size > kMostTimes * limit.plausible;
}

std::string reason_without_limit(const studies::Limit& limit) {
  if (!std::isfinite(limit.detect)) {
    return fmt::format(
        "at no size: {} imitate it on these poses", fmt::join(limit.absorbed_by, ", "));
  }
  if (std::isfinite(limit.name)) return "";
  return fmt::format(
      "seen, but on these poses not told from {} at any size",
      limit.rival ? limit.rival->name() : std::string());
}

std::string list_of(const std::vector<std::string>& items, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? fmt::format(" {} ", last) : ", ";
    text += items[i];
  }
  return text;
}

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

}  // namespace sixdial::report
