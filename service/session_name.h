// What a session may be called.
#pragma once

#include <string>

namespace sixdial::service {

/// A name that is safe as a file name and readable in a table; throws Error invalid_params.
void check_session_name(const std::string& name);

}  // namespace sixdial::service
