#include "studies/inputs.h"

#include "session/bundle.h"

namespace sixdial::studies {

Inputs inputs_of(const session::Session& session, std::uint64_t seed) {
  const std::string prefix(kHashPrefix);
  return {
      .session = session.name,
      .rig_name = session.rig.name,
      .rig_hash = prefix + session::rig_sha256(session),
      .data_hash = prefix + session::data_sha256(session),
      .samples = static_cast<int>(session.samples.size()),
      .rejected_rows = static_cast<int>(session.rejected.size()),
      .seed = seed,
      .version = SIXDIAL_VERSION};
}

}  // namespace sixdial::studies
