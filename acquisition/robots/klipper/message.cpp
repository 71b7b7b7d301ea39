// The protocol is JSON: this file alone of the folder reads and writes it
// (tests/architecture/architecture_test.cpp).
#include "acquisition/robots/klipper/message.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace sixdial::acquisition {
namespace {

using Json = nlohmann::json;

constexpr double kLargest = 1e9;

std::string request(std::int64_t id, std::string_view method, Json params) {
  // What no UTF-8 can be is replaced: a script is ASCII anyway.
  return Json{{"id", id}, {"method", method}, {"params", std::move(params)}}.dump(
             -1, ' ', false, Json::error_handler_t::replace) +
         kKlipperEnd;
}

/// Several lines as one: "Printer is shutdown; Once the underlying issue is corrected, ...".
std::string on_one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool breaks = c == '\n' || c == '\r' || c == '\t';
    if (!breaks && (static_cast<unsigned char>(c) < 0x20 || c == '\x7f')) continue;
    if (!breaks) {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

/// The member, or null.
const Json& member(const Json& object, const char* name) {
  static const Json none;
  if (!object.is_object()) return none;
  const auto found = object.find(name);
  return found == object.end() ? none : *found;
}

/// False: it is there, and is none.
bool take_text(const Json& from, std::string& text) {
  if (from.is_null()) return true;
  if (!from.is_string()) return false;
  text = on_one_line(from.get<std::string>());
  return true;
}

bool take_figures(const Json& from, std::vector<double>& figures) {
  if (from.is_null()) return true;
  if (!from.is_array() || from.size() < kKlipperAxes.size()) return false;
  for (const Json& each : from) {
    // Axes without a motor and limits may be null behind X, Y, Z.
    if (figures.size() >= kKlipperAxes.size() && !each.is_number()) break;
    if (!each.is_number()) return false;
    const auto figure = each.get<double>();
    if (!(std::abs(figure) < kLargest)) return false;
    figures.push_back(figure);
  }
  return true;
}

bool take_status(const Json& from, KlipperStatus& status) {
  const Json& webhooks = member(from, "webhooks");
  const Json& toolhead = member(from, "toolhead");
  const Json& motion = member(from, "motion_report");
  const Json& moves = member(from, "gcode_move");
  const Json& velocity = member(motion, "live_velocity");
  if (!velocity.is_null()) {
    if (!velocity.is_number()) return false;
    status.velocity = velocity.get<double>();
    if (!(std::abs(status.velocity) < kLargest)) return false;
  }
  return take_text(member(webhooks, "state"), status.state) &&
         take_text(member(webhooks, "state_message"), status.message) &&
         take_text(member(toolhead, "homed_axes"), status.homed) &&
         take_text(member(member(from, "print_stats"), "state"), status.print) &&
         take_figures(member(toolhead, "axis_minimum"), status.low) &&
         take_figures(member(toolhead, "axis_maximum"), status.high) &&
         take_figures(member(motion, "live_position"), status.live) &&
         take_figures(member(moves, "position"), status.planned) &&
         take_figures(member(moves, "gcode_position"), status.commanded);
}

}  // namespace

std::string klipper_info_request(std::int64_t id) {
  return request(id, "info", {{"client_info", {{"program", "sixdial"}}}});
}

std::string klipper_status_request(std::int64_t id) {
  return request(
      id, "objects/query",
      {{"objects",
        {{"webhooks", {"state", "state_message"}},
         {"toolhead", {"homed_axes", "axis_minimum", "axis_maximum"}},
         {"motion_report", {"live_position", "live_velocity"}},
         {"gcode_move", {"position", "gcode_position"}},
         {"print_stats", Json::array({"state"})}}}});
}

std::string klipper_script_request(std::int64_t id, std::string_view script) {
  return request(id, "gcode/script", {{"script", script}});
}

std::optional<KlipperMessage> parse_klipper(std::string_view text) {
  const Json said = Json::parse(text, nullptr, false);
  if (!said.is_object()) return std::nullopt;
  KlipperMessage message;
  const Json& id = member(said, "id");
  if (id.is_number_integer()) message.id = id.get<std::int64_t>();
  const Json& error = member(said, "error");
  if (!error.is_null()) {
    std::string words;
    if (!error.is_object() || !take_text(member(error, "message"), words)) return std::nullopt;
    if (words.empty() && !take_text(member(error, "error"), words)) return std::nullopt;
    message.error = words.empty() ? "an error without words" : words;
    return message;
  }
  const Json& result = member(said, "result");
  // What nobody asked for has neither result nor error, but parameters.
  if (!result.is_object() && (message.id || !member(said, "params").is_object())) {
    return std::nullopt;
  }
  if (!take_text(member(result, "state"), message.status.state) ||
      !take_text(member(result, "state_message"), message.status.message) ||
      !take_status(member(result, "status"), message.status)) {
    return std::nullopt;
  }
  return message;
}

}  // namespace sixdial::acquisition
