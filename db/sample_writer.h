// Inserts samples with their readings; the statements are prepared once for many.
#pragma once

#include <optional>

#include "db/sqlite.h"
#include "db/types.h"
#include "geometry/rig.h"

namespace sixdial::db {

class SampleWriter {
 public:
  explicit SampleWriter(Database& database);
  /// Within the caller's transaction. `sample` has one reading for each dial of `rig`.
  SampleId write(
      SessionId session, const session::Sample& sample, std::optional<SampleId> supersedes,
      const geometry::Rig& rig);

 private:
  Database& database_;
  Statement sample_;
  Statement reading_;
};

}  // namespace sixdial::db
