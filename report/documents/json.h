// The JSON type of stored documents. Only report/documents/ turns results into it and back.
#pragma once

#include <nlohmann/json.hpp>

namespace sixdial {

using Json = nlohmann::json;

}  // namespace sixdial
