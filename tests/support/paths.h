// Where the tests find the source tree, their data and the programs. Defined in paths.cpp
// alone, so that the compiler cache can share every other object between two copies of the
// tree.
#pragma once

#include <string>

namespace sixdial::test_paths {

/// The root of the source tree, e.g. source_dir() + "/doc/protocol.md".
[[nodiscard]] std::string source_dir();
/// tests/data of the source tree.
[[nodiscard]] std::string test_data();
/// Where the programs of this build are.
[[nodiscard]] std::string bin_dir();

}  // namespace sixdial::test_paths
