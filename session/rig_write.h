// A rig file written anew: the rig, and what its figures can be traced to.
#pragma once

#include <string>
#include <string_view>

#include "geometry/rig.h"
#include "session/traceability.h"

namespace sixdial::session {

/// write_rig() of rig_file.h, with every key that `traced` holds: parse_rig() and
/// traceability_of() read both back equal. Comments of a file that was read are lost.
[[nodiscard]] std::string write_rig(const geometry::Rig& rig, const Traceability& traced);

/// The text of a rig file as it is, or written anew if it needs another file beside it (a
/// URDF), which nobody would find from the store.
[[nodiscard]] std::string self_contained(const geometry::Rig& rig, std::string_view rig_text);

}  // namespace sixdial::session
