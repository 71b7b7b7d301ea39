// "rig" of the documents of a calibration, a comparison and a diagnosis.
#pragma once

#include "diagnosis/rig_seen.h"
#include "report/documents/fields.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, diagnosis::RigSeen>& each) {
  at("name", each.name);
  at("unit", each.unit);
  at("off", each.off);
  at("sd", each.sd);
  at("known_sd", each.known_sd);
  at("stated", each.stated);
}

}  // namespace sixdial::report
