// doc/manual/causes.md, printed from the effects' own words so that the two cannot differ.
#pragma once

#include <string>

namespace sixdial::report {

[[nodiscard]] std::string causes_markdown();

}  // namespace sixdial::report
