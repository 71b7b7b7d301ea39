// What an export tells beside its text, as the document "sixdial.export".
#pragma once

#include "report/documents/json.h"
#include "report/export/export_format.h"

namespace sixdial::report {

/// Without the text.
[[nodiscard]] Json to_json(const Exported& exported);
/// Throws StudyError bad_data that names the key.
[[nodiscard]] Exported exported_from_json(const Json& json);

}  // namespace sixdial::report
