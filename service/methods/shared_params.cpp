#include "service/methods/shared_params.h"

#include <fmt/format.h>

namespace sixdial::service::params {

std::filesystem::path absolute_path(const Call& call) {
  std::filesystem::path path = call.params.at("path").get<std::string>();
  if (path.is_absolute()) return path;
  throw Error(
      ErrorCode::kInvalidParams, fmt::format("the path {} is relative", path.string()),
      {{"param", "path"}}, "The service runs in another directory: give an absolute path.");
}

}  // namespace sixdial::service::params
