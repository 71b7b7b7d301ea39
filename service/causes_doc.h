// doc/manual/causes.md, printed from the effects' own words so that the two cannot differ.
#pragma once

#include <string>

namespace sixdial::service {

[[nodiscard]] std::string causes_markdown();

}  // namespace sixdial::service
