// What follows from a dial's row for people: an example rig file and its line in the table of
// doc/devices.md. `sixdiald --print-rig NAME` and `sixdiald --print-dials` print them.
//
//   std::ofstream("examples/rigs/mahr.toml") << example_rig(*find_dial_protocol("mahr"));
#pragma once

#include <string>

#include "acquisition/dial_protocol.h"

namespace sixdial::acquisition {

/// "4800 baud 7E2".
[[nodiscard]] std::string in_words(const LineSettings& line);

/// The rig of spec 1 with six dials of this kind: text of a rig.toml.
[[nodiscard]] std::string example_rig(const DialProtocol& protocol);

/// All dials that speak on serial lines, as the table of doc/devices.md.
[[nodiscard]] std::string dial_table();

}  // namespace sixdial::acquisition
