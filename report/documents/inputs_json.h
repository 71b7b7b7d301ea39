// "inputs" of a document, without its settings: each document has settings of its own.
//   at.inner("inputs", [&](auto& inputs) {
//     describe_keys(inputs, result.inputs);
//     inputs("settings", result.settings);
//   });
#pragma once

#include "report/documents/fields.h"
#include "studies/inputs.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Inputs>& inputs) {
  at("session", inputs.session);
  at("rig_name", inputs.rig_name);
  at("rig_hash", inputs.rig_hash);
  at("data_hash", inputs.data_hash);
  at("samples", inputs.samples);
  at("rejected_rows", inputs.rejected_rows);
  at("seed", inputs.seed);
  at("version", inputs.version);
}

}  // namespace sixdial::report
