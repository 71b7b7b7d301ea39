#include "report/documents/warnings_document.h"

#include <algorithm>

#include "report/documents/warnings_json.h"

namespace sixdial::report {

Json warnings_json(const std::vector<studies::Warning>& warnings) { return write(warnings); }

std::vector<studies::Warning> warnings_in(const Json& answer) {
  const auto found = answer.find("warnings");
  if (found == answer.end() || !found->is_array()) return {};
  return read<std::vector<studies::Warning>>(*found, "sixdial.warnings");
}

void check_may_command(const std::vector<studies::Warning>& warnings) {
  const auto wrong =
      std::ranges::find(warnings, studies::Severity::kWrong, &studies::Warning::severity);
  if (wrong == warnings.end()) return;
  throw studies::StudyError(
      studies::StudyErrorCode::kBadData,
      "nothing is commanded by this result, its data are not plausible: " +
          warning_line(*wrong),
      {}, "Settle that, then calibrate again.");
}

}  // namespace sixdial::report
