// Rows of other sets than G1 and G2 take part in nothing. Most often such a set is a slip of
// the pen ("g1", "Gl"), and half of the measurement is silently gone. A blank around the name,
// which nobody sees, is cut off when it is read, and told here.
#include <map>
#include <string>

#include "session/csv.h"
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

/// The set as the sample's line of the file has it; as it was read where there is no file.
std::string set_in_file(const session::Session& session, const session::Sample& sample) {
  // Any blank, also the wide ones of UTF-8, begins with one of these bytes.
  constexpr std::string_view kOfBlanks = " \t\xC2\xE2\xEF";
  if (sample.source_row.find_first_of(kOfBlanks) == std::string::npos) return sample.set;
  const std::string text = session.csv_header + "\n" + sample.source_row + "\n";
  const session::CsvTable table = session::read_csv(text, "session.csv");
  for (std::size_t i = 0; i < table.header.fields.size(); ++i) {
    if (table.header.fields[i].value != "set" || table.rows.empty()) continue;
    const auto& fields = table.rows.front().fields;
    return i < fields.size() ? fields[i].value : sample.set;
  }
  return sample.set;
}

void look_at_blanks(Look& look) {
  std::map<std::string, std::vector<std::size_t>> by_set;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (set_in_file(look.measured, sample) != sample.set) by_set[sample.set].push_back(i);
  }
  for (const auto& [set, rows] : by_set) {
    look.tell("set_with_blanks", Severity::kNote, look.rows(rows, "set"), {{"set", set}});
  }
}

}  // namespace

void look_at_sets(Look& look) {
  look_at_blanks(look);
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
