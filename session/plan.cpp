#include "session/plan.h"

#include <fmt/format.h>

#include <map>
#include <tuple>
#include <utility>

#include "session/csv.h"

namespace sixdial::session {
namespace {

enum PlanColumn {
  kSet,
  kPoint,
  kRepeat,
  kTargetX,
  kTargetY,
  kTheta1,
  kTheta2,
  kApproach1,
  kApproach2,
  kMode,
  kColumnCount
};
const std::array<std::string, kColumnCount> kNames{
    "set",        "point",      "repeat",    "target_x_mm", "target_y_mm",
    "theta1_rad", "theta2_rad", "approach1", "approach2",   "mode"};
constexpr std::array<PlanColumn, 4> kRequired{kSet, kPoint, kTargetX, kTargetY};

using Places = std::array<std::optional<std::size_t>, kColumnCount>;

Places read_plan_header(const CsvRow& header, const std::string& file_name) {
  std::vector<Finding> findings;
  if (header.fault) findings.push_back(*header.fault);
  const std::vector<std::string> known(kNames.begin(), kNames.end());
  Places places;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const CsvField& field = header.fields[i];
    const auto found = std::find(known.begin(), known.end(), field.value);
    if (found == known.end()) {
      findings.push_back(
          {header.line, field.column, shown(field.value), "unknown column of a plan",
           fmt::format("the nearest known one is '{}'", nearest_word(field.value, known))});
      continue;
    }
    auto& place = places[static_cast<std::size_t>(found - known.begin())];
    if (place) {
      findings.push_back(
          {header.line, field.column, field.value, "the column appears twice",
           "leave one of them out"});
    }
    place = i;
  }
  for (const PlanColumn column : kRequired) {
    if (places[column]) continue;
    findings.push_back(
        {header.line, 1, kNames[column], "the column is missing",
         "a plan needs set, point, target_x_mm and target_y_mm"});
  }
  if (places[kTheta1].has_value() != places[kTheta2].has_value()) {
    findings.push_back(
        {header.line, 1, kNames[places[kTheta1] ? kTheta2 : kTheta1], "the column is missing",
         "give both angles or neither"});
  }
  if (!findings.empty()) {
    const std::size_t total = findings.size();
    throw DataError(file_name, std::move(findings), total);
  }
  return places;
}

/// One row of a plan file, field by field; throws a Finding for the first that is wrong.
class PlanRow {
 public:
  PlanRow(const CsvRow& row, const Places& places) : row_(row), places_(places) {}

  [[nodiscard]] const CsvField* field(PlanColumn column) const {
    if (!places_[column]) return nullptr;
    const CsvField& found = row_.fields[*places_[column]];
    return found.value.empty() ? nullptr : &found;
  }

  [[nodiscard]] Finding finding(PlanColumn column, std::string what, std::string hint) const {
    const int place = places_[column] ? row_.fields[*places_[column]].column : 1;
    return {row_.line, place, kNames[column], std::move(what), std::move(hint)};
  }

  [[nodiscard]] double number(PlanColumn column) const {
    const CsvField& text = row_.fields[*places_[column]];
    const ParsedNumber parsed = parse_number(text.value);
    if (parsed.trouble) throw number_finding(row_, text, kNames[column], *parsed.trouble);
    return parsed.value;
  }

  [[nodiscard]] int integer(PlanColumn column, int least, int most, int absent) const {
    const CsvField* text = field(column);
    if (text == nullptr && column != kPoint) return absent;
    const auto parsed = parse_integer(text == nullptr ? "" : text->value);
    if (parsed && *parsed >= least && *parsed <= most) return *parsed;
    throw finding(
        column, shown(text == nullptr ? "" : text->value) + " does not fit",
        least < 0 ? "write -1, 0 or 1" : "write a whole number from 0");
  }

 private:
  const CsvRow& row_;
  const Places& places_;
};

std::optional<geometry::WorkingMode> read_mode(const PlanRow& row) {
  const CsvField* text = row.field(kMode);
  if (text == nullptr) return std::nullopt;
  const auto mode = geometry::working_mode_from(text->value);
  if (mode) return mode;
  throw row.finding(
      kMode, shown(text->value) + " is no working mode",
      "write ++, +-, -+ or --: the elbow sides of leg 1 and leg 2");
}

PlanPoint read_point(const PlanRow& row, const geometry::Rig& rig) {
  constexpr int kMostPoints = 1'000'000'000;
  PlanPoint point;
  if (row.field(kSet) == nullptr) {
    throw row.finding(kSet, "the set is empty", "write G1, G2 or a name");
  }
  point.set = row.field(kSet)->value;
  point.point = row.integer(kPoint, 0, kMostPoints, 0);
  point.repeat = row.integer(kRepeat, 0, kMostPoints, 0);
  point.approach = {row.integer(kApproach1, -1, 1, 0), row.integer(kApproach2, -1, 1, 0)};
  point.target_mm = {row.number(kTargetX), row.number(kTargetY)};
  const geometry::Robot& robot = rig.robot;
  const auto mode = read_mode(row);
  if (row.field(kTheta1) == nullptr && row.field(kTheta2) == nullptr) {
    const geometry::WorkingMode taken = mode.value_or(robot.working_mode);
    const auto reference =
        geometry::inverse(robot.nominal, rig.cuboid.reference_pose_mm, taken);
    const auto q = geometry::inverse(
        robot.nominal, point.target_mm, taken,
        reference ? std::optional(*reference) : std::nullopt);
    if (!q) {
      throw row.finding(
          kTargetX,
          fmt::format(
              "the robot cannot take ({}, {}) mm in working mode {}: {}", point.target_mm.x(),
              point.target_mm.y(), to_string(taken), describe(q.error())),
          "move the target into the workspace");
    }
    point.q_rad = *q;
    return point;
  }
  point.q_rad = {row.number(kTheta1), row.number(kTheta2)};
  const auto pose = geometry::forward(robot.nominal, point.q_rad, robot.assembly);
  if (!pose) {
    throw row.finding(
        kTheta1,
        fmt::format(
            "joint angles ({}, {}) rad are out of reach: {}", point.q_rad[0], point.q_rad[1],
            describe(pose.error())),
        "leave both angles empty to have them computed from the target");
  }
  if (const Branch branch = branch_of(rig, point); mode && branch.mode != *mode) {
    throw row.finding(
        kMode,
        fmt::format(
            "the angles are those of working mode {}, the row says {}", to_string(branch.mode),
            to_string(*mode)),
        "leave both angles empty to have them computed in the mode of the row");
  }
  return point;
}

std::string csv_of(const Plan& plan, const geometry::Rig* rig) {
  const std::size_t columns = rig != nullptr ? kColumnCount : kMode;
  std::string out;
  for (std::size_t i = 0; i < columns; ++i) out += (i == 0 ? "" : ",") + kNames[i];
  out += '\n';
  for (const PlanPoint& point : plan.points) {
    out += fmt::format(
        "{},{},{},{},{},{},{},{},{}", csv_field(point.set), point.point, point.repeat,
        decimal(point.target_mm.x(), 6), decimal(point.target_mm.y(), 6),
        decimal(point.q_rad[0], 9), decimal(point.q_rad[1], 9), point.approach[0],
        point.approach[1]);
    if (rig != nullptr) out += ',' + to_string(branch_of(*rig, point).mode);
    out += '\n';
  }
  return out;
}

}  // namespace

Branch branch_of(const geometry::Rig& rig, const PlanPoint& point) {
  const geometry::Robot& robot = rig.robot;
  const auto assembly = geometry::assembly_at(robot.nominal, point.q_rad, point.target_mm);
  if (!assembly) return {robot.working_mode, robot.assembly};
  const auto mode = geometry::working_mode_of(robot.nominal, point.q_rad, *assembly);
  return {mode ? *mode : robot.working_mode, *assembly};
}

std::vector<Stretch> stretches_of(const geometry::Rig& rig, const Plan& plan) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    const Branch branch = branch_of(rig, plan.points[i]);
    if (stretches.empty() || stretches.back().branch != branch) {
      stretches.push_back({branch, i, 0});
    }
    ++stretches.back().points;
  }
  return stretches;
}

std::vector<std::string> operator_notes(const geometry::Rig& rig, const Plan& plan) {
  const std::vector<Stretch> stretches = stretches_of(rig, plan);
  if (stretches.size() < 2) return {};
  std::vector<std::string> notes;
  const Branch* before = nullptr;
  for (const Stretch& stretch : stretches) {
    const PlanPoint& first = plan.points[stretch.first];
    const Branch& now = stretch.branch;
    if (before == nullptr) {
      notes.push_back(fmt::format(
          "{} rows in working mode {} (assembly {})", stretch.points, to_string(now.mode),
          static_cast<int>(now.assembly)));
    } else {
      notes.push_back(fmt::format(
          "then {} in {} (assembly {}): before {} point {} an operator must clear the dials "
          "and bring the legs over from {}, across singular poses; collecting pauses there",
          stretch.points, to_string(now.mode), static_cast<int>(now.assembly), first.set,
          first.point, to_string(before->mode)));
    }
    before = &now;
  }
  return notes;
}

Plan parse_plan(std::string_view text, const std::string& file_name, const geometry::Rig& rig) {
  const CsvTable table = read_csv(text, file_name);
  const Places places = read_plan_header(table.header, file_name);
  Plan plan;
  std::vector<Finding> findings;
  std::size_t total = 0;
  std::map<std::tuple<std::string, int, int>, int> keys;
  for (const CsvRow& row : table.rows) {
    try {
      if (row.fault) throw Finding(*row.fault);
      if (row.fields.size() != table.header.fields.size()) {
        throw Finding{
            row.line, row.fields.back().column, "",
            fmt::format(
                "the row has {} fields, the header has {}", row.fields.size(),
                table.header.fields.size()),
            "leave an empty field where there is no value"};
      }
      const PlanRow reader(row, places);
      PlanPoint point = read_point(reader, rig);
      const auto [found, fresh] =
          keys.emplace(std::tuple(point.set, point.point, point.repeat), row.line);
      if (!fresh) {
        throw reader.finding(
            kPoint,
            fmt::format(
                "set {}, point {}, repeat {} stands in line {} already", point.set, point.point,
                point.repeat, found->second),
            "number repeats 0, 1, 2 ...");
      }
      plan.points.push_back(std::move(point));
    } catch (const Finding& finding) {
      ++total;
      if (findings.size() < DataError::kMostShown) findings.push_back(finding);
    }
  }
  if (total > 0) throw DataError(file_name, std::move(findings), total);
  if (plan.points.empty()) {
    throw DataError(file_name, Finding{1, 1, "", "the plan has no points", "add a row each"});
  }
  return plan;
}

Plan read_plan(const std::string& path, const geometry::Rig& rig) {
  return parse_plan(read_file(path), path, rig);
}

std::string plan_csv(const Plan& plan) { return csv_of(plan, nullptr); }
std::string plan_csv(const Plan& plan, const geometry::Rig& rig) { return csv_of(plan, &rig); }

void write_plan(const Plan& plan, const std::string& path) { write_file(path, plan_csv(plan)); }

}  // namespace sixdial::session
