#include "session/traceability.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <chrono>

#include "session/csv.h"
#include "session/toml_text.h"

namespace sixdial::session {
namespace {

std::string text_of(const toml::table& from, const char* key) {
  const toml::node* node = from.get(key);
  if (node == nullptr) return "";
  if (const auto date = node->value<toml::date>(); date && node->is_date()) {
    return fmt::format("{:04}-{:02}-{:02}", date->year, date->month, date->day);
  }
  return node->value<std::string>().value_or("");
}

void add(Traceability& all, std::string what, const toml::table* from) {
  if (from == nullptr) return;
  TracedPart part{
      .what = std::move(what),
      .serial = text_of(*from, "serial"),
      .certificate = text_of(*from, "certificate"),
      .certified = text_of(*from, "certified"),
      .due = text_of(*from, "due")};
  if (!part.words().empty()) all.parts.push_back(std::move(part));
}

}  // namespace

std::string TracedPart::words() const {
  std::string text;
  const auto join = [&](const std::string& more) { text += (text.empty() ? "" : ", ") + more; };
  if (!serial.empty()) join("serial " + serial);
  if (!certificate.empty() || !certified.empty()) {
    join(
        "certificate" + (certificate.empty() ? "" : " " + certificate) +
        (certified.empty() ? "" : " of " + certified));
  }
  if (!due.empty()) join("due " + due);
  return text;
}

const TracedPart* Traceability::find(std::string_view what) const {
  const auto found = std::ranges::find(parts, what, &TracedPart::what);
  return found == parts.end() ? nullptr : &*found;
}

Traceability traceability_of(std::string_view rig_text) {
  Traceability all;
  if (rig_text.empty() || stray_character(rig_text)) return all;
  try {
    const toml::table top = toml::parse(rig_text);
    all.operator_name = text_of(top, "operator");
    add(all, "robot", top.get_as<toml::table>("robot"));
    add(all, "cuboid", top.get_as<toml::table>("cuboid"));
    add(all, "thermometer", top.get_as<toml::table>("thermometer"));
    if (const auto* dials = top.get_as<toml::array>("dial")) {
      for (const toml::node& each : *dials) {
        const toml::table* dial = each.as_table();
        if (dial != nullptr) add(all, "dial " + text_of(*dial, "id"), dial);
      }
    }
  } catch (const toml::parse_error&) {
    return {};
  }
  return all;
}

bool is_date(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const auto year = parse_integer(text.substr(0, 4));
  const auto month = parse_integer(text.substr(5, 2));
  const auto day = parse_integer(text.substr(8, 2));
  if (!year || !month || !day || *month < 1 || *day < 1) return false;
  return std::chrono::year_month_day(
             std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
             std::chrono::day(static_cast<unsigned>(*day)))
      .ok();
}

}  // namespace sixdial::session
