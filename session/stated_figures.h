// Which figures of the dials the rig file really states, and which are defaults of this
// program: what nobody stated is not counted as if somebody knew it.
#pragma once

#include <string_view>

namespace sixdial::session {

/// Whether `rig_text` gives `key` ("accuracy_mm") for this dial, in its own [[dial]] or in
/// [dials]. True where there is no text: a rig made in memory is what it says.
[[nodiscard]] bool states_figure(
    std::string_view rig_text, std::string_view dial, std::string_view key);

}  // namespace sixdial::session
