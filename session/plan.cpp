#include "session/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "geometry/tool.h"
#include "geometry/tool_turn.h"
#include "geometry/units.h"
#include "session/csv.h"
#include "session/measured_turn.h"

namespace sixdial::session {
namespace {

enum class PlanColumn {
  kSet,
  kPoint,
  kRepeat,
  kSocket,
  kTarget,
  kTurn,
  kJoint,
  kApproach,
  kMode
};
constexpr std::array<std::string_view, 3> kTurnColumns{
    "target_rx_deg", "target_ry_deg", "target_rz_deg"};

/// A column of a plan file: which it is, of which axis or joint, and where it stands.
struct PlanPlace {
  PlanColumn column;
  std::size_t index;
  std::string name;
  std::optional<std::size_t> at{};  // empty: the file does not have it
};

/// Every column that a plan may have, in the order in which it is written.
std::vector<PlanPlace> columns_of(const SampleLayout& layout) {
  std::vector<PlanPlace> columns{
      {PlanColumn::kSet, 0, "set"},
      {PlanColumn::kPoint, 0, "point"},
      {PlanColumn::kRepeat, 0, "repeat"}};
  if (!layout.sockets.empty()) columns.push_back({PlanColumn::kSocket, 0, "socket"});
  for (std::size_t i = 0; i < layout.axes.size(); ++i) {
    columns.push_back({PlanColumn::kTarget, i, fmt::format("target_{}_mm", layout.axes[i])});
  }
  for (std::size_t i = 0; first_turn(layout) && i < kTurnColumns.size(); ++i) {
    columns.push_back({PlanColumn::kTurn, i, std::string(kTurnColumns.at(i))});
  }
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    columns.push_back({PlanColumn::kJoint, i, layout.joints[i].column()});
  }
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    columns.push_back({PlanColumn::kApproach, i, fmt::format("approach{}", i + 1)});
  }
  columns.push_back({PlanColumn::kMode, 0, "mode"});
  return columns;
}

/// "set, point, target_x_mm and target_y_mm": what a plan cannot do without.
std::string required_in_words(const std::vector<PlanPlace>& columns) {
  std::vector<std::string> names;
  for (const PlanPlace& each : columns) {
    if (each.column == PlanColumn::kSet || each.column == PlanColumn::kPoint ||
        each.column == PlanColumn::kTarget) {
      names.push_back(each.name);
    }
  }
  const std::string last = std::exchange(names.back(), "");
  names.pop_back();
  return fmt::format("{} and {}", fmt::join(names, ", "), last);
}

std::vector<PlanPlace> read_plan_header(
    const CsvRow& header, const std::string& file_name, const SampleLayout& layout) {
  std::vector<Mistake> mistakes;
  if (header.fault) mistakes.push_back(*header.fault);
  std::vector<PlanPlace> places = columns_of(layout);
  std::vector<std::string> known;
  known.reserve(places.size());
  for (const PlanPlace& each : places) known.push_back(each.name);
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const CsvField& field = header.fields[i];
    const auto found = std::ranges::find(places, field.value, &PlanPlace::name);
    if (found == places.end()) {
      const bool turn = std::ranges::find(kTurnColumns, field.value) != kTurnColumns.end();
      mistakes.push_back(
          {header.line, field.column, shown(field.value),
           turn ? "the rig's instrument measures no turn of the tool"
                : "unknown column of a plan",
           turn ? "leave the column out; kind = \"pose\" in [instrument] measures turns"
                : fmt::format(
                      "the nearest known one is '{}'", nearest_word(field.value, known))});
      continue;
    }
    if (found->at) {
      mistakes.push_back(
          {header.line, field.column, field.value, "the column appears twice",
           "leave one of them out"});
    }
    found->at = i;
  }
  const auto joint = [](const PlanPlace& each) { return each.column == PlanColumn::kJoint; };
  const bool any_joint = std::ranges::any_of(
      places, [&](const PlanPlace& each) { return joint(each) && each.at.has_value(); });
  for (const PlanPlace& each : places) {
    if (each.at) continue;
    if (joint(each) && any_joint) {
      mistakes.push_back(
          {header.line, 1, each.name, "the column is missing",
           layout.joints.size() == 2 ? "give both angles or neither"
                                     : "give every joint or none"});
    } else if (
        each.column == PlanColumn::kSet || each.column == PlanColumn::kPoint ||
        each.column == PlanColumn::kTarget) {
      mistakes.push_back(
          {header.line, 1, each.name, "the column is missing",
           "a plan needs " + required_in_words(places)});
    }
  }
  if (!mistakes.empty()) {
    const std::size_t total = mistakes.size();
    throw DataError(file_name, std::move(mistakes), total);
  }
  return places;
}

/// One row of a plan file, field by field; throws a Mistake for the first that is wrong.
class PlanRow {
 public:
  PlanRow(const CsvRow& row, const std::vector<PlanPlace>& places)
      : row_(row), places_(places) {}

  [[nodiscard]] const CsvField* field(PlanColumn column, std::size_t index = 0) const {
    const PlanPlace& place = place_of(column, index);
    if (!place.at) return nullptr;
    const CsvField& found = row_.fields[*place.at];
    return found.value.empty() ? nullptr : &found;
  }

  [[nodiscard]] Mistake mistake(
      PlanColumn column, std::string what, std::string hint, std::size_t index = 0) const {
    const PlanPlace& place = place_of(column, index);
    const int at = place.at ? row_.fields[*place.at].column : 1;
    return {row_.line, at, place.name, std::move(what), std::move(hint)};
  }

  [[nodiscard]] double number(PlanColumn column, std::size_t index) const {
    const PlanPlace& place = place_of(column, index);
    if (!place.at) throw std::logic_error("asked for a column that the plan does not have");
    const CsvField& text = row_.fields[*place.at];
    const ParsedNumber parsed = parse_number(text.value);
    if (parsed.trouble) throw number_mistake(row_, text, place.name, *parsed.trouble);
    return parsed.value;
  }

  [[nodiscard]] int integer(
      PlanColumn column, int least, int most, int absent, std::size_t index = 0) const {
    const CsvField* text = field(column, index);
    if (text == nullptr && column != PlanColumn::kPoint) return absent;
    const auto parsed = parse_integer(text == nullptr ? "" : text->value);
    if (parsed && *parsed >= least && *parsed <= most) return *parsed;
    throw mistake(
        column, shown(text == nullptr ? "" : text->value) + " does not fit",
        least < 0 ? "write -1, 0 or 1" : "write a whole number from 0", index);
  }

 private:
  [[nodiscard]] const PlanPlace& place_of(PlanColumn column, std::size_t index) const {
    return *std::ranges::find_if(places_, [&](const PlanPlace& each) {
      return each.column == column && each.index == index;
    });
  }

  const CsvRow& row_;
  const std::vector<PlanPlace>& places_;
};

/// "write ++, +-, -+ or --: the elbow side of leg 1 and leg 2".
std::string modes_to_write(const geometry::RobotModel& robot) {
  std::string text = "write ";
  for (std::size_t i = 0; i < robot.modes.size(); ++i) {
    if (i > 0) text += i + 1 == robot.modes.size() ? " or " : ", ";
    text += robot.modes[i].name;
  }
  return robot.mode_in_words.empty() ? text : text + ": " + robot.mode_in_words;
}

std::optional<geometry::WorkingMode> read_mode(const PlanRow& row, const geometry::Rig& rig) {
  const CsvField* text = row.field(PlanColumn::kMode);
  if (text == nullptr) return std::nullopt;
  const auto mode = rig.robot.model->find_mode(text->value);
  if (mode) return mode;
  throw row.mistake(
      PlanColumn::kMode, shown(text->value) + " is no working mode",
      modes_to_write(*rig.robot.model));
}

/// Empty: the point is in no socket.
std::string read_socket(const PlanRow& row, const SampleLayout& layout) {
  const CsvField* text = row.field(PlanColumn::kSocket);
  if (text == nullptr) return "";
  if (std::ranges::find(layout.sockets, text->value) != layout.sockets.end()) {
    return text->value;
  }
  throw row.mistake(
      PlanColumn::kSocket, shown(text->value) + " is no socket of the rig file",
      "name a [[socket]], or leave it empty where the tool is in none");
}

/// The three angles of a target's turn, all of them or none.
std::optional<Eigen::Vector3d> read_turn(const PlanRow& row, const geometry::Robot& robot) {
  Eigen::Vector3d turn_rad;
  std::size_t given = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (row.field(PlanColumn::kTurn, i) == nullptr) continue;
    ++given;
    turn_rad[static_cast<Eigen::Index>(i)] =
        geometry::kRadPerDeg * row.number(PlanColumn::kTurn, i);
  }
  if (given == 0) return std::nullopt;
  if (given < 3) {
    throw row.mistake(
        PlanColumn::kTurn, "a turn has three angles", "give all three of a row or none");
  }
  if (!geometry::reaches_any_turn(*robot.model, robot.nominal)) {
    throw row.mistake(
        PlanColumn::kTurn, "this robot cannot turn its tool any way", "leave the turn out");
  }
  return turn_rad;
}

/// Joint values for a target, by nominal inverse kinematics.
Eigen::VectorXd joints_for(
    const PlanRow& row, const geometry::Rig& rig, const PlanPoint& point,
    geometry::WorkingMode mode) {
  const geometry::Robot& robot = rig.robot;
  const geometry::Tool tool(rig);
  const Position& target_mm = point.target_mm;
  const auto place = [&] {
    const auto reference = tool.inverse(robot.nominal, rig.cuboid.reference_pose_mm, mode);
    return tool.inverse(
        robot.nominal, target_mm, mode, reference ? std::optional(*reference) : std::nullopt);
  };
  const auto pose = [&](const Eigen::Vector3d& turn_rad) {
    const Eigen::Matrix3d R = frame_of_angles(rig.instrument.orientation, turn_rad);
    return geometry::joints_for_pose(*robot.model, robot.nominal, {target_mm, R}, mode);
  };
  const auto q = point.target_turn_rad ? pose(*point.target_turn_rad) : place();
  if (q) return *q;
  throw row.mistake(
      PlanColumn::kTarget,
      fmt::format(
          "the robot cannot take ({}) mm in working mode {}: {}", fmt::join(target_mm, ", "),
          robot.model->mode_name(mode), describe(q.error())),
      "move the target into the workspace");
}

PlanPoint read_point(const PlanRow& row, const geometry::Rig& rig, const SampleLayout& layout) {
  constexpr int kMostPoints = 1'000'000'000;
  PlanPoint point;
  if (row.field(PlanColumn::kSet) == nullptr) {
    throw row.mistake(PlanColumn::kSet, "the set is empty", "write G1, G2 or a name");
  }
  point.set = row.field(PlanColumn::kSet)->value;
  point.point = row.integer(PlanColumn::kPoint, 0, kMostPoints, 0);
  point.repeat = row.integer(PlanColumn::kRepeat, 0, kMostPoints, 0);
  if (!layout.sockets.empty()) point.socket = read_socket(row, layout);
  const std::size_t joints = layout.joints.size();
  bool any_joint = false;
  for (std::size_t i = 0; i < joints; ++i) {
    point.approach.push_back(row.integer(PlanColumn::kApproach, -1, 1, 0, i));
    any_joint = any_joint || row.field(PlanColumn::kJoint, i) != nullptr;
  }
  point.target_mm.resize(static_cast<Eigen::Index>(layout.axes.size()));
  for (std::size_t i = 0; i < layout.axes.size(); ++i) {
    point.target_mm[static_cast<Eigen::Index>(i)] = row.number(PlanColumn::kTarget, i);
  }
  if (first_turn(layout)) point.target_turn_rad = read_turn(row, rig.robot);
  const geometry::Robot& robot = rig.robot;
  const auto mode = read_mode(row, rig);
  if (!any_joint) {
    point.q = joints_for(row, rig, point, mode.value_or(robot.working_mode));
    return point;
  }
  point.q.resize(static_cast<Eigen::Index>(joints));
  for (std::size_t i = 0; i < joints; ++i) {
    point.q[static_cast<Eigen::Index>(i)] = row.number(PlanColumn::kJoint, i);
  }
  const auto pose = geometry::Tool(rig).position(robot.nominal, point.q, robot.assembly);
  if (!pose) {
    throw row.mistake(
        PlanColumn::kJoint,
        fmt::format(
            "{} are out of reach: {}", joints_in_words(layout, point.q),
            describe(pose.error())),
        "leave both angles empty to have them computed from the target");
  }
  if (const Branch branch = branch_of(rig, point); mode && branch.mode != *mode) {
    throw row.mistake(
        PlanColumn::kMode,
        fmt::format(
            "the angles are those of working mode {}, the row says {}",
            robot.model->mode_name(branch.mode), robot.model->mode_name(*mode)),
        "leave both angles empty to have them computed in the mode of the row");
  }
  return point;
}

std::string csv_of(const Plan& plan, const SampleLayout& layout, const geometry::Rig* rig) {
  std::string out;
  const bool in_sockets = std::ranges::any_of(
      plan.points, [](const PlanPoint& point) { return !point.socket.empty(); });
  const bool turned = std::ranges::any_of(
      plan.points, [](const PlanPoint& point) { return point.target_turn_rad.has_value(); });
  for (const PlanPlace& each : columns_of(layout)) {
    if (each.column == PlanColumn::kMode && rig == nullptr) continue;
    if (each.column == PlanColumn::kSocket && !in_sockets) continue;
    if (each.column == PlanColumn::kTurn && !turned) continue;
    out += (out.empty() ? "" : ",") + each.name;
  }
  out += '\n';
  for (const PlanPoint& point : plan.points) {
    out += fmt::format("{},{},{}", csv_field(point.set), point.point, point.repeat);
    if (in_sockets) out += ',' + csv_field(point.socket);
    for (const double each_mm : point.target_mm) out += ',' + decimal(each_mm, 6);
    for (Eigen::Index i = 0; turned && i < 3; ++i) {
      out += ',';
      if (point.target_turn_rad) {
        out += decimal(geometry::kDegPerRad * (*point.target_turn_rad)[i], 9);
      }
    }
    for (const double each : point.q) out += ',' + decimal(each, 9);
    for (std::size_t i = 0; i < layout.joints.size(); ++i) {
      out += fmt::format(",{}", approach_of(point, i));
    }
    if (rig != nullptr)
      out += ',' + std::string(rig->robot.model->mode_name(branch_of(*rig, point).mode));
    out += '\n';
  }
  return out;
}

}  // namespace

int approach_of(const PlanPoint& point, std::size_t joint) {
  return joint < point.approach.size() ? point.approach[joint] : 0;
}

bool operator==(const PlanPoint& a, const PlanPoint& b) {
  const auto same = [](const auto& x, const auto& y) {
    return std::ranges::equal(x, y);  // Eigen's own needs equal sizes
  };
  if (a.set != b.set || a.point != b.point || a.repeat != b.repeat) return false;
  if (a.socket != b.socket || a.target_turn_rad != b.target_turn_rad) return false;
  if (!same(a.target_mm, b.target_mm) || !same(a.q, b.q)) return false;
  for (std::size_t i = 0; i < std::max(a.approach.size(), b.approach.size()); ++i) {
    if (approach_of(a, i) != approach_of(b, i)) return false;
  }
  return true;
}

Plan parse_plan(std::string_view text, const std::string& file_name, const geometry::Rig& rig) {
  const CsvTable table = read_csv(text, file_name);
  const SampleLayout layout = layout_of(rig);
  const std::vector<PlanPlace> places = read_plan_header(table.header, file_name, layout);
  Plan plan;
  std::vector<Mistake> mistakes;
  std::size_t total = 0;
  std::map<std::tuple<std::string, int, int>, int> keys;
  for (const CsvRow& row : table.rows) {
    try {
      if (row.fault) throw Mistake(*row.fault);
      if (row.fields.size() != table.header.fields.size()) {
        throw Mistake{
            row.line, row.fields.back().column, "",
            fmt::format(
                "the row has {} fields, the header has {}", row.fields.size(),
                table.header.fields.size()),
            "leave an empty field where there is no value"};
      }
      const PlanRow reader(row, places);
      PlanPoint point = read_point(reader, rig, layout);
      const auto [found, fresh] =
          keys.emplace(std::tuple(point.set, point.point, point.repeat), row.line);
      if (!fresh) {
        throw reader.mistake(
            PlanColumn::kPoint,
            fmt::format(
                "set {}, point {}, repeat {} stands in line {} already", point.set, point.point,
                point.repeat, found->second),
            "number repeats 0, 1, 2 ...");
      }
      plan.points.push_back(std::move(point));
    } catch (const Mistake& mistake) {
      ++total;
      if (mistakes.size() < DataError::kMostShown) mistakes.push_back(mistake);
    }
  }
  if (total > 0) throw DataError(file_name, std::move(mistakes), total);
  if (plan.points.empty()) {
    throw DataError(file_name, Mistake{1, 1, "", "the plan has no points", "add a row each"});
  }
  return plan;
}

Plan read_plan(const std::string& path, const geometry::Rig& rig) {
  return parse_plan(read_file(path), path, rig);
}

std::string plan_csv(const Plan& plan, const SampleLayout& layout) {
  return csv_of(plan, layout, nullptr);
}
std::string plan_csv(const Plan& plan, const geometry::Rig& rig) {
  return csv_of(plan, layout_of(rig), &rig);
}

}  // namespace sixdial::session
