#include "session/rig_instrument.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/instrument_kind.h"
#include "geometry/units.h"
#include "session/csv.h"
#include "session/live_channels.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"
#include "session/toml_write.h"

namespace sixdial::session {
namespace {

using geometry::ReferencePoint;

const std::vector<std::string> kInstrumentKeys{
    "kind", "sd_mm", "sd_deg", "dimensions", "orientation"};

std::string triple_text(const Eigen::Vector3d& value) {
  return fmt::format(
      "[{}, {}, {}]", toml_number(value[0]), toml_number(value[1]), toml_number(value[2]));
}

std::string place_text(const ReferencePoint& place) {
  std::string out = fmt::format("name = {}\n", toml_string(place.name));
  if (place.at_mm) out += fmt::format("at_mm = {}\n", triple_text(*place.at_mm));
  if (place.at_mm && place.sd_mm > 0.0) {
    out += fmt::format("at_sd_mm = {}\n", toml_number(place.sd_mm));
  }
  return out;
}

/// [[tool_point]], [[anchor]], [[socket]] and [[surface]].
std::string places_text(const geometry::Instrument& is) {
  std::string out;
  for (const ReferencePoint& each : is.tool_points)
    out += "\n[[tool_point]]\n" + place_text(each);
  for (const ReferencePoint& each : is.anchors) out += "\n[[anchor]]\n" + place_text(each);
  for (const ReferencePoint& each : is.sockets) {
    out += "\n[[socket]]\n" + place_text(each);
    std::string distances;
    double sd_mm = 0.0;
    for (const geometry::SocketDistance& known : is.socket_distances) {
      if (known.second != each.name) continue;
      distances += fmt::format(
          "{}{} = {}", distances.empty() ? "" : ", ", toml_string(known.first),
          toml_number(known.mm));
      sd_mm = known.sd_mm;
    }
    if (distances.empty()) continue;
    out += fmt::format(
        "distance_mm = {{ {} }}\ndistance_sd_mm = {}\n", distances, toml_number(sd_mm));
  }
  for (const geometry::Surface& each : is.surfaces) {
    out += "\n[[surface]]\n" + place_text(each.place);
    if (each.radius_mm) out += fmt::format("radius_mm = {}\n", toml_number(*each.radius_mm));
    if (!each.radius_mm || each.normal != geometry::Surface{}.normal) {
      out += fmt::format("normal = {}\n", triple_text(each.normal));
    }
  }
  return out;
}

}  // namespace

const toml::array* InstrumentChecks::rows(const toml::table& top, const char* key) {
  const toml::node* list = top.get(key);
  if (list == nullptr) return nullptr;
  const toml::array* array = list->as_array();
  if (array != nullptr && array->is_array_of_tables()) return array;
  fault(
      list->source(), key, "is not a list of tables",
      fmt::format("write [[{}]] before each of them", key));
  return nullptr;
}

std::optional<Eigen::Vector3d> InstrumentChecks::triple(
    const toml::table& from, const std::string& where, const char* key) {
  const toml::node* node = from.get(key);
  if (node == nullptr) return std::nullopt;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() != 3) {
    fault(node->source(), key, "is not a list of three numbers in " + where, "write [x, y, z]");
    return std::nullopt;
  }
  Eigen::Vector3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = finite(*array->get(i), key);
    if (!value) return std::nullopt;
    result[static_cast<Eigen::Index>(i)] = *value;
  }
  return result;
}

ReferencePoint InstrumentChecks::read_place(
    const toml::table& from, const std::string& where, std::vector<std::string> more_keys) {
  more_keys.insert(more_keys.end(), {"name", "at_mm", "at_sd_mm"});
  known_keys(from, where, more_keys);
  ReferencePoint place;
  if (from.get("name") == nullptr) {
    missing(from, where, "name");
  } else {
    place.name = text(from, where, "name", "");
    const bool good =
        !place.name.empty() && place.name.find_first_of(", \t\"") == std::string::npos;
    if (!good) {
      fault(
          from.get("name")->source(), "name", shown(place.name) + " cannot be a name",
          "use letters, digits, _ and -: it names columns");
    }
  }
  place.at_mm = triple(from, where, "at_mm");
  if (from.get("at_sd_mm") != nullptr) length(from, where, "at_sd_mm", true, place.sd_mm);
  if (from.get("at_sd_mm") != nullptr && !place.at_mm) {
    fault(
        from.get("at_sd_mm")->source(), "at_sd_mm",
        "says how well a place is known that is not "
        "given",
        "add at_mm, or take it out: the place is found from the data");
  }
  return place;
}

void InstrumentChecks::read_places(
    const toml::table& top, const char* key, std::vector<ReferencePoint>& places) {
  const toml::array* list = rows(top, key);
  if (list == nullptr) return;
  for (const toml::node& row : *list) {
    places.push_back(read_place(*row.as_table(), fmt::format("[[{}]]", key), {}));
  }
}

/// A socket may say its distance from others: distance_mm = { S1 = 50.0 }, distance_sd_mm.
void InstrumentChecks::read_sockets(const toml::table& top, geometry::Instrument& instrument) {
  const toml::array* list = rows(top, "socket");
  if (list == nullptr) return;
  const std::string where = "[[socket]]";
  for (const toml::node& row : *list) {
    const toml::table& from = *row.as_table();
    instrument.sockets.push_back(read_place(from, where, {"distance_mm", "distance_sd_mm"}));
    const toml::node* distances = from.get("distance_mm");
    if (distances == nullptr) continue;
    const toml::table* table = distances->as_table();
    if (table == nullptr) {
      fault(
          distances->source(), "distance_mm", "does not say from which socket",
          "write distance_mm = { S1 = 50.0 }");
      continue;
    }
    double sd_mm = 0.0;
    length(from, where, "distance_sd_mm", false, sd_mm);
    for (const auto& [name, value] : *table) {
      const auto mm = finite(value, "distance_mm");
      if (!mm) continue;
      instrument.socket_distances.push_back(
          {std::string(name.str()), instrument.sockets.back().name, *mm, sd_mm});
    }
  }
}

void InstrumentChecks::read_surfaces(
    const toml::table& top, std::vector<geometry::Surface>& surfaces) {
  const toml::array* list = rows(top, "surface");
  if (list == nullptr) return;
  const std::string where = "[[surface]]";
  for (const toml::node& row : *list) {
    const toml::table& from = *row.as_table();
    geometry::Surface surface;
    surface.place = read_place(from, where, {"radius_mm", "normal"});
    if (from.get("radius_mm") != nullptr) {
      length(from, where, "radius_mm", false, surface.radius_mm.emplace());
    }
    if (const auto normal = triple(from, where, "normal")) {
      if (!(normal->norm() > 1e-6)) {
        fault(
            from.get("normal")->source(), "normal", "has no direction",
            "write one, such as [0, 0, 1]");
      } else {
        surface.normal = normal->normalized();
      }
    }
    surfaces.push_back(std::move(surface));
  }
}

void InstrumentChecks::read_instrument_tables(
    const toml::table& top, geometry::Instrument& instrument) {
  const toml::table* from = table(top, "instrument");
  if (from == nullptr) return;
  const std::string where = "[instrument]";
  known_keys(*from, where, kInstrumentKeys);
  instrument.kind = text(*from, where, "kind", instrument.kind);
  if (geometry::find_instrument_kind(instrument.kind) == nullptr) {
    std::string known;
    for (const geometry::InstrumentKind* each : geometry::instrument_kinds()) {
      known += fmt::format("{}\"{}\"", known.empty() ? "" : " or ", each->name);
    }
    const toml::node* node = from->get("kind");
    fault(
        node->source(), "kind", shown(instrument.kind) + " is not a known instrument",
        "write " + known);
  }
  if (from->get("sd_mm") != nullptr) length(*from, where, "sd_mm", true, instrument.sd_mm);
  if (from->get("sd_deg") != nullptr) {
    double sd_deg = 0.0;
    length(*from, where, "sd_deg", true, sd_deg);
    instrument.sd_rad = sd_deg * geometry::kRadPerDeg;
  }
  if (const toml::node* node = from->get("dimensions")) {
    const auto given = node->value_exact<std::int64_t>();
    if (given && (*given == 2 || *given == 3)) {
      instrument.dimensions = static_cast<int>(*given);
    } else {
      fault(node->source(), "dimensions", "is neither 2 nor 3", "write 2 or 3");
    }
  }
  if (const toml::node* node = from->get("orientation")) {
    instrument.orientation = text(*from, where, "orientation", instrument.orientation);
    if (!turn_of_angles(instrument.orientation, Eigen::Vector3d::Zero())) {
      fault(
          node->source(), "orientation", shown(instrument.orientation) + " is no convention",
          "write \"rotation vector\", or \"intrinsic\" or \"extrinsic\" and the axes in order, "
          "such as \"intrinsic xyz\"");
    }
  }
  read_places(top, "tool_point", instrument.tool_points);
  read_places(top, "anchor", instrument.anchors);
  read_sockets(top, instrument);
  read_surfaces(top, instrument.surfaces);
}

void InstrumentChecks::check_instrument(const toml::table& top, const geometry::Rig& rig) {
  const auto* kind = geometry::find_instrument_kind(rig.instrument.kind);
  const toml::node* from = top.get("instrument");
  if (kind == nullptr || from == nullptr || kind->name == geometry::Instrument{}.kind) return;
  if (const auto made = kind->of_rig(rig); !made) {
    fault(
        from->source(), "instrument", fmt::format("kind \"{}\": {}", kind->name, made.error()),
        "see doc/robots.md for the tables that it takes");
    return;
  }
  if (const auto fault_of_dials = live_channel_fault(rig)) {
    fault(
        top.get("dial")->source(), "dial", *fault_of_dials,
        "give each dial the name of its place as id");
  }
}

std::string instrument_text(const geometry::Rig& rig) {
  const geometry::Instrument& is = rig.instrument;
  const geometry::Instrument usual;
  std::string keys;
  if (is.sd_mm > 0.0) keys += fmt::format("sd_mm = {}\n", toml_number(is.sd_mm));
  if (is.sd_rad > 0.0) keys += fmt::format("sd_deg = {}\n", toml_number(degrees_of(is.sd_rad)));
  if (is.dimensions != rig.robot.model->axes) {
    keys += fmt::format("dimensions = {}\n", is.dimensions);
  }
  if (is.orientation != usual.orientation) {
    keys += fmt::format("orientation = {}\n", toml_string(is.orientation));
  }
  const std::string places = places_text(is);
  if (is.kind == usual.kind && keys.empty() && places.empty()) return "";
  return fmt::format("\n[instrument]\nkind = {}\n{}{}", toml_string(is.kind), keys, places);
}

}  // namespace sixdial::session
