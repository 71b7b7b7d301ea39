#pragma once

#include <nlohmann/json.hpp>

namespace sixdial {

using Json = nlohmann::json;

}  // namespace sixdial
