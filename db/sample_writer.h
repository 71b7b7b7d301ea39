// Inserts samples with their joint values and readings; the statements are prepared once for
// many.
#pragma once

#include <optional>

#include "db/sqlite.h"
#include "db/types.h"
#include "session/sample_layout.h"

namespace sixdial::db {

class SampleWriter {
 public:
  explicit SampleWriter(Database& database);
  /// Within the caller's transaction. `sample` is sound by session::sample_problem.
  SampleId write(
      SessionId session, const session::Sample& sample, std::optional<SampleId> supersedes,
      const session::SampleLayout& layout);

 private:
  Database& database_;
  Statement sample_;
  Statement joint_;
  Statement channel_;
};

}  // namespace sixdial::db
