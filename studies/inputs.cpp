#include "studies/inputs.h"

#include <fmt/format.h>

#include "session/bundle.h"
#include "studies/error.h"

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

void check_same_data(
    const Inputs& inputs, const session::Session& session, std::string_view what,
    std::string_view hint) {
  if (inputs.data_hash == std::string(kHashPrefix) + session::data_sha256(session)) return;
  const bool same_name = inputs.session == session.name;
  throw StudyError(
      StudyErrorCode::kBadData,
      same_name ? fmt::format(
                      "the {} was made from other data than the session {} holds now", what,
                      session.name)
                : fmt::format(
                      "the {} was made from the data of session {}, not from those of {}", what,
                      inputs.session, session.name),
      {{"session", session.name}}, std::string(hint));
}

}  // namespace sixdial::studies
