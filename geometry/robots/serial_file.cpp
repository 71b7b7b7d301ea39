// What rig.toml says of an arm, and back: [[joint]] rows, or a URDF beside it.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "geometry/robots/serial_chain.h"
#include "geometry/units.h"

namespace sixdial::geometry::serial_chain {
namespace {

using Eigen::Vector3d;
using Table = FileValue::Table;

constexpr std::array<std::string_view, 17> kRowKeys{
    "name",     "kind",       "a_mm",           "alpha_deg",       "d_mm",    "theta_deg",
    "beta_deg", "origin_mm",  "origin_rpy_deg", "origin_turn_deg", "axis",    "follows",
    "ratio",    "offset_deg", "offset_mm",      "low_deg",         "high_deg"};
constexpr std::array<std::string_view, 2> kLimitKeys{"low_mm", "high_mm"};

constexpr std::string_view kAxes = "xyz";

struct Convention {
  std::string_view name;
  RowForm form;
};
constexpr std::array kConventions{
    Convention{"dh", RowForm::kDh}, Convention{"modified_dh", RowForm::kModifiedDh},
    Convention{"origins", RowForm::kOrigin}};

std::string quoted(const std::string& text) {
  return std::string(1, '"').append(text).append(1, '"');
}

/// Reads keys of one table; the first that cannot be used is thrown as a RobotFileFault, which
/// from_file gives back.
class Reader {
 public:
  explicit Reader(const Table& table, std::optional<std::size_t> joint = std::nullopt)
      : table_(table), joint_(joint) {}

  [[noreturn]] void refuse(std::string key, std::string what, std::string hint) const {
    throw RobotFileFault{std::move(key), std::move(what), std::move(hint), joint_};
  }
  [[nodiscard]] bool has(std::string_view key) const { return table_.contains(key); }

  [[nodiscard]] double number(std::string_view key, double otherwise) const {
    const auto at = table_.find(key);
    if (at == table_.end()) return otherwise;
    const double* value = std::get_if<double>(&at->second.value);
    if (value == nullptr || !std::isfinite(*value)) {
      refuse(std::string(key), "is not a number", "write one, such as 12.5");
    }
    return key.ends_with("_deg") ? *value * kRadPerDeg : *value;
  }
  [[nodiscard]] std::string text(std::string_view key, const std::string& otherwise) const {
    const auto at = table_.find(key);
    if (at == table_.end()) return otherwise;
    const auto* value = std::get_if<std::string>(&at->second.value);
    if (value == nullptr) refuse(std::string(key), "is not text", "put it in quotes");
    return *value;
  }
  /// Three numbers in a list.
  [[nodiscard]] Vector3d triple(std::string_view key, const Vector3d& otherwise) const {
    const auto at = table_.find(key);
    if (at == table_.end()) return otherwise;
    const auto* list = std::get_if<std::vector<FileValue>>(&at->second.value);
    Vector3d result = Vector3d::Zero();
    bool good = list != nullptr && list->size() == 3;
    for (std::size_t i = 0; good && i < 3; ++i) {
      const double* value = std::get_if<double>(&(*list)[i].value);
      good = value != nullptr && std::isfinite(*value);
      if (good) result[static_cast<Eigen::Index>(i)] = *value;
    }
    if (!good) refuse(std::string(key), "is not a list of three numbers", "write [x, y, z]");
    return key.ends_with("_deg") ? Vector3d(result * kRadPerDeg) : result;
  }
  /// Three numbers with keys of their own: "base_x_mm" ...
  [[nodiscard]] Vector3d keys(const std::string& front, const std::string& back) const {
    Vector3d result;
    for (Eigen::Index i = 0; i < 3; ++i) {
      std::string key = front;
      key += kAxes[static_cast<std::size_t>(i)];
      key += back;
      result[i] = number(key, 0.0);
    }
    return result;
  }
  /// One of these words.
  [[nodiscard]] std::size_t word(
      std::string_view key, std::initializer_list<std::string_view> words) const {
    const std::string given = text(key, std::string(*words.begin()));
    const auto* const found = std::ranges::find(words, given);
    if (found == words.end()) {
      std::string list;
      for (const std::string_view each : words) {
        list.append(list.empty() ? "\"" : ", \"").append(each).append("\"");
      }
      refuse(
          std::string(key), quoted(given).append(" is none of its values"),
          std::string("write one of ").append(list));
    }
    return static_cast<std::size_t>(found - words.begin());
  }
  void only(std::string_view not_with, std::initializer_list<std::string_view> keys) const {
    for (const std::string_view key : keys) {
      if (has(key)) {
        refuse(
            std::string(key), "is no key of a row in the convention " + std::string(not_with),
            "take it out, or change `convention` in [robot]");
      }
    }
  }

 private:
  const Table& table_;
  std::optional<std::size_t> joint_;
};

/// Roll, pitch and yaw of a URDF: turns about the fixed axes x, y, z.
Vector3d turn_of_rpy(const Vector3d& rpy) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  turn_about<double>(R, 2, rpy.z());
  turn_about<double>(R, 1, rpy.y());
  turn_about<double>(R, 0, rpy.x());
  return rotation_vector(R);
}

void read_place(const Reader& from, SerialRow& row) {
  if (row.form != RowForm::kOrigin) {
    from.only(
        row.form == RowForm::kDh ? "dh" : "modified_dh",
        {"origin_mm", "origin_rpy_deg", "origin_turn_deg", "axis"});
    row.a_mm = from.number("a_mm", 0.0);
    row.alpha_rad = from.number("alpha_deg", 0.0);
    row.d_mm = from.number("d_mm", 0.0);
    row.theta_rad = from.number("theta_deg", 0.0);
    row.beta_rad = from.number("beta_deg", 0.0);
    return;
  }
  from.only("origins", {"a_mm", "alpha_deg", "d_mm", "theta_deg", "beta_deg"});
  row.origin_mm = from.triple("origin_mm", Vector3d::Zero());
  if (from.has("origin_rpy_deg") && from.has("origin_turn_deg")) {
    from.refuse("origin_rpy_deg", "says the same as origin_turn_deg", "leave one of them out");
  }
  row.turn_rad = from.has("origin_rpy_deg")
                     ? turn_of_rpy(from.triple("origin_rpy_deg", Vector3d::Zero()))
                     : from.triple("origin_turn_deg", Vector3d::Zero());
  const auto axis = unit_axis(from.triple("axis", Vector3d::UnitZ()));
  if (!axis) from.refuse("axis", "has no direction", "write one, such as [0, 0, 1]");
  row.axis = *axis;
}

SerialRow read_row(const Table& table, std::size_t index, RowForm form) {
  const Reader from(table, index);
  for (const auto& [key, value] : table) {
    const bool known = std::ranges::find(kRowKeys, key) != kRowKeys.end() ||
                       std::ranges::find(kLimitKeys, key) != kLimitKeys.end();
    if (known) continue;
    std::string all;
    for (const std::string_view each : kRowKeys) {
      all.append(all.empty() ? "" : ", ").append(each);
    }
    from.refuse(key, "is not a key of [[joint]]", std::string("known are ").append(all));
  }
  SerialRow row;
  row.form = form;
  row.name = from.text("name", std::string(1, 'q').append(std::to_string(index + 1)));
  if (!can_name_a_joint(row.name)) {
    from.refuse("name", "cannot name a joint", "use letters, digits and _: it names a column");
  }
  const bool slides = from.word("kind", {"revolute", "prismatic"}) == 1;
  row.kind = slides ? JointKind::kPrismatic : JointKind::kRevolute;
  read_place(from, row);
  const std::string unit = slides ? "_mm" : "_deg";
  const std::string other = slides ? "_deg" : "_mm";
  for (const char* const key : {"low", "high", "offset"}) {
    if (from.has(key + other)) {
      from.refuse(
          std::string(key).append(other),
          std::string("has the wrong unit for a ")
              .append(slides ? "prismatic joint" : "revolute joint"),
          std::string("write ").append(key).append(unit));
    }
  }
  if (from.has("low" + unit)) row.low = from.number("low" + unit, 0.0);
  if (from.has("high" + unit)) row.high = from.number("high" + unit, 0.0);
  if (row.low && row.high && !is_range(*row.low, *row.high)) {
    from.refuse("high" + unit, "is not above low" + unit, "exchange them");
  }
  row.follows = from.text("follows", "");
  row.ratio = from.number("ratio", 1.0);
  row.offset = from.number("offset" + unit, 0.0);
  return row;
}

SerialRobot read_arm(const RobotFile& file) {
  const Reader from(file.robot);
  SerialRobot arm;
  if (from.has("urdf")) {
    if (!file.joints.empty()) {
      from.refuse("urdf", "stands beside [[joint]] rows", "leave one of them out");
    }
    const std::string name = from.text("urdf", "");
    auto read = read_urdf(file.text_beside(name), from.text("base", ""), from.text("tip", ""));
    if (!read) {
      from.refuse(
          "urdf", quoted(name).append(" ").append(read.error()),
          "mend it, or give [[joint]] rows");
    }
    arm = *std::move(read);
    arm.from_other_file = true;
  } else {
    const std::size_t which = from.word(
        "convention", {kConventions[0].name, kConventions[1].name, kConventions[2].name});
    if (file.joints.empty()) {
      from.refuse(
          "model", "\"serial\" needs joints",
          "add a [[joint]] table for each joint, or urdf = \"arm.urdf\"");
    }
    for (std::size_t i = 0; i < file.joints.size(); ++i) {
      arm.rows.push_back(read_row(file.joints[i], i, kConventions[which].form));
    }
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < arm.rows.size(); ++i) {
    if (names.insert(arm.rows[i].name).second) continue;
    throw RobotFileFault{
        "name", quoted(arm.rows[i].name).append(" appears twice"), "give each joint its own",
        i};
  }
  arm.base_mm = from.keys("base_", "_mm");
  arm.base_turn_rad = from.keys("base_r", "_deg");
  arm.tool_mm += from.keys("tool_", "_mm");
  if (from.has("tool_rx_deg") || from.has("tool_ry_deg") || from.has("tool_rz_deg")) {
    arm.tool_turn_rad = from.keys("tool_r", "_deg");
  }
  arm.tool_is_frame = from.word("tool", {"point", "frame"}) == 1;
  arm.all_parameters = from.word("parameters", {"independent", "all"}) == 1;
  return arm;
}

FileValue number(double value) { return {value}; }
FileValue text(std::string value) { return {std::move(value)}; }
FileValue triple(const Vector3d& value) {
  return {std::vector<FileValue>{number(value[0]), number(value[1]), number(value[2])}};
}

Table row_table(const SerialRow& row) {
  Table table;
  table["name"] = text(row.name);
  const bool slides = row.kind == JointKind::kPrismatic;
  if (slides) table["kind"] = text("prismatic");
  const std::string unit = slides ? "_mm" : "_deg";
  if (row.form == RowForm::kOrigin) {
    table["origin_mm"] = triple(row.origin_mm);
    table["origin_turn_deg"] = triple(row.turn_rad);
    table["axis"] = triple(row.axis);
  } else {
    table["a_mm"] = number(row.a_mm);
    table["alpha_deg"] = number(row.alpha_rad);
    table["d_mm"] = number(row.d_mm);
    table["theta_deg"] = number(row.theta_rad);
    if (row.beta_rad != 0.0) table["beta_deg"] = number(row.beta_rad);
  }
  if (row.low) table["low" + unit] = number(*row.low);
  if (row.high) table["high" + unit] = number(*row.high);
  if (row.follows.empty()) return table;
  table["follows"] = text(row.follows);
  table["ratio"] = number(row.ratio);
  table["offset" + unit] = number(row.offset);
  return table;
}

}  // namespace

tl::expected<std::shared_ptr<const RobotModel>, RobotFileFault> from_file(
    const RobotFile& file) {
  try {
    return serial_model(read_arm(file));
  } catch (RobotFileFault& fault) {
    return tl::unexpected(std::move(fault));
  }
}

RobotFileText to_file(const RobotModel& robot, const Eigen::VectorXd& nominal) {
  const SerialRobot arm = serial_robot(robot, nominal);
  RobotFileText out;
  const auto* const convention =
      std::ranges::find(kConventions, arm.rows.front().form, &Convention::form);
  out.robot["convention"] = text(std::string(convention->name));
  if (arm.tool_is_frame) out.robot["tool"] = text("frame");
  if (arm.all_parameters) out.robot["parameters"] = text("all");
  const auto add = [&](const std::string& key, double value) {
    const bool own = std::ranges::any_of(
        robot.parameters, [&](const ParameterInfo& each) { return each.rig_key == key; });
    if (!own && value != 0.0) out.robot[key] = number(value);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    add(std::string("tool_").append(1, kAxes[i]).append("_mm"), arm.tool_mm[k]);
    add(std::string("tool_r").append(1, kAxes[i]).append("_deg"), arm.tool_turn_rad[k]);
  }
  for (const SerialRow& row : arm.rows) out.joints.push_back(row_table(row));
  return out;
}

}  // namespace sixdial::geometry::serial_chain
