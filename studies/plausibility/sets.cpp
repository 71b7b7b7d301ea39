// Rows of other sets than G1 and G2 take part in nothing. Most often such a set is a slip of
// the pen ("g1", "Gl"), and half of the measurement is silently gone.
#include <map>

#include "session/data_error.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

/// Of "g1", "Gl", "G 1", "G-1": the set that was likely meant; else empty.
std::string likely_set(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    if (c == ' ' || c == '-' || c == '_' || c == '.') continue;
    plain += c == 'g' ? 'G' : c == 'l' || c == 'I' || c == 'i' ? '1' : c == 'Z' ? '2' : c;
  }
  return plain == "G1" || plain == "G2" ? plain : "";
}

}  // namespace

void look_at_sets(Look& look) {
  std::map<std::string, std::vector<std::size_t>> others;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const std::string& set = look.used.samples[i].set;
    if (set != "G1" && set != "G2") others[set].push_back(i);
  }
  for (const auto& [set, rows] : others) {
    const std::string meant = likely_set(set);
    WarningParts parts{
        {"set", set}, {"samples", static_cast<double>(look.used.samples.size())}};
    if (!meant.empty()) parts["meant"] = meant;
    look.tell(
        "set_not_used", meant.empty() ? Severity::kNote : Severity::kDoubt,
        look.rows(rows, "set"), std::move(parts));
  }
}

}  // namespace sixdial::studies::plausibility
