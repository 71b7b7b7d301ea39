// Any bytes as rig.toml: an error, or a rig that is written and read back with the same text.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "session/rig_file.h"
#include "session/rig_write.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sixdial::session;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const std::string written = write_rig(parse_rig(text, "rig.toml"), traceability_of(text));
    const std::string again =
        write_rig(parse_rig(written, "written"), traceability_of(written));
    if (again != written) std::abort();
  } catch (const DataError& error) {
    if (error.mistakes.empty()) std::abort();
  }
  return 0;
}
