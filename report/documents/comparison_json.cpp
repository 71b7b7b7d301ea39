#include "report/documents/comparison_json.h"

#include "report/documents/assessment_json.h"
#include "report/documents/inputs_json.h"
#include "report/documents/rig_seen_json.h"
#include "report/documents/swarm_size_json.h"
#include "report/documents/warnings_json.h"
#include "report/words/comparison_words.h"

namespace sixdial::report {
namespace {

constexpr const char* kSchema = "sixdial.comparison";

std::optional<calibration::FitStatus> fit_status_from(std::string_view text) {
  using enum calibration::FitStatus;
  for (const calibration::FitStatus each : {kConverged, kIterationLimit, kBadStart}) {
    if (calibration::describe(each) == text) return each;
  }
  return std::nullopt;
}

}  // namespace

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ComparisonChoices>& choices) {
  at("space", choices.space);
  at.named(
      "profile", choices.profile,
      [](calibration::Profile each) { return calibration::to_string(each); },
      calibration::profile_from);
  at("loss", choices.loss);
  at("fixed", choices.fixed);
  one_of_two(
      at, "gross_errors", choices.gross_errors_set_aside, true, "set aside", false, "listed");
  at("noise_mm", choices.noise_mm);
  at("hold_uncertainty_mm", choices.hold_uncertainty_mm);
  at("first_variance", choices.first_variance);
  at("qpso1", choices.qpso1);
  at("qpso2", choices.qpso2);
  at("anfis_epochs", choices.anfis_epochs);
  at("bpnn_epochs", choices.bpnn_epochs);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::ErrorStats>& stats) {
  at("mean_mm", stats.mean_mm);
  at("std_mm", stats.std_mm);
  at("max_mm", stats.max_mm);
  at("rmse_mm", stats.rmse_mm);
  at("points", stats.count);
  at("unreachable", stats.unreachable);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ComparedParameter>& parameter) {
  at("value", parameter.value);
  at("sd", parameter.sd);
  at.maybe("partly_held", parameter.partly_held);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ComparedRow>& row) {
  at("id", row.id);
  at("name", row.name);
  at("description", row.description);
  at("identifier", row.identifier);
  at("residual_model", row.residual_model);
  at("g1", row.g1);
  at("g2", row.g2);
  at("g1_errors_mm", row.g1_errors_mm);
  at("g2_errors_mm", row.g2_errors_mm);
  at("identify_seconds", row.identify_seconds);
  at("residual_seconds", row.residual_seconds);
  if constexpr (Fields::kReads) {
    if (row.identifier) row.robot.emplace();
    if (row.residual_model) row.residual.emplace();
  } else {
    at("seconds", row.seconds());
  }
  if (row.robot) {
    at.named(
        "status", row.robot->status,
        [](calibration::FitStatus each) { return calibration::describe(each); },
        fit_status_from);
    at("iterations", row.robot->iterations);
    at("objective_rmse_mm", row.robot->objective_rmse_mm);
    at("parameters", row.robot->parameters);
  }
  if (row.residual) {
    at("note", row.residual->note);
    at("effective_parameters", row.residual->effective_parameters);
  }
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ComparisonResult>& result) {
  at.constant("schema", kSchema);
  if constexpr (!Fields::kReads) at("schema_version", studies::kComparisonSchemaVersion);
  at("created_utc", result.created_utc);
  at.inner("inputs", [&](auto& inputs) {
    describe_keys(inputs, result.inputs);
    inputs("settings", result.choices);
  });
  one_of_two(
      at, "before_is", result.before_uses_targets, true, before_in_words(true), false,
      before_in_words(false));
  at("methods", result.methods);
  at("best", result.best);
  at("least_squares_rmse_mm", result.least_squares_rmse_mm);
  at.maybe("rig", result.rig);
  at("assessment", result.assessment);
  at("precision", result.precision);
  at("gross_errors", result.gross_errors);
  at.maybe("warnings", result.warnings);
  at("seconds", result.seconds);
}

Json to_json(const studies::ComparisonResult& result) { return write(result); }

studies::ComparisonResult comparison_from_json(const Json& json) {
  expect_schema(
      json, kSchema, studies::kComparisonSchemaVersion, studies::kComparisonSchemaVersion,
      "Compare the methods again: sixdial compare.");
  return read<studies::ComparisonResult>(json, kSchema);
}

}  // namespace sixdial::report
