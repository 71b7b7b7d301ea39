#include "tests/support/paths.h"

namespace sixdial::test_paths {

std::string source_dir() { return SIXDIAL_SOURCE_DIR; }
std::string test_data() { return SIXDIAL_SOURCE_DIR "/tests/data"; }
std::string bin_dir() { return SIXDIAL_BIN_DIR; }

}  // namespace sixdial::test_paths
