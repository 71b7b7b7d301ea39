// A cross-validation in a document.
#pragma once

#include "report/documents/fields.h"
#include "studies/cross_validation.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CheckedModel>& model) {
  at.named(
      "id", model.by, [](studies::CompensateBy each) { return studies::to_string(each); },
      studies::compensate_by_from);
  at("error_mm", model.error_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CrossValidation>& checked) {
  at("folds", checked.folds);
  at("residual_model", checked.residual_model);
  at("models", checked.models);
}

}  // namespace sixdial::report
