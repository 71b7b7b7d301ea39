// Where a result was measured, as calibrations and diagnoses write it.
#pragma once

#include "geometry/registration.h"
#include "report/documents/fields.h"
#include "studies/measured_joints.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::MeasuredJoints>& joints) {
  at("mode", joints.mode.number);
  at("low", joints.low);
  at("high", joints.high);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, geometry::Similarity>& frame) {
  at("turn", frame.R);
  at("shift_mm", frame.t);
}

}  // namespace sixdial::report
