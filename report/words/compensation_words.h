// What people read of one commanded target on the screen.
#pragma once

#include <string>

#include "studies/compensate.h"

namespace sixdial::report {

/// "q1 1.234567890  q2 ... rad for (28.000000, 48.000000) mm in mode ++; nominal ...;
/// closes to 1.2e-13 mm", and a line on what the model knows of it, where that is known.
[[nodiscard]] std::string compensation_text(const studies::CommandedTarget& at);

}  // namespace sixdial::report
