#include "report/documents/diagnosis_json.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

#include "report/documents/cross_validation_json.h"
#include "report/documents/diagnosis_parts_json.h"
#include "report/documents/gain_json.h"
#include "report/documents/inputs_json.h"
#include "report/documents/measured_joints_json.h"
#include "report/documents/rig_seen_json.h"
#include "report/documents/stored_residual_json.h"
#include "report/documents/warnings_json.h"
#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

using namespace diagnosis_document;
using studies::HypothesisId;

/// Why something is not testable: its code, and what documents without the code say instead
/// (those of version 0.1: their words do not change any more).
struct WhyName {
  diagnosis::WhyNotTestable why;
  std::string_view code, old_words;
};
constexpr std::array kWhys{
    WhyName{diagnosis::WhyNotTestable::kNoDials, "no_dials", "dial columns"},
    WhyName{diagnosis::WhyNotTestable::kNoTemperature, "no_temperature", "temperature_c"},
    WhyName{
        diagnosis::WhyNotTestable::kTemperatureConstant, "temperature_constant",
        "a session whose temperature changes"},
    WhyName{diagnosis::WhyNotTestable::kNoTime, "no_time", "time_utc"},
    WhyName{diagnosis::WhyNotTestable::kNoApproach, "no_approach", "approach1, approach2"},
    WhyName{
        diagnosis::WhyNotTestable::kOneApproach, "one_approach",
        "points approached from both sides"},
    WhyName{
        diagnosis::WhyNotTestable::kAbsorbed, "absorbed",
        "other poses: more working modes, a wider range of joint angles"}};

std::string_view why_name(diagnosis::WhyNotTestable why) {
  const auto* found = std::ranges::find(kWhys, why, &WhyName::why);
  return found == kWhys.end() ? kWhys.back().code : found->code;
}
std::optional<diagnosis::WhyNotTestable> why_by(
    std::string_view WhyName::*name, std::string_view text) {
  const auto* found = std::ranges::find(kWhys, text, name);
  return found == kWhys.end() ? std::nullopt : std::optional(found->why);
}

}  // namespace

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::GrossReading>& gross) {
  at("sample", gross.sample);
  at("set", gross.set);
  at("point", gross.point);
  at("repeat", gross.repeat);
  at("dial", gross.dial);
  at("size_mm", gross.size_mm);
  at("stale", gross.stale);
  at("near_edge", gross.near_edge);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::NoisyDial>& noisy) {
  at("dial", noisy.dial);
  at("sigma_mm", noisy.sigma_mm);
  at("expected_mm", noisy.expected_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::ScatterFound>& scatter) {
  using diagnosis::ScatterIn;
  constexpr std::array kPlaces{
      std::pair{ScatterIn::kTool, "tool"}, std::pair{ScatterIn::kJoints, "joints"},
      std::pair{ScatterIn::kReadings, "readings"}};
  at.named(
      "in", scatter.in,
      [&](ScatterIn in) {
        return std::ranges::find(kPlaces, in, &std::pair<ScatterIn, const char*>::first)
            ->second;
      },
      [&](std::string_view text) -> std::optional<ScatterIn> {
        for (const auto& [in, word] : kPlaces) {
          if (text == word) return in;
        }
        return std::nullopt;
      });
  at("sd_mm", scatter.sd_mm);
  at("low_mm", scatter.low_mm);
  at("high_mm", scatter.high_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Unexplained>& left) {
  at("significant", left.significant);
  at("depends_on", left.depends_on);
  at("rms_mm", left.rms_mm);
  at("scatter", left.scatter);
  at.maybe("scatter_size", left.scatter_size);
  at("noisy_dials", left.noisy_dials);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::Dependence>& each) {
  as_text(
      at, "covariate", each.covariates, joined,
      [](std::string_view text, std::vector<std::string>& covariates) {
        covariates = split(text);
        return !covariates.empty();
      });
  at("enters", each.enters);
  at("log_odds_before", each.log_odds_before);
  at("log_odds_after", each.log_odds_after);
  at("rms_before_mm", each.rms_before_mm);
  at("rms_after_mm", each.rms_after_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Limit>& limit) {
  describe_keys(at, limit.id);
  at("detect", limit.detect);
  at("name", limit.name);
  at("unit", limit.unit);
  at("parameter", limit.parameter);
  as_text(
      at, "rival", limit.rival,
      [](const std::optional<HypothesisId>& rival) {
        return rival ? rival->name() : std::string();
      },
      [](std::string_view text, std::optional<HypothesisId>& rival) {
        rival = id_from(text);
        return rival.has_value() || text.empty();
      });
  at("surviving", limit.surviving);
  at("absorbed_by", limit.absorbed_by);
  at("plausible", limit.plausible);
  if constexpr (!Fields::kReads) {
    const std::string reason = reason_without_limit(limit);
    at("reason", reason.empty() ? std::nullopt : std::optional(reason));
  }
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::JudgedOn>& on) {
  at("samples", on.samples);
  at("fitted_samples", on.fitted_samples);
  at("held_out_by_program", on.held_out_by_program);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::FitSummary>& fit) {
  at("noise_mm", fit.noise_mm);
  at("gross_share", fit.gross_share);
  at("fitted", fit.fitted);
  at("converged", fit.converged);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::FittedEffect>& effect) {
  describe_keys(at, effect.id);
  at("x", effect.x);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ExtendedFit>& fit) {
  at("model", fit.model);
  at("effects", fit.effects);
  at.maybe("residual_model", fit.residual_model);
  at("last_order", fit.last_order);
  at("last_time_h", fit.last_time_h);
  at("last_temperature_c", fit.last_temperature_degC);
  at.maybe("nominal", fit.nominal);
  at.maybe("measured_joints", fit.measured_joints);
  at.maybe("frame", fit.frame);
  at.maybe("covariance", fit.covariance);
  at.maybe("left_sd_mm", fit.left_sd_mm);
  at.maybe("rig", fit.rig);
  at.maybe("turns", fit.turns);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Residuals>& residuals) {
  at("sample", residuals.sample);
  at("dial", residuals.dial);
  at("measured_mm", residuals.measured_mm);
  at("before_mm", residuals.before_mm);
  at("after_mm", residuals.after_mm);
  at("good", residuals.good);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ToolShifts>& shifts) {
  at("sample", shifts.sample);
  at("x_mm", shifts.x_mm);
  at("y_mm", shifts.y_mm);
  at.maybe("z_mm", shifts.z_mm);
  at("before_mm", shifts.before_mm);
  at("after_mm", shifts.after_mm);
}

/// What the search was told, without the keys that say how long it takes.
template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::DiagnosisSettings>& settings) {
  at("null_draws", settings.null_draws);
  at("gain_draws", settings.gain_draws);
  at("with_gain", settings.with_gain);
  at("false_alarm_level", settings.search.false_alarm_level);
  at("tie_log_odds", settings.search.tie_log_odds);
  at("least_log_odds", settings.search.least_log_odds);
  at("unknown_log_odds", settings.search.unknown_log_odds);
  at("name_preference", settings.search.name_preference);
  at("beside_unknown_log_odds", settings.search.beside_unknown_log_odds);
  at("most_causes", settings.search.most_causes);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::Noise>& noise) {
  one_of(
      at, "source", noise.source, diagnosis::NoiseSource::kRepeats, "repeats",
      diagnosis::NoiseSource::kRigFile, "rig_file");
  at("sigma_mm", noise.sigma_mm);
  at("degrees_of_freedom", noise.degrees_of_freedom);
}

namespace {

/// A parameter as one of the two fits has it: the document keeps a list for each.
struct FittedParameter {
  std::string name{}, unit{};
  double nominal = 0.0, value = 0.0, sd = 0.0;
  std::optional<double> moved{}, moved_sigma{};  // of the fit with the causes
};

std::vector<FittedParameter> without_causes(const studies::DiagnosisResult& result) {
  std::vector<FittedParameter> list;
  for (const diagnosis::ParameterChange& each : result.parameters) {
    list.push_back({each.name, each.unit, each.nominal, each.baseline, each.baseline_sd});
  }
  return list;
}

std::vector<FittedParameter> with_causes(const studies::DiagnosisResult& result) {
  std::vector<FittedParameter> list;
  for (const diagnosis::ParameterChange& each : result.parameters) {
    list.push_back(
        {each.name, each.unit, each.nominal, each.extended, each.extended_sd,
         studies::moved(each), studies::moved_sigma(each)});
  }
  return list;
}

Json verdict_json(const studies::DiagnosisResult& result) {
  constexpr std::array kKinds{
      std::pair{studies::VerdictKind::kNamed, "named"},
      std::pair{studies::VerdictKind::kTied, "tied"},
      std::pair{studies::VerdictKind::kUnknown, "unknown"},
      std::pair{studies::VerdictKind::kScatter, "scatter"},
      std::pair{studies::VerdictKind::kNothing, "nothing"}};
  const DiagnosisVerdict verdict = verdict_in_words(result);
  const auto kind = std::ranges::find(
      kKinds, verdict.kind, &std::pair<studies::VerdictKind, const char*>::first);
  return {{"kind", kind->second},         {"title", verdict.title},
          {"headline", verdict.headline}, {"found", texts_of(verdict.found)},
          {"gain", verdict.gain},         {"to_do", texts_of(verdict.to_do)},
          {"trust", verdict.trust},       {"not_judged", verdict.not_judged}};
}

Json not_testable_json(const studies::DiagnosisResult& result) {
  Json list = Json::array();
  for (const studies::NotTestable& each : result.not_testable) {
    const auto [reason, needs] = not_testable_in_words(result, each);
    list.push_back(
        {{"cause", each.id.cause},
         {"where", each.id.where},
         {"why", why_name(each.why)},
         {"reason", reason},
         {"needs", needs},
         {"in_words", named(each.id)}});
  }
  return list;
}

}  // namespace

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::NotTestable>& each) {
  describe_keys(at, each.id);
  const bool has_code = at.has("why");
  at.named(has_code ? "why" : "needs", each.why, why_name, [has_code](std::string_view text) {
    return why_by(has_code ? &WhyName::code : &WhyName::old_words, text);
  });
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, FittedParameter>& parameter) {
  at("name", parameter.name);
  at("unit", parameter.unit);
  at("nominal", parameter.nominal);
  at("value", parameter.value);
  at("sd", parameter.sd);
  if constexpr (!Fields::kReads) {
    at.maybe("moved", parameter.moved);
    at.maybe("moved_sigma", parameter.moved_sigma);
  }
}

/// Both lists of parameters as one.
template <class Fields>
void describe_fits(Fields& at, Of<Fields, studies::DiagnosisResult>& result) {
  std::vector<FittedParameter> before;
  std::vector<FittedParameter> after;
  if constexpr (!Fields::kReads) {
    before = without_causes(result);
    after = with_causes(result);
  }
  at.inner("baseline", [&](auto& fit) {
    describe_keys(fit, result.baseline);
    fit("parameters", before);
  });
  at.inner("extended", [&](auto& fit) {
    describe_keys(fit, result.extended);
    fit("parameters", after);
  });
  if constexpr (Fields::kReads) {
    for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
      result.parameters.push_back(
          {before[i].name, before[i].unit, before[i].nominal, before[i].value, before[i].sd,
           after[i].value, after[i].sd});
    }
  }
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::DiagnosisResult>& result) {
  at.constant("schema", kSchema);
  if constexpr (!Fields::kReads) at("schema_version", kDiagnosisSchemaVersion);
  at("created_utc", result.created_utc);
  at.inner("inputs", [&](auto& inputs) {
    describe_keys(inputs, result.inputs);
    inputs.inner("settings", [&](auto& settings) {
      one_of(settings, "space", result.has_dials, true, "dials", false, "positions");
      describe_keys(settings, result.settings);
    });
  });
  at("causes", result.causes);
  at.inner("noise", [&](auto& noise) {
    describe_keys(noise, result.noise);
    if constexpr (!Fields::kReads) noise("in_words", noise_in_words(result));
  });
  at.inner("unexplained", [&](auto& left) {
    describe_keys(left, result.unexplained);
    if constexpr (!Fields::kReads) left("noise_mm", result.noise.sigma_mm);
  });
  at("dependence", result.dependence);
  at("gross_readings", result.gross_readings);
  at("detection_limits", result.limits);
  describe_fits(at, result);
  at.maybe("rig", result.rig);
  at("gain", result.gain);
  at.maybe("cross_validation", result.cross_validation);
  at("judged_on", result.judged_on);
  at("false_alarm_probability", result.false_alarm_probability);
  at("extended_model", result.extended_fit);
  at("by_covariate", result.left_along);
  at("tool_shift", result.tool_shifts);
  at("residuals", result.residuals);
  at.maybe("warnings", result.warnings);
  at("seconds", result.seconds);
  if constexpr (Fields::kReads) {
    at("not_testable", result.not_testable);
  } else {
    at("not_testable", not_testable_json(result));
    at("verdict", verdict_json(result));
  }
}

Json to_json(const studies::DiagnosisResult& result) { return write(result); }

Json settings_json(const studies::DiagnosisResult& result) {
  return write(result).at("inputs").at("settings");
}

studies::DiagnosisResult diagnosis_from_json(const Json& json) {
  expect_schema(
      json, kSchema, kDiagnosisSchemaVersion, kDiagnosisSchemaVersion,
      "Diagnose the session again.");
  auto result = read<studies::DiagnosisResult>(json, kSchema);
  // Made of the seed that the inputs have.
  result.settings.seed = result.inputs.seed;
  return result;
}

}  // namespace sixdial::report
