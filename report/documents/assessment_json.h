// "assessment", "precision" and "gross_errors" of a calibration's and a comparison's document.
#pragma once

#include "report/documents/fields.h"
#include "studies/assessment.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ParameterRow>& row) {
  at("name", row.name);
  at("unit", row.unit);
  at("nominal", row.nominal);
  at("identified", row.identified);
  at("sd", row.sd);
  at("low_95", row.low_95);
  at("high_95", row.high_95);
  at("fixed", row.fixed);
  at("partly_held", row.partly_held);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CorrelationRow>& row) {
  at("first", row.first);
  at("second", row.second);
  at("coefficient", row.coefficient);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::WorkingModeRow>& row) {
  at.named(
      "mode", row.mode, [](const geometry::WorkingMode& mode) { return to_string(mode); },
      geometry::working_mode_from);
  at("samples", row.samples);
  at("condition", row.condition);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::RepeatNoise>& noise) {
  at("sigma_mm", noise.sigma_mm);
  at("degrees_of_freedom", noise.degrees_of_freedom);
}

[[nodiscard]] inline std::optional<calibration::NoiseSource> noise_source_from(
    std::string_view text) {
  using enum calibration::NoiseSource;
  for (const calibration::NoiseSource each : {kRepeats, kResidual, kRigFile, kAssumed}) {
    if (calibration::to_string(each) == text) return each;
  }
  return std::nullopt;
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::NoiseEstimate>& noise) {
  at.named(
      "source", noise.source,
      [](calibration::NoiseSource source) { return calibration::to_string(source); },
      noise_source_from);
  at("sigma_mm", noise.sigma_mm);
  at("degrees_of_freedom", noise.degrees_of_freedom);
  at("repeats", noise.repeats);
  at("residual", noise.residual);
  at("rig_file_mm", noise.rig_file_mm);
  at("lack_of_fit", noise.lack_of_fit);
  // Early results know neither these nor structure, and are written as they were.
  if (Fields::kReads ? at.has("spread_mm") : noise.spread_mm > 0.0) {
    at("over_rig_file", noise.over_rig_file);
    at("spread_mm", noise.spread_mm);
    at("spread_freedom", noise.spread_freedom);
    at("known", noise.known);
  }
  at("words", noise.words);
}

[[nodiscard]] inline std::optional<calibration::SmoothOver> structure_over_from(
    std::string_view text) {
  using enum calibration::SmoothOver;
  for (const calibration::SmoothOver each : {kJoints, kOrder}) {
    if (calibration::to_string(each) == text) return each;
  }
  return std::nullopt;
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::Structure>& structure) {
  at.named(
      "over", structure.over,
      [](calibration::SmoothOver over) { return calibration::to_string(over); },
      structure_over_from);
  at("sd_mm", structure.sd_mm);
  at("length", structure.length);
  at("noise_mm", structure.noise_mm);
  at("log_gain", structure.log_gain);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PositionMap>& map) {
  at("x_mm", map.x_mm);
  at("y_mm", map.y_mm);
  at("sd_x_mm", map.sd_x_mm);
  at("sd_y_mm", map.sd_y_mm);
  at("radius_95_mm", map.radius_95_mm);
  at("mean_sd_mm", map.mean_sd_mm);
  at("max_sd_mm", map.max_sd_mm);
  at("max_radius_95_mm", map.max_radius_95_mm);
  at("worst_mm", map.worst_mm);
}

/// Of an assessment; "held" of the identification has no effect_mm.
template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::HeldRow>& row) {
  at("words", row.words);
  at("direction", row.direction);
  at("singular_value", row.singular_value);
  at("effect_mm", row.effect_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::IdentifiabilityRow>& row) {
  at("singular_values", row.singular_values);
  at("condition", row.condition);
  at("condition_determined", row.condition_determined);
  at("observability", row.observability);
  at("free", row.free);
  at("determined", row.determined);
  at("held", row.held);
  at("correlations", row.correlations);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Assessment>& assessment) {
  at("space", assessment.space);
  at("samples", assessment.samples);
  at("readings", assessment.readings);
  at("noise", assessment.noise);
  if (Fields::kReads ? at.has("structure") : assessment.noise.spread_mm > 0.0) {
    at("structure", assessment.structure);
  }
  at("parameters", assessment.parameters);
  // Results of early versions know one working mode only.
  if (at.has("working_modes")) at("working_modes", assessment.working_modes);
  at("identifiability", assessment.identifiability);
  at("position_uncertainty", assessment.position_uncertainty);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Precision::Row>& row) {
  at("name", row.name);
  at("unit", row.unit);
  at("positions_sd", row.positions_sd);
  at("dials_sd", row.dials_sd);
  at("ratio", row.ratio);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Precision>& precision) {
  at("parameters", precision.parameters);
  at("geometric_mean_ratio", precision.geometric_mean_ratio);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::GrossErrors::Found>& found) {
  at("sample", found.sample);
  at("set", found.set);
  at("point", found.point);
  at("repeat", found.repeat);
  at("line", found.line);
  at("dial", found.dial);
  at("reading_mm", found.reading_mm);
  at("size_mm", found.size_mm);
  at("times_sigma", found.times_sigma);
  at.named(
      "treatment", found.treatment,
      [](studies::Treatment treatment) { return studies::to_string(treatment); },
      studies::treatment_from);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::GrossErrors>& errors) {
  at("found", errors.found);
  at("readings", errors.readings);
  at("sigma_mm", errors.sigma_mm);
  at("limit_times_sigma", errors.limit_times_sigma);
  at("set_aside", errors.set_aside);
  at.inner("systematic", [&](auto& systematic) {
    systematic("g1", errors.systematic_g1);
    systematic("g2", errors.systematic_g2);
  });
  at("not_possible", errors.not_possible);
}

}  // namespace sixdial::report
