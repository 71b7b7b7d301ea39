#include "studies/own_frame.h"

#include <algorithm>
#include <cstddef>

#include "geometry/instrument_frame.h"

namespace sixdial::studies {

void hold_where_it_stands(const geometry::Rig& rig, std::vector<char>& fixed) {
  if (geometry::knows_the_frame(rig)) return;
  const auto& parameters = rig.robot.model->parameters;
  for (std::size_t i = 0; i < std::min(fixed.size(), parameters.size()); ++i) {
    if (parameters[i].stands) fixed[i] = 1;
  }
}

}  // namespace sixdial::studies
