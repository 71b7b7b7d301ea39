// A trained ANFIS in a calibration's document. What is read gives the same output as what was
// written, bit for bit.
//
//   const Json json = write(report);  // a calibration::AnfisReport
//   const auto again = read<calibration::AnfisReport>(json, "network");
#pragma once

#include "calibration/anfis_learning.h"
#include "report/documents/fields.h"

namespace sixdial::report {

/// Throws studies::StudyError bad_data that names the matrix which does not fit the others.
void check_network(const calibration::AnfisModel& model);

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::AnfisCandidate>& candidate) {
  at("functions", candidate.functions);
  at("ridge", candidate.ridge);
  at("loo_rmse_mm", candidate.loo_rmse);
  at("effective_parameters", candidate.effective_parameters);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::AnfisSelection>& selection) {
  at("functions", selection.chosen.functions);
  at("ridge", selection.chosen.ridge);
  at("loo_rmse_mm", selection.chosen.loo_rmse);
  at("gain", selection.gain);
  at("standard_errors", selection.standard_errors);
  at("rmse_without_mm", selection.rmse_without);
  at("as_printed", selection.as_printed);
  at("candidates", selection.candidates);
}

/// "gaussian" or "bell".
template <class Fields, class Kind>
void describe_kind(Fields& at, Kind& kind) {
  at.named(
      "kind", kind,
      [](calibration::MembershipKind each) {
        return each == calibration::MembershipKind::kBell ? "bell" : "gaussian";
      },
      [](std::string_view text) -> std::optional<calibration::MembershipKind> {
        if (text == "bell") return calibration::MembershipKind::kBell;
        if (text == "gaussian") return calibration::MembershipKind::kGaussian;
        return std::nullopt;
      });
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::AnfisReport>& report) {
  auto& model = report.model;
  describe_kind(at, model.kind);
  at("functions", model.functions);
  at("input_mean", model.input_mean);
  at("input_scale", model.input_scale);
  at("centre", model.centre);
  at("width", model.width);
  at("slope", model.slope);
  at("consequents", model.consequents);
  at("box_low", model.box_low);
  at("box_high", model.box_high);
  at("output_low_mm", model.output_low);
  at("output_high_mm", model.output_high);
  at("effective_parameters", model.effective_parameters);
  at("ridge", model.ridge);
  at("best_epoch", report.best_epoch);
  at("target_reached", report.target_reached);
  at("train_rmse_mm", report.train_rmse_mm);
  at("check_rmse_mm", report.check_rmse_mm);
  at("selection", report.selection);
  if constexpr (Fields::kReads) {
    // Results of early versions do not say how many samples a network rests on: 0.
    if (at.has("samples")) at("samples", report.samples);
    model.inputs = static_cast<int>(model.input_mean.size());
    check_network(model);
  } else {
    if (report.samples > 0) at("samples", report.samples);
    at("inputs", model.inputs);
    at("rules", model.rules());
    at("consequents_count", static_cast<int>(model.consequents.size()));
  }
}

}  // namespace sixdial::report
