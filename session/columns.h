// The columns of session.csv and which of them a header has.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "geometry/rig.h"
#include "session/csv.h"

namespace sixdial::session {

enum class Column {
  kSet,
  kPoint,
  kRepeat,
  kTime,
  kTheta1,
  kTheta2,
  kTargetX,
  kTargetY,
  kApproach1,
  kApproach2,
  kTemperature,
  kX,
  kY,
  kDial,     // with the dial's index
  kUnknown,  // kept, not understood
};

struct HeaderColumn {
  Column column = Column::kUnknown;
  std::size_t dial = 0;  // index into rig.dials, for kDial
  std::string name;
};

/// The spec's name of a column; empty for kDial and kUnknown.
[[nodiscard]] std::string column_name(Column column);
/// "dial_A_mm".
[[nodiscard]] std::string dial_column_name(const std::string& dial_id);

/// What each column of a header is. Adds a finding for a dial that the rig does not have, for a
/// column that appears twice and for required ones that are missing.
[[nodiscard]] std::vector<HeaderColumn> read_header(
    const CsvRow& header, const geometry::Rig& rig, std::vector<Finding>& findings);

/// The columns in the spec's order for sessions measured here.
[[nodiscard]] std::vector<HeaderColumn> spec_columns(
    const geometry::Rig& rig, bool with_dials, bool with_position);

}  // namespace sixdial::session
