#include "studies/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calibration/pipeline.h"
#include "session/bundle.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/extended_command.h"

namespace sixdial::studies {
namespace {

std::string shown_name(CompensateBy by) {
  switch (by) {
    case CompensateBy::kBefore:
      return "before calibration";
    case CompensateBy::kKinematics:
      return "after kinematics";
    case CompensateBy::kFull:
      return "after kinematics + ANFIS";
    case CompensateBy::kExtended:
      return "after diagnosis (extended)";
  }
  return "";
}

/// Row of the calibration's own table that predicts this way's errors.
std::string predicting_method(const Json& calibration, CompensateBy by) {
  const std::string full = calibration.value("result_method", "ekf_dqpso+anfis");
  if (by == CompensateBy::kBefore) return "before";
  return by == CompensateBy::kFull ? full : full.substr(0, full.find('+'));
}

Json stats_json(const std::vector<double>& errors_mm) {
  if (errors_mm.empty()) return nullptr;
  const calibration::ErrorStats stats = calibration::error_stats(errors_mm);
  return {
      {"mean_mm", stats.mean_mm},
      {"std_mm", stats.std_mm},
      {"max_mm", stats.max_mm},
      {"rmse_mm", stats.rmse_mm},
      {"points", stats.count}};
}

}  // namespace

std::string validation_set(const std::string& set, CompensateBy by) {
  return fmt::format("{}.{}", set, to_string(by));
}

session::Plan validation_plan(
    const session::Session& calibrated, const Json& calibration,
    const ValidationRequest& request, const Json& diagnosis) {
  session::Plan targets;
  std::set<int> seen;
  for (const session::Sample& sample : calibrated.samples) {
    if (sample.set != request.set || !sample.target_mm) continue;
    if (!seen.insert(sample.point).second) continue;  // repeats
    session::PlanPoint point;
    point.point = sample.point;
    point.set = request.set;
    point.target_mm = *sample.target_mm;
    point.q_rad = sample.q_rad;
    targets.points.push_back(point);
  }
  if (targets.points.empty()) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format("session {} has no targets in set {}", calibrated.name, request.set),
        {{"session", calibrated.name}},
        "Name a set whose samples have target_x_mm and target_y_mm.");
  }
  std::vector<session::Plan> ways;
  for (const CompensateBy by : request.by) {
    // Where the extended model commands depends on what is commanded before: solved below.
    ways.push_back(compensated_plan(
        targets,
        compensation_model(
            calibration, by == CompensateBy::kExtended ? CompensateBy::kKinematics : by),
        calibrated.rig));
    for (session::PlanPoint& point : ways.back().points) {
      point.set = validation_set(request.set, by);
    }
  }
  session::Plan plan;
  for (std::size_t i = 0; i < targets.points.size(); ++i) {
    for (const session::Plan& way : ways) plan.points.push_back(way.points[i]);
  }
  if (std::ranges::find(request.by, CompensateBy::kExtended) == request.by.end()) return plan;
  return extended_plan(
      std::move(plan), ExtendedCommand(diagnosis, calibrated.rig), calibrated.rig,
      validation_set(request.set, CompensateBy::kExtended));
}

Json validation_document(
    const session::Session& calibrated, const Json& calibration,
    const session::Session& validation, const ValidationRequest& request,
    const Json& diagnosis) {
  Json methods = Json::array();
  Json points = Json::array();
  for (const CompensateBy by : request.by) {
    const std::string set = validation_set(request.set, by);
    std::vector<double> errors_mm;
    int without_position = 0;
    for (const simulation::Trial& trial : session::trials_of(validation, set)) {
      if (!trial.position_mm || !trial.target_mm) {
        ++without_position;
        continue;
      }
      const Eigen::Vector2d missed = *trial.position_mm - *trial.target_mm;  // (41)
      errors_mm.push_back(missed.norm());
      points.push_back(
          {{"method", to_string(by)},
           {"point", trial.point},
           {"target_mm", {trial.target_mm->x(), trial.target_mm->y()}},
           {"theta_rad", {trial.q[0], trial.q[1]}},
           {"error_mm", {missed.x(), missed.y()}}});
    }
    Json predicted = nullptr;
    for (const Json& row : calibration.at("methods")) {
      if (row["id"] == predicting_method(calibration, by)) predicted = row["g2"];
    }
    if (by == CompensateBy::kExtended) {
      predicted = nullptr;
      for (const Json& row : diagnosis.at("gain")) {
        if (row["name"] == "extended") predicted = row;
      }
    }
    methods.push_back(
        {{"id", to_string(by)},
         {"name", shown_name(by)},
         {"set", set},
         {"errors", stats_json(errors_mm)},
         {"predicted", std::move(predicted)},
         {"without_position", without_position}});
  }
  return {
      {"schema", "sixdial.validation"},
      {"schema_version", kValidationSchemaVersion},
      {"created_utc", session::now_utc_text()},
      {"inputs",
       {{"session", calibrated.name},
        {"set", request.set},
        {"calibration_data_hash", calibration.at("inputs").at("data_hash")},
        {"validation_session", validation.name},
        {"rig_hash", "sha256:" + session::rig_sha256(validation)},
        {"data_hash", "sha256:" + session::data_sha256(validation)},
        {"version", SIXDIAL_VERSION}}},
      {"methods", std::move(methods)},
      {"points", std::move(points)}};
}

std::string validation_text(const Json& document) {
  const auto cell = [](const Json& stats, const char* key) {
    return stats.is_object() && stats.contains(key) && stats[key].is_number()
               ? fmt::format("{:8.4f}", stats[key].get<double>())
               : fmt::format("{:>8}", "-");
  };
  std::string text = fmt::format(
      "{:<26} {:>8} {:>8} {:>8} {:>7} {:>10}\n", "error reached, mm", "mean", "std", "max",
      "points", "predicted");
  for (const Json& method : document.at("methods")) {
    const Json& errors = method["errors"];
    text += fmt::format(
        "{:<26} {} {} {} {:>7} {:>10}\n", method["name"].get<std::string>(),
        cell(errors, "mean_mm"), cell(errors, "std_mm"), cell(errors, "max_mm"),
        errors.is_object() ? errors["points"].get<int>() : 0,
        cell(method["predicted"], "mean_mm"));
  }
  return text;
}

}  // namespace sixdial::studies
