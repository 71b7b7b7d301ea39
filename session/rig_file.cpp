#include "session/rig_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include "geometry/instrument_kind.h"
#include "geometry/units.h"
#include "session/csv.h"
#include "session/plain_text.h"
#include "session/rig_deviations.h"
#include "session/rig_figures.h"
#include "session/rig_instrument.h"
#include "session/toml_checks.h"
#include "session/toml_text.h"

namespace sixdial::session {
namespace {

using geometry::Dial;
using geometry::kRadPerDeg;
using geometry::Rig;

const std::vector<std::string> kTopKeys{
    "name",   "tolerance_mm", "operator", "robot",  "joint", "instrument", "tool_point",
    "anchor", "socket",       "surface",  "cuboid", "dials", "dial",       "thermometer"};

std::vector<std::string> robot_keys(const geometry::RobotModel& robot) {
  std::vector<std::string> keys{"model", "working_mode", "assembly", "connection"};
  for (const auto& info : robot.parameters) {
    if (!info.rig_key.empty()) keys.push_back(info.rig_key);
  }
  for (const std::string_view key : robot.kind->file_keys) keys.emplace_back(key);
  return traced(std::move(keys));
}

/// "++", "+-", "-+" or "--"
std::string alternatives(
    const std::vector<geometry::BranchInfo>& branches, auto text_of,
    const char* last = " or ") {
  std::string result;
  for (std::size_t i = 0; i < branches.size(); ++i) {
    if (i > 0) result += i + 1 < branches.size() ? ", " : last;
    result += text_of(branches[i]);
  }
  return result;
}

/// The keys of [cuboid], those of its certificate with them.
std::vector<std::string> cuboid_keys() {
  std::vector<std::string> keys{"side_mm", "mount", "reference_pose_mm"};
  keys.insert(keys.end(), cuboid_deviation_keys().begin(), cuboid_deviation_keys().end());
  return traced(std::move(keys));
}

std::vector<std::string> dials_keys() {
  std::vector<std::string> keys{"connection"};
  for (const DialFigure& figure : kDialFigures) keys.emplace_back(figure.key);
  keys.insert(keys.end(), dial_deviation_keys().begin(), dial_deviation_keys().end());
  return keys;
}

std::vector<std::string> dial_keys() {
  std::vector<std::string> keys = dials_keys();
  keys.insert(keys.end(), {"id", "position_mm", "axis"});
  return traced(std::move(keys));
}

geometry::FileValue file_value(const toml::node& node) {
  geometry::FileValue result;
  if (const auto* from = node.as_table()) {
    geometry::FileValue::Table table;
    for (const auto& [key, value] : *from) table[std::string(key.str())] = file_value(value);
    result.value = std::move(table);
  } else if (const auto* list = node.as_array()) {
    std::vector<geometry::FileValue> values;
    for (const toml::node& each : *list) values.push_back(file_value(each));
    result.value = std::move(values);
  } else if (const auto flag = node.value_exact<bool>()) {
    result.value = *flag;
  } else if (node.is_number()) {
    result.value = node.value<double>().value_or(0.0);
  } else {
    result.value = node.value<std::string>().value_or("");
  }
  return result;
}

/// [robot] and [[joint]] as a robot kind reads them.
geometry::RobotFile robot_file(
    const toml::table& top, const toml::table& robot, const std::string& file_name) {
  geometry::RobotFile result;
  result.robot = std::get<geometry::FileValue::Table>(file_value(robot).value);
  if (const auto* joints = top.get_as<toml::array>("joint")) {
    for (const toml::node& each : *joints) {
      if (!each.is_table()) continue;
      result.joints.push_back(std::get<geometry::FileValue::Table>(file_value(each).value));
    }
  }
  const auto folder = std::filesystem::path(file_name).parent_path();
  result.text_beside = [folder](const std::string& name) {
    return read_file((folder / name).string());
  };
  return result;
}

class RigReader : InstrumentChecks {
 public:
  explicit RigReader(std::string file_name) : InstrumentChecks(std::move(file_name)) {}

  Rig read(const toml::table& top) {
    known_keys(top, "the top level", kTopKeys);
    Rig rig;
    rig.name = text(top, "", "name", "");
    if (top.get("tolerance_mm") != nullptr) {
      length(top, "", "tolerance_mm", false, rig.tolerance_mm.emplace());
    }
    const toml::table* robot = table(top, "robot");
    static_cast<void>(text(top, "", "operator", ""));
    if (robot != nullptr) {
      read_robot(top, *robot, rig.robot);
      check_trace(*robot, "[robot]");
    }
    if (top.get("thermometer") != nullptr) {
      if (const toml::table* from = table(top, "thermometer")) {
        known_keys(*from, "[thermometer]", traced({}));
        check_trace(*from, "[thermometer]");
      }
    }
    rig.instrument.dimensions = rig.robot.model->axes;
    read_instrument(top, rig.instrument);
    const bool on_cuboid = rig.instrument.kind == geometry::Instrument{}.kind;
    const toml::table* cuboid =
        on_cuboid || top.get("cuboid") != nullptr ? table(top, "cuboid") : nullptr;
    if (cuboid != nullptr) read_cuboid(*cuboid, rig.cuboid);
    read_dials(top, rig);
    stop_if_faulty();
    check_instrument(top, rig);
    if (robot != nullptr && cuboid != nullptr) check_reference_pose(rig, *robot, *cuboid);
    stop_if_faulty();
    return rig;
  }

 private:
  void read_robot(const toml::table& top, const toml::table& from, geometry::Robot& robot) {
    const std::string where = "[robot]";
    read_model(top, from, robot);
    const geometry::RobotModel& model = *robot.model;
    known_keys(from, where, robot_keys(model));
    robot.nominal = model.nominal;
    read_branches(from, robot);
    robot.connection = text(from, where, "connection", "");
    for (std::size_t i = 0; i < model.parameters.size(); ++i) {
      const geometry::ParameterInfo& info = model.parameters[i];
      const bool absent = from.get(info.rig_key) == nullptr;
      if (info.rig_key.empty() || (info.optional && absent)) continue;
      double& nominal = robot.nominal[static_cast<Eigen::Index>(i)];
      if (info.range != geometry::FileRange::kAny) {
        length(
            from, where, info.rig_key, info.range == geometry::FileRange::kNotNegative,
            nominal);
      } else if (const auto value = number(from, where, info.rig_key)) {
        nominal = info.shown_unit == "deg" ? *value * kRadPerDeg : *value;
      }
    }
  }

  /// The kind that `model` names, and what its own keys make of it.
  void read_model(const toml::table& top, const toml::table& from, geometry::Robot& robot) {
    const std::string name = text(from, "[robot]", "model", "five_bar");
    const geometry::RobotKind* kind = geometry::find_robot_kind(name);
    if (kind == nullptr) {
      std::string known;
      for (const geometry::RobotKind* each : geometry::robot_kinds()) {
        known += fmt::format("{}\"{}\"", known.empty() ? "" : ", ", each->name);
      }
      fault(
          from.get("model")->source(), "model", "is not a known robot",
          fmt::format(
              "{} {}",
              geometry::robot_kinds().size() == 1 ? "the known model is"
                                                  : "the known models are",
              known));
      return;
    }
    robot.model = kind->example();
    if (kind->from_file == nullptr) return;
    auto made = kind->from_file(robot_file(top, from, file()));
    if (made) {
      robot.model = *std::move(made);
    } else {
      const geometry::RobotFileFault& wrong = made.error();
      const toml::table* place = &from;
      if (const auto* joints = top.get_as<toml::array>("joint"); joints && wrong.joint) {
        if (const auto* row = joints->get_as<toml::table>(*wrong.joint)) place = row;
      }
      const toml::node* node = place->get(wrong.key);
      fault(
          node != nullptr ? node->source() : place->source(), wrong.key, wrong.what,
          wrong.hint);
    }
  }

  /// working_mode and assembly; a kind that has one of each needs neither key.
  void read_branches(const toml::table& from, geometry::Robot& robot) {
    const auto& modes = robot.model->modes;
    if (const toml::node* node = from.get("working_mode")) {
      const std::string given = text(from, "[robot]", "working_mode", modes[0].name);
      const auto found = std::ranges::find(modes, given, &geometry::BranchInfo::name);
      if (found != modes.end()) {
        robot.working_mode = geometry::WorkingMode(found->number);
      } else {
        const auto quoted = [](const auto& mode) { return '"' + mode.name + '"'; };
        fault(
            node->source(), "working_mode", "is not a working mode",
            fmt::format(
                "write {}{}{}", alternatives(modes, quoted),
                robot.model->mode_in_words.empty() ? "" : ": ", robot.model->mode_in_words));
      }
    } else if (modes.size() > 1) {
      missing(from, "[robot]", "working_mode");
    } else {
      robot.working_mode = geometry::WorkingMode(modes[0].number);
    }
    const auto& assemblies = robot.model->assemblies;
    if (const toml::node* node = from.get("assembly")) {
      const auto given = node->value_exact<std::int64_t>();
      const auto found = std::ranges::find_if(
          assemblies, [&](const auto& each) { return given && *given == each.number; });
      if (found != assemblies.end()) {
        robot.assembly = static_cast<geometry::Assembly>(found->number);
      } else {
        const auto number = [](const auto& each) { return std::to_string(each.number); };
        fault(
            node->source(), "assembly",
            "is neither " + alternatives(assemblies, number, " nor "),
            "write " + alternatives(assemblies, number));
      }
    } else if (assemblies.size() > 1) {
      missing(from, "[robot]", "assembly");
    } else {
      robot.assembly = static_cast<geometry::Assembly>(assemblies[0].number);
    }
  }

  /// [instrument]; without it, dials on a cuboid, or positions where there is neither a cuboid
  /// nor a dial.
  void read_instrument(const toml::table& top, geometry::Instrument& instrument) {
    if (top.get("instrument") == nullptr) {
      const bool bare = top.get("cuboid") == nullptr && top.get("dial") == nullptr &&
                        top.get("dials") == nullptr && !near_a_table(top);
      if (bare) instrument.kind = "position";
      return;
    }
    read_instrument_tables(top, instrument);
  }

  /// Whether some top-level name is none that a rig file knows: it may be a misspelt table.
  static bool near_a_table(const toml::table& top) {
    return std::ranges::any_of(top, [](const auto& each) {
      return std::ranges::find(kTopKeys, std::string(each.first.str())) == kTopKeys.end();
    });
  }

  void read_cuboid(const toml::table& from, geometry::Cuboid& cuboid) {
    const std::string where = "[cuboid]";
    known_keys(from, where, cuboid_keys());
    check_trace(from, where);
    length(from, where, "side_mm", false, cuboid.side_mm);
    const std::string mount = text(from, where, "mount", "distal2");
    if (mount == "distal1") {
      cuboid.mount = geometry::Mount::kDistal1;
    } else if (mount == "distal2") {
      cuboid.mount = geometry::Mount::kDistal2;
    } else if (mount == "free") {
      cuboid.mount = geometry::Mount::kFree;
    } else {
      fault(
          from.get("mount")->source(), "mount", shown(mount) + " is not a mount",
          "write \"distal1\", \"distal2\" or \"free\"");
    }
    read_deviations(from, where, cuboid.deviations);
    if (cuboid.mount == geometry::Mount::kFree && from.get("reference_pose_mm") == nullptr)
      return;
    if (const auto pose = pair(from, where, "reference_pose_mm"))
      cuboid.reference_pose_mm = *pose;
  }

  void read_dials(const toml::table& top, Rig& rig) {
    const toml::node* list = top.get("dial");
    const toml::table* common = nullptr;
    if (top.get("dials") != nullptr) common = table(top, "dials");
    geometry::DialDeviations deviations;
    if (common != nullptr) {
      known_keys(*common, "[dials]", dials_keys());
      read_deviations(*common, "[dials]", deviations);
      Dial checked;
      for (const DialFigure& figure : kDialFigures) {
        if (common->get(figure.key) == nullptr) continue;
        length(*common, "[dials]", figure.key, figure.zero_allowed, figure.of(checked));
      }
    }
    if (list == nullptr) return;
    const toml::array* array = list->as_array();
    if (array == nullptr || !array->is_array_of_tables()) {
      fault(
          list->source(), "dial", "is not a list of dials", "write [[dial]] before each dial");
      return;
    }
    std::set<std::string> ids;
    for (const toml::node& node : *array) {
      rig.dials.push_back(read_dial(*node.as_table(), common, ids, rig.on_cuboid()));
      geometry::DialDeviations& own = rig.dials.back().deviations;
      own = deviations;
      read_deviations(*node.as_table(), "[[dial]]", own);
    }
  }

  /// Where it stands on the table is asked of dials on a cuboid only.
  Dial read_dial(
      const toml::table& from, const toml::table* common, std::set<std::string>& ids,
      bool on_cuboid) {
    Dial dial;
    const std::string where = "[[dial]]";
    known_keys(from, where, dial_keys());
    check_trace(from, where);
    if (from.get("id") == nullptr) {
      missing(from, where, "id");
    } else {
      dial.id = text(from, where, "id", "");
      check_id(dial.id, from.get("id")->source(), ids);
    }
    const auto asked = [&](const char* key) { return on_cuboid || from.get(key) != nullptr; };
    if (asked("position_mm")) {
      dial.geometry.position_mm =
          pair(from, where, "position_mm").value_or(dial.geometry.position_mm);
    }
    if (asked("axis")) {
      if (const auto axis = pair(from, where, "axis")) {
        dial.geometry.axis = unit_axis(*axis, from.get("axis")->source());
      }
    }
    for (const DialFigure& figure : kDialFigures) {
      const bool own = from.get(figure.key) != nullptr;
      const bool shared = common != nullptr && common->get(figure.key) != nullptr;
      if (own) {
        length(from, where, figure.key, figure.zero_allowed, figure.of(dial));
      } else if (shared) {
        figure.of(dial) = common->get(figure.key)->value<double>().value_or(figure.of(dial));
      } else if (figure.required && (on_cuboid || figure.key != kTipRadius)) {
        fault(
            from.source(), figure.key, "missing in [[dial]] and in [dials]",
            "add it to [dials], for all dials, or here");
      }
    }
    const std::string shared_connection =
        common == nullptr ? "" : text(*common, "[dials]", "connection", "");
    dial.connection = text(from, where, "connection", shared_connection);
    return dial;
  }

  void check_id(
      const std::string& id, const toml::source_region& where, std::set<std::string>& ids) {
    constexpr std::string_view kAllowed =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
    if (id.empty() || id.size() > 32 || id.find_first_not_of(kAllowed) != std::string::npos) {
      fault(
          where, "id", shown(id) + " cannot name a dial",
          "use 1 to 32 letters, digits, _ or -: it becomes the column dial_<id>_mm");
    } else if (!ids.insert(id).second) {
      fault(
          where, "id", fmt::format("dial '{}' appears twice", id),
          "give each dial an id of its own");
    }
  }

  Eigen::Vector2d unit_axis(const Eigen::Vector2d& axis, const toml::source_region& where) {
    constexpr double kExact = 1e-6;
    constexpr double kRounded = 1e-3;
    const double length = axis.norm();
    if (std::abs(length - 1.0) <= kExact) return axis;
    if (std::abs(length - 1.0) <= kRounded) return axis / length;
    fault(
        where, "axis", fmt::format("has length {:.6g}", length),
        "give a unit vector from the dial towards the cuboid, such as [0, 1]");
    return {1, 0};
  }

  void check_reference_pose(
      const Rig& rig, const toml::table& robot, const toml::table& cuboid) {
    if (rig.cuboid.mount == geometry::Mount::kFree) return;  // gamma does not come from it
    if (rig.robot.model->kind != &geometry::five_bar) return;
    const geometry::Robot& r = rig.robot;
    const auto& target = rig.cuboid.reference_pose_mm;
    const auto q = geometry::inverse(r.nominal, target, r.working_mode);
    const auto assembly =
        q ? geometry::assembly_at(r.nominal, *q, target) : tl::unexpected(q.error());
    if (!assembly) {
      fault(
          cuboid.get("reference_pose_mm")->source(), "reference_pose_mm",
          std::string(describe(assembly.error())),
          "give a pose that the nominal robot can take in its working mode");
    } else if (*assembly != r.assembly) {
      fault(
          robot.get("assembly")->source(), "assembly",
          fmt::format(
              "{} does not put the tool at the reference pose in working mode {}",
              static_cast<int>(r.assembly), to_string(r.working_mode)),
          fmt::format("it is {} there", static_cast<int>(*assembly)));
    }
  }
};

}  // namespace

geometry::Rig parse_rig(std::string_view text, const std::string& file_name) {
  check_is_plain(text, file_name);
  if (auto mistake = stray_character(text)) throw DataError(file_name, std::move(*mistake));
  try {
    const toml::table top = toml::parse(text);
    return RigReader(file_name).read(top);
  } catch (const toml::parse_error& error) {
    const auto& where = error.source().begin;
    throw DataError(
        file_name, Mistake{
                       static_cast<int>(where.line), static_cast<int>(where.column), "",
                       std::string(error.description()), "mend the TOML syntax there"});
  }
}

geometry::Rig read_rig_file(const std::string& path) {
  return parse_rig(read_file(path), path);
}

}  // namespace sixdial::session
