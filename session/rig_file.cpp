#include "session/rig_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "geometry/units.h"
#include "session/csv.h"
#include "session/toml_text.h"

namespace sixdial::session {
namespace {

using geometry::Dial;
using geometry::kRadPerDeg;
using geometry::Rig;

// Figures that [dials] gives for all and a [[dial]] may override.
struct Figure {
  const char* key;
  double& (*of)(Dial& dial);
  bool required;
  bool zero_allowed;
};
constexpr std::array<Figure, 7> kFigures{{
    {"travel_mm", [](Dial& d) -> double& { return d.geometry.travel_mm; }, true, false},
    {"resolution_mm", [](Dial& d) -> double& { return d.resolution_mm; }, true, false},
    {"accuracy_mm", [](Dial& d) -> double& { return d.accuracy_mm; }, false, true},
    {"repeatability_mm", [](Dial& d) -> double& { return d.repeatability_mm; }, true, true},
    {"tip_radius_mm", [](Dial& d) -> double& { return d.geometry.tip_radius_mm; }, true, true},
    {"force_n", [](Dial& d) -> double& { return d.force_n; }, false, true},
    {"spring_n_per_mm", [](Dial& d) -> double& { return d.spring_n_per_mm; }, false, true},
}};

const std::vector<std::string> kTopKeys{"name", "robot", "cuboid", "dials", "dial"};

std::vector<std::string> robot_keys() {
  std::vector<std::string> keys{"model", "working_mode", "assembly", "connection"};
  for (const auto& info : geometry::kParameters) keys.emplace_back(info.rig_key);
  return keys;
}

const std::vector<std::string> kCuboidKeys{"side_mm", "mount", "reference_pose_mm"};

std::vector<std::string> dials_keys() {
  std::vector<std::string> keys{"connection"};
  for (const Figure& figure : kFigures) keys.emplace_back(figure.key);
  return keys;
}

std::vector<std::string> dial_keys() {
  std::vector<std::string> keys = dials_keys();
  keys.insert(keys.end(), {"id", "position_mm", "axis"});
  return keys;
}

class RigReader {
 public:
  explicit RigReader(std::string file_name) : file_(std::move(file_name)) {}

  Rig read(const toml::table& top) {
    known_keys(top, "the top level", kTopKeys);
    Rig rig;
    rig.name = text(top, "", "name", "");
    const toml::table* robot = table(top, "robot");
    const toml::table* cuboid = table(top, "cuboid");
    if (robot != nullptr) read_robot(*robot, rig.robot);
    if (cuboid != nullptr) read_cuboid(*cuboid, rig.cuboid);
    read_dials(top, rig);
    stop_if_faulty();
    if (robot != nullptr && cuboid != nullptr) check_reference_pose(rig, *robot, *cuboid);
    stop_if_faulty();
    return rig;
  }

 private:
  void fault(
      const toml::source_region& where, std::string field, std::string what, std::string hint) {
    findings_.push_back(
        {static_cast<int>(where.begin.line), static_cast<int>(where.begin.column),
         std::move(field), std::move(what), std::move(hint)});
  }

  void stop_if_faulty() {
    std::sort(unknown_.begin(), unknown_.end(), [](const Finding& a, const Finding& b) {
      return std::pair(a.line, a.column) < std::pair(b.line, b.column);
    });
    findings_.insert(findings_.begin(), unknown_.begin(), unknown_.end());
    if (findings_.empty()) return;
    const std::size_t total = findings_.size();
    throw DataError(file_, std::move(findings_), total);
  }

  void known_keys(
      const toml::table& from, const std::string& where,
      const std::vector<std::string>& known) {
    for (const auto& [key, node] : from) {
      const std::string name(key.str());
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      const auto& place = key.source().begin;
      unknown_.push_back(
          {static_cast<int>(place.line), static_cast<int>(place.column), shown_key(name),
           "unknown key in " + where,
           fmt::format("the nearest known key is '{}'", nearest_word(name, known))});
    }
  }

  static std::string shown_key(const std::string& name) {
    return name.size() <= 60 ? name : name.substr(0, 57) + "...";
  }

  void missing(const toml::table& from, const std::string& where, const std::string& key) {
    fault(from.source(), key, "missing in " + where, "add it: every rig file needs it");
  }

  const toml::table* table(const toml::table& top, const std::string& key) {
    const toml::node* node = top.get(key);
    if (node == nullptr) {
      fault({}, key, fmt::format("there is no [{}] table", key), "every rig file needs it");
      return nullptr;
    }
    if (!node->is_table()) {
      fault(node->source(), key, "is not a table", fmt::format("write [{}] on a line", key));
      return nullptr;
    }
    return node->as_table();
  }

  /// Text of `key`; `otherwise` if it is absent.
  std::string text(
      const toml::table& from, const std::string& where, const char* key,
      const std::string& otherwise) {
    const toml::node* node = from.get(key);
    if (node == nullptr) return otherwise;
    if (const auto value = node->value_exact<std::string>()) return *value;
    fault(
        node->source(), key,
        where.empty() ? "is not text" : fmt::format("is not text in {}", where),
        "write it in quotes");
    return otherwise;
  }

  std::optional<double> finite(const toml::node& node, const std::string& key) {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) {
      fault(node.source(), key, "is not a number", "write a number, without quotes");
      return std::nullopt;
    }
    if (!std::isfinite(*value)) {
      fault(node.source(), key, "is not finite", "write a finite number");
      return std::nullopt;
    }
    return value;
  }

  std::optional<double> number(
      const toml::table& from, const std::string& where, const std::string& key) {
    const toml::node* node = from.get(key);
    if (node == nullptr) {
      missing(from, where, key);
      return std::nullopt;
    }
    return finite(*node, key);
  }

  /// A length that must be > 0, or >= 0.
  void length(
      const toml::table& from, const std::string& where, const std::string& key,
      bool zero_allowed, double& result) {
    const auto value = number(from, where, key);
    if (!value) return;
    if (*value < 0.0 || (*value == 0.0 && !zero_allowed)) {
      fault(
          from.get(key)->source(), key, fmt::format("{} makes no sense", *value),
          zero_allowed ? "it must not be negative" : "it must be greater than 0");
      return;
    }
    result = *value;
  }

  std::optional<Eigen::Vector2d> pair(
      const toml::table& from, const std::string& where, const std::string& key) {
    const toml::node* node = from.get(key);
    if (node == nullptr) {
      missing(from, where, key);
      return std::nullopt;
    }
    const toml::array* array = node->as_array();
    if (array == nullptr || array->size() != 2) {
      fault(
          node->source(), key,
          array == nullptr ? "is not a pair of numbers"
                           : fmt::format("has {} numbers", array->size()),
          "write two numbers, such as [28.0, 48.0]");
      return std::nullopt;
    }
    const auto x = finite(*array->get(0), key);
    const auto y = finite(*array->get(1), key);
    if (!x || !y) return std::nullopt;
    return Eigen::Vector2d(*x, *y);
  }

  void read_robot(const toml::table& from, geometry::Robot& robot) {
    const std::string where = "[robot]";
    known_keys(from, where, robot_keys());
    if (text(from, where, "model", "five_bar") != "five_bar") {
      fault(
          from.get("model")->source(), "model", "is not a known robot",
          "the known model is \"five_bar\"");
    }
    if (from.get("working_mode") == nullptr) {
      missing(from, where, "working_mode");
    } else {
      const auto mode = geometry::working_mode_from(text(from, where, "working_mode", "++"));
      if (mode) robot.working_mode = *mode;
      if (!mode) {
        fault(
            from.get("working_mode")->source(), "working_mode", "is not a working mode",
            "write \"++\", \"+-\", \"-+\" or \"--\": the elbow side of leg 1 and leg 2");
      }
    }
    const toml::node* assembly = from.get("assembly");
    if (assembly == nullptr) {
      missing(from, where, "assembly");
    } else {
      const auto beta = assembly->value_exact<std::int64_t>();
      if (beta && (*beta == 1 || *beta == -1)) {
        robot.assembly = *beta == 1 ? geometry::Assembly::kLeft : geometry::Assembly::kRight;
      } else {
        fault(assembly->source(), "assembly", "is neither 1 nor -1", "write 1 or -1");
      }
    }
    robot.connection = text(from, where, "connection", "");
    for (int i = 0; i < geometry::kParameterCount; ++i) {
      const auto& info = geometry::kParameters[static_cast<std::size_t>(i)];
      const std::string key(info.rig_key);
      if (i <= geometry::kD) {
        length(from, where, key, i == geometry::kD, robot.nominal[i]);
      } else if (const auto value = number(from, where, key)) {
        robot.nominal[i] = info.shown_unit == "deg" ? *value * kRadPerDeg : *value;
      }
    }
  }

  void read_cuboid(const toml::table& from, geometry::Cuboid& cuboid) {
    const std::string where = "[cuboid]";
    known_keys(from, where, kCuboidKeys);
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
    if (cuboid.mount == geometry::Mount::kFree && from.get("reference_pose_mm") == nullptr)
      return;
    if (const auto pose = pair(from, where, "reference_pose_mm"))
      cuboid.reference_pose_mm = *pose;
  }

  void read_dials(const toml::table& top, Rig& rig) {
    const toml::node* list = top.get("dial");
    const toml::table* common = nullptr;
    if (top.get("dials") != nullptr) common = table(top, "dials");
    if (common != nullptr) {
      known_keys(*common, "[dials]", dials_keys());
      Dial checked;
      for (const Figure& figure : kFigures) {
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
      rig.dials.push_back(read_dial(*node.as_table(), common, ids));
    }
  }

  Dial read_dial(
      const toml::table& from, const toml::table* common, std::set<std::string>& ids) {
    Dial dial;
    const std::string where = "[[dial]]";
    known_keys(from, where, dial_keys());
    if (from.get("id") == nullptr) {
      missing(from, where, "id");
    } else {
      dial.id = text(from, where, "id", "");
      check_id(dial.id, from.get("id")->source(), ids);
    }
    if (const auto position = pair(from, where, "position_mm")) {
      dial.geometry.position_mm = *position;
    }
    if (const auto axis = pair(from, where, "axis")) {
      dial.geometry.axis = unit_axis(*axis, from.get("axis")->source());
    }
    for (const Figure& figure : kFigures) {
      const bool own = from.get(figure.key) != nullptr;
      const bool shared = common != nullptr && common->get(figure.key) != nullptr;
      if (own) {
        length(from, where, figure.key, figure.zero_allowed, figure.of(dial));
      } else if (shared) {
        figure.of(dial) = common->get(figure.key)->value<double>().value_or(figure.of(dial));
      } else if (figure.required) {
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

  std::string file_;
  std::vector<Finding> findings_;
  std::vector<Finding> unknown_;  // told first: a key that is missing may be one misspelt
};

std::string toml_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20U || c == 0x7F) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

/// Shortest text that reads back as the same double, always with a point or an exponent.
std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_pair(const Eigen::Vector2d& pair) {
  return fmt::format("[{}, {}]", toml_number(pair.x()), toml_number(pair.y()));
}

/// Degrees that convert back to the same radians, if a double does; the shortest such text.
double degrees_of(double rad) {
  const double near = rad / kRadPerDeg;
  for (const int digits : {6, 9, 12, 15}) {
    const double rounded = parse_number(fmt::format("{:.{}g}", near, digits)).value;
    if (rounded * kRadPerDeg == rad) return rounded;
  }
  double down = near;
  double up = near;
  for (int step = 0; step < 4; ++step) {
    if (down * kRadPerDeg == rad) return down;
    if (up * kRadPerDeg == rad) return up;
    down = std::nextafter(down, -1e300);
    up = std::nextafter(up, 1e300);
  }
  return near;
}

}  // namespace

geometry::Rig parse_rig(std::string_view text, const std::string& file_name) {
  if (auto finding = stray_character(text)) throw DataError(file_name, std::move(*finding));
  try {
    const toml::table top = toml::parse(text);
    return RigReader(file_name).read(top);
  } catch (const toml::parse_error& error) {
    const auto& where = error.source().begin;
    throw DataError(
        file_name, Finding{
                       static_cast<int>(where.line), static_cast<int>(where.column), "",
                       std::string(error.description()), "mend the TOML syntax there"});
  }
}

geometry::Rig read_rig_file(const std::string& path) {
  return parse_rig(read_file(path), path);
}

std::string write_rig(const geometry::Rig& rig) {
  std::string out = "# Measurement rig and nominal robot. Lengths in mm, angles in degrees.\n";
  out += fmt::format("name = {}\n\n[robot]\nmodel = \"five_bar\"\n", toml_text(rig.name));
  out += fmt::format("working_mode = \"{}\"\n", to_string(rig.robot.working_mode));
  out += fmt::format("assembly = {}\n", static_cast<int>(rig.robot.assembly));
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const auto& info = geometry::kParameters[static_cast<std::size_t>(i)];
    const double value = rig.robot.nominal[i];
    out += fmt::format(
        "{} = {}\n", info.rig_key,
        toml_number(info.shown_unit == "deg" ? degrees_of(value) : value));
  }
  if (!rig.robot.connection.empty()) {
    out += fmt::format("connection = {}\n", toml_text(rig.robot.connection));
  }
  const char* mount = rig.cuboid.mount == geometry::Mount::kDistal1   ? "distal1"
                      : rig.cuboid.mount == geometry::Mount::kDistal2 ? "distal2"
                                                                      : "free";
  out += fmt::format(
      "\n[cuboid]\nside_mm = {}\nmount = \"{}\"\nreference_pose_mm = {}\n",
      toml_number(rig.cuboid.side_mm), mount, toml_pair(rig.cuboid.reference_pose_mm));
  // A figure that all dials share stands in [dials], any other in its [[dial]].
  std::array<bool, kFigures.size()> shared{};
  if (!rig.dials.empty()) out += "\n[dials]\n";
  for (std::size_t f = 0; f < kFigures.size() && !rig.dials.empty(); ++f) {
    std::set<double> values;
    for (Dial dial : rig.dials) values.insert(kFigures[f].of(dial));
    shared[f] = values.size() == 1;
    if (shared[f])
      out += fmt::format("{} = {}\n", kFigures[f].key, toml_number(*values.begin()));
  }
  for (Dial dial : rig.dials) {
    out += fmt::format(
        "\n[[dial]]\nid = {}\nposition_mm = {}\naxis = {}\n", toml_text(dial.id),
        toml_pair(dial.geometry.position_mm), toml_pair(dial.geometry.axis));
    for (std::size_t f = 0; f < kFigures.size(); ++f) {
      if (shared[f]) continue;
      out += fmt::format("{} = {}\n", kFigures[f].key, toml_number(kFigures[f].of(dial)));
    }
    if (!dial.connection.empty()) {
      out += fmt::format("connection = {}\n", toml_text(dial.connection));
    }
  }
  return out;
}

}  // namespace sixdial::session
