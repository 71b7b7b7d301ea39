// Rows of session.csv, one after the other, into samples.
#pragma once

#include <functional>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/rig.h"
#include "session/columns.h"
#include "session/csv.h"
#include "session/sample_layout.h"
#include "session/session.h"

namespace sixdial::session {

/// The sample of a row, or what is wrong with it, at the first field that is. It knows the rows
/// before: a point may not stand twice.
using ReadRow = std::function<tl::expected<Sample, Mistake>(const CsvRow& row)>;
/// `columns`: what read_header found. Rig and layout outlive the reader.
[[nodiscard]] ReadRow row_reader(
    const geometry::Rig& rig, const SampleLayout& layout, std::vector<HeaderColumn> columns);

/// A row of separators only, as spreadsheets leave them at the end.
[[nodiscard]] bool is_blank(const CsvRow& row);

}  // namespace sixdial::session
