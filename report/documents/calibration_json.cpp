#include "report/documents/calibration_json.h"

#include "report/documents/assessment_json.h"
#include "report/documents/budget_json.h"
#include "report/documents/cross_validation_json.h"
#include "report/documents/inputs_json.h"
#include "report/documents/measured_joints_json.h"
#include "report/documents/network_json.h"
#include "report/documents/rig_seen_json.h"
#include "report/documents/set_errors_json.h"
#include "report/documents/stored_residual_json.h"
#include "report/documents/swarm_size_json.h"
#include "report/documents/warnings_json.h"
#include "report/headline.h"
#include "report/words/comparison_words.h"
#include "report/words/conformity_words.h"
#include "studies/method_name.h"

namespace sixdial::report {
namespace {

constexpr const char* kSchema = "sixdial.calibration";

/// "fixed" is a list of true and false, whatever holds them in memory.
template <class Fields, class Flags>
void flags(Fields& at, const char* key, Flags& values) {
  std::vector<bool> list(values.begin(), values.end());
  if constexpr (Fields::kReads) {
    at(key, list);
    if constexpr (requires { values.assign(list.begin(), list.end()); }) {
      values.assign(list.begin(), list.end());
    } else {
      for (std::size_t i = 0; i < values.size() && i < list.size(); ++i) values[i] = list[i];
    }
  } else {
    at(key, list);
  }
}

}  // namespace

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::PipelineSettings>& settings) {
  using calibration::Linearisation;
  using calibration::SearchCoordinates;
  at.named(
      "profile", settings.profile,
      [](calibration::Profile each) { return calibration::to_string(each); },
      calibration::profile_from);
  one_of_two(
      at, "filter_linearised_at", settings.linearisation, Linearisation::kNominal, "nominal",
      Linearisation::kEstimate, "estimate");
  one_of_two(
      at, "search_coordinates", settings.coordinates, SearchCoordinates::kRaw, "raw",
      SearchCoordinates::kWhitened, "whitened");
  at("q", settings.first_noise.q);
  at("r", settings.first_noise.r);
  at("p0", settings.p0);
  at("noise_mm", settings.noise_mm);
  at("qpso1", settings.qpso1);
  at("qpso2", settings.qpso2);
  at.inner("anfis", [&](auto& anfis) {
    describe_kind(anfis, settings.anfis.kind);
    anfis("functions", settings.anfis.functions);
    anfis("epochs", settings.anfis.epochs);
    anfis("ridge", settings.anfis.ridge);
    anfis("target_mse_mm2", settings.anfis.target_mse);
    anfis("cross_validate", settings.cross_validate);
    anfis("holdout_fraction", settings.holdout_fraction);
  });
  flags(at, "fixed", settings.fixed);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::MethodRow>& row) {
  at("id", row.id);
  if constexpr (!Fields::kReads) at("name", studies::method_name(row.id));
  at("g1", row.g1);
  at("g2", row.g2);
  at("seconds", row.seconds);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::StageRow>& row) {
  at("name", row.name);
  at("parameters", row.parameters);
  at("rmse_g1_mm", row.rmse_g1_mm);
  at("seconds", row.seconds);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Convergence>& convergence) {
  at("name", convergence.name);
  at("best_mm", convergence.best_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Trace>& trace) {
  at("name", trace.name);
  at("step", trace.step);
  at("error", trace.error);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Identification>& known) {
  at("sigma_mm", known.sigma_mm);
  at("degrees_of_freedom", known.degrees_of_freedom);
  at("covariance", known.covariance);
  at("singular_values", known.singular_values);
  at("condition", known.condition);
  at("observability", known.observability);
  // Without effect_mm, which the assessment has.
  if constexpr (Fields::kReads) {
    std::vector<Json> held;
    at("held", held);
    for (Json& row : held) {
      if (row.is_object()) row["effect_mm"] = nullptr;
      known.held.push_back(read<studies::HeldRow>(row, kSchema));
    }
  } else {
    std::vector<Json> held;
    for (const studies::HeldRow& each : known.held) {
      held.push_back(write(each));
      held.back().erase("effect_mm");
    }
    at("held", held);
  }
  at("correlations", known.correlations);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::FilterNoise>& noise) {
  at("q", noise.q);
  at("r", noise.r);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Networks>& networks) {
  at("x", networks.x);
  at("y", networks.y);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PointResiduals>& point) {
  at("sample", point.sample);
  at("set", point.set);
  at("point", point.point);
  at("repeat", point.repeat);
  at("measured_mm", point.measured_mm);
  at("residual_mm", point.residual_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::TurnErrors>& errors) {
  at("set", errors.set);
  at("poses", errors.poses);
  at("before_mean_rad", errors.before_mean_rad);
  at("before_max_rad", errors.before_max_rad);
  at("mean_rad", errors.mean_rad);
  at("max_rad", errors.max_rad);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Conformity>& judged) {
  at("tolerance_mm", judged.tolerance_mm);
  at.named("decision", judged.decision, decision_name, decision_from);
  at("set", judged.set);
  at("validated", judged.validated);
  at("points", judged.points);
  at("accepted", judged.accepted);
  at("rejected", judged.rejected);
  at("largest_mm", judged.largest_mm);
  at("expanded_mm", judged.expanded_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CalibrationResult>& result) {
  at.constant("schema", kSchema);
  if constexpr (!Fields::kReads) {
    at("schema_version", result.networks ? kCalibrationSchemaVersion : kAnyMethodSchemaVersion);
  }
  at("created_utc", result.created_utc);
  at.inner("inputs", [&](auto& inputs) {
    describe_keys(inputs, result.inputs);
    inputs("settings", result.settings);
  });
  if constexpr (Fields::kReads) result.settings.seed = result.inputs.seed;
  at("parameters", result.parameters);
  at("identification", result.identification);
  at("methods", result.methods);
  at("result_method", result.result_method);
  one_of_two(
      at, "before_is", result.before_uses_targets, true, before_in_words(true), false,
      before_in_words(false));
  at("rmse_mm", result.rmse_mm);
  at("least_squares_rmse_mm", result.least_squares_rmse_mm);
  at("above_minimum_mm", result.above_minimum_mm);
  at.maybe("noise", result.noise);
  at("not_finite_evaluations", result.not_finite_evaluations);
  at("seconds", result.seconds);
  at("stages", result.stages);
  at("convergence", result.convergence);
  at("traces", result.traces);
  at.maybe("anfis", result.networks);
  at.maybe("residual_model", result.residual_model);
  at("points", result.points);
  at.maybe("assessment", result.assessment);
  if (result.assessment && at.has("precision")) at("precision", result.precision);
  at.maybe("gross_errors", result.gross_errors);
  at.maybe("cross_validation", result.cross_validation);
  at.maybe("conformity", result.conformity);
  at.maybe("uncertainty_budgets", result.uncertainty_budgets);
  at.maybe("rig", result.rig);
  at.maybe("position_noise_mm", result.position_noise_mm);
  at.maybe("turn_errors", result.turn_errors);
  at.maybe("measured_joints", result.measured_joints);
  at.maybe("frame", result.frame);
  at.maybe("warnings", result.warnings);
  // Of a result that nobody has judged no state is known.
  if constexpr (!Fields::kReads) {
    if (result.warnings) at("state", state_name(verdict_of(result).state));
  }
}

Json to_json(const studies::CalibrationResult& result) { return write(result); }

studies::CalibrationResult calibration_from_json(const Json& json) {
  expect_schema(
      json, kSchema, kCalibrationSchemaVersion, kAnyMethodSchemaVersion,
      "Calibrate the session again.");
  return read<studies::CalibrationResult>(json, kSchema);
}

Json settings_json(const calibration::PipelineSettings& settings) { return write(settings); }

}  // namespace sixdial::report
