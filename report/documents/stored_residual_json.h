// A stored residual model in a document.
#pragma once

#include "report/documents/fields.h"
#include "studies/stored_residual.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::StoredResidualModel>& model) {
  at("name", model.name);
  at("note", model.note);
  at("effective_parameters", model.effective_parameters);
  at("values", model.saved);
}

}  // namespace sixdial::report
