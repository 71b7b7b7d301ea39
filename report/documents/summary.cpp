#include "report/documents/summary.h"

namespace sixdial::report {
namespace {

void flatten(
    const Json& json, const std::string& prefix,
    std::vector<std::pair<std::string, std::string>>& rows) {
  for (const auto& [key, value] : json.items()) {
    const std::string name = prefix.empty() ? key : prefix + "." + key;
    if (value.is_object()) {
      flatten(value, name, rows);
    } else {
      rows.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

}  // namespace

Json document_summary(const Json& document) {
  Json summary = document;
  for (const char* key :
       {"points", "convergence", "traces", "anfis", "residuals", "tool_shift", "by_covariate",
        "dependence", "gross_readings"}) {
    summary.erase(key);
  }
  if (summary.contains("residual_model")) summary["residual_model"].erase("values");
  if (summary.contains("extended_model")) {
    summary["extended_model"].erase("residual_model");
    summary["extended_model"].erase("covariance");
  }
  if (summary.contains("cross_validation")) {
    for (Json& model : summary["cross_validation"]["models"]) model.erase("error_mm");
  }
  if (summary.contains("causes")) {
    for (Json& cause : summary["causes"]) cause.erase("signature_plot");
  }
  return summary;
}

std::vector<std::pair<std::string, std::string>> settings_rows(const Json& settings) {
  std::vector<std::pair<std::string, std::string>> rows;
  flatten(settings, "", rows);
  return rows;
}

}  // namespace sixdial::report
