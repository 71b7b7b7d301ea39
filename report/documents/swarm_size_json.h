// The size of a swarm, as the settings of calibrations and of comparisons have it.
#pragma once

#include "calibration/dqpso.h"
#include "report/documents/fields.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, calibration::SwarmSize>& size) {
  at("particles", size.particles);
  at("iterations", size.iterations);
}

}  // namespace sixdial::report
