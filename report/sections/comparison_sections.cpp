#include <fmt/format.h>

#include "report/sections/sections_of_studies.h"

namespace sixdial::report {
namespace {

Column column(
    std::string key, std::string title, std::string unit = "", std::string group = "") {
  return {
      .key = std::move(key),
      .title = std::move(title),
      .unit = std::move(unit),
      .group = std::move(group)};
}

Cell cell(const Json& json, const char* key, int decimals = 4) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number()) return {};
  return number(json[key].get<double>(), decimals);
}

}  // namespace

std::vector<Section> comparison_sections(const Json& document) {
  Section section{.id = "comparison", .heading = "All methods on this session"};
  const Json& settings = document["inputs"]["settings"];
  section.blocks.emplace_back(fmt::format(
      "Each method identified the robot from G1 ({}) and was judged on G2, which none of them "
      "saw. Times are of this machine, identification and residual model together.",
      settings["space"] == "dials" ? "raw readings of all dials in contact"
                                   : "measured positions"));
  Table table{.id = "comparison", .caption = "Absolute position error by method, as Table 6"};
  table.columns = {column("method", "method")};
  for (const auto& [set, group] :
       {std::pair{"g1", "G1 calibration"}, std::pair{"g2", "G2 validation"}}) {
    for (const char* what : {"mean", "std", "max"}) {
      table.columns.push_back(column(fmt::format("{}_{}_mm", set, what), what, "mm", group));
    }
  }
  table.columns.push_back(column("seconds", "time", "s"));
  for (const Json& method : document["methods"]) {
    if (method["id"] == document["best"]) table.main_row = table.rows.size();
    table.rows.push_back(
        {method["name"].get<std::string>(), cell(method["g1"], "mean_mm"),
         cell(method["g1"], "std_mm"), cell(method["g1"], "max_mm"),
         cell(method["g2"], "mean_mm"), cell(method["g2"], "std_mm"),
         cell(method["g2"], "max_mm"), cell(method, "seconds", 4)});
  }
  table.notes.push_back(fmt::format(
      "Before: {}. Lowest mean on G2 in bold. Figures are differences between measured and "
      "modelled positions.",
      document["before_is"].get<std::string>()));
  section.blocks.emplace_back(std::move(table));

  Table learned{.id = "residual_models", .caption = "What the residual models used"};
  learned.columns = {
      column("method", "method"), column("effective_x", "effective parameters, x"),
      column("effective_y", "effective parameters, y"), column("note", "chosen")};
  for (const Json& method : document["methods"]) {
    if (!method["residual_model"].is_string()) continue;
    const Json& effective = method["effective_parameters"];
    learned.rows.push_back(
        {method["name"].get<std::string>(), number(effective[0].get<double>(), 1),
         number(effective[1].get<double>(), 1), method["note"].get<std::string>()});
  }
  if (!learned.rows.empty()) section.blocks.emplace_back(std::move(learned));
  return {std::move(section)};
}

}  // namespace sixdial::report
