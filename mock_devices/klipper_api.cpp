#include "mock_devices/klipper_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace sixdial::mock_devices {
namespace {

using Json = nlohmann::json;

constexpr char kEnd = '\x03';
constexpr std::string_view kAxes = "XYZ";
constexpr double kNothing_s = 1e-9;

std::optional<double> word_value(const std::string& line, char letter) {
  const std::size_t at = line.find(letter, 1);
  if (at == std::string::npos) return std::nullopt;
  const char* begin = line.c_str() + at + 1;
  char* end = nullptr;
  const double value = std::strtod(begin, &end);
  return end == begin ? std::nullopt : std::optional(value);
}

bool begins(const std::string& line, std::string_view head) {
  return line.starts_with(head) && (line.size() == head.size() || line[head.size()] == ' ');
}

Json error_object(const std::string& words) {
  return {{"error", "WebRequestError"}, {"message", words}};
}

}  // namespace

KlipperApi::KlipperApi(KlipperMachine machine)
    : machine_(std::move(machine)), track_([this] {
        std::vector<double> at = machine_.offset;
        for (std::size_t i = 0; i < at.size(); ++i) at[i] += machine_.begins_at[i];
        return at;
      }()) {}

void KlipperApi::connected(int client, double) {
  in_[client].clear();
  out_[client].clear();
}

void KlipperApi::gone(int client) {
  in_.erase(client);
  out_.erase(client);
}

std::vector<double> KlipperApi::position(double time_s) const {
  std::vector<double> at = track_.position(time_s);
  for (std::size_t i = 0; i < at.size(); ++i) at[i] -= machine_.offset[i];
  return at;
}

void KlipperApi::move_by_hand(const std::vector<double>& to, double speed, double time_s) {
  track_.append(to, speed, time_s);
}

void KlipperApi::answer(int client, const std::string& id, const char* kind, const Json& what) {
  if (id == "null" || !out_.contains(client)) return;
  out_[client] += Json{{"id", Json::parse(id)}, {kind, what}}.dump() + kEnd;
}

void KlipperApi::shut_down(const std::string& why, double time_s) {
  track_.stop(time_s);
  machine_.state = "shutdown";
  machine_.state_message = why + "\nOnce the underlying issue is corrected, use the\n" +
                           "\"FIRMWARE_RESTART\" command to reset the firmware.\n";
  for (const Script& each : scripts_) {
    answer(each.client, each.id, "error", error_object(machine_.state_message));
  }
  scripts_.clear();
}

void KlipperApi::receive(int client, std::string_view bytes, double time_s) {
  std::string& in = in_[client];
  in += bytes;
  for (std::size_t end = in.find(kEnd); end != std::string::npos; end = in.find(kEnd)) {
    const std::string text = in.substr(0, end);
    in.erase(0, end + 1);
    try {
      request(client, text, time_s);
    } catch (const Json::exception&) {
      // A request of another shape than its pages show; it notes that in its log only.
    }
  }
}

void KlipperApi::request(int client, const std::string& text, double time_s) {
  const Json said = Json::parse(text, nullptr, false);
  if (!said.is_object() || !said.contains("method")) return;  // noted in its log only
  const std::string id = said.value("id", Json()).dump();
  const auto method = said.at("method").get<std::string>();
  const Json params = said.value("params", Json::object());
  if (method == "info") {
    answer(
        client, id, "result",
        {{"state", machine_.state},
         {"state_message", machine_.state_message},
         {"hostname", "mock"},
         {"software_version", "v0.12.0-1-mock"},
         {"cpu_info", "4 core ?"},
         {"klipper_path", "/home/pi/klipper"},
         {"python_path", "/home/pi/klippy-env/bin/python"},
         {"config_file", "/home/pi/printer.cfg"},
         {"log_file", "/tmp/klippy.log"}});
  } else if (method == "objects/query") {
    answer(
        client, id, "result",
        {{"eventtime", time_s}, {"status", status(params.at("objects"), time_s)}});
  } else if (method == "gcode/script") {
    const auto script = params.at("script").get<std::string>();
    seen_.push_back(script);
    Script next{client, id, {}};
    for (std::size_t at = 0; at <= script.size();) {
      const std::size_t end = std::min(script.find('\n', at), script.size());
      if (end > at) next.lines.push_back(script.substr(at, end - at));
      at = end + 1;
    }
    scripts_.push_back(std::move(next));
  } else if (method == "emergency_stop") {
    shut_down("Shutdown due to webhooks request", time_s);
    answer(client, id, "result", Json::object());
  } else {
    answer(
        client, id, "error",
        error_object(fmt::format("webhooks: No registered callback for path '{}'", method)));
  }
}

Json KlipperApi::status(const Json& asked, double time_s) const {
  Json all;
  all["webhooks"] = {{"state", machine_.state}, {"state_message", machine_.state_message}};
  if (machine_.state == "ready" || machine_.state == "shutdown") {
    const auto four = [](std::vector<double> three) {  // and the extruder
      three.push_back(0.0);
      return three;
    };
    std::vector<double> commanded = track_.end();
    for (std::size_t i = 0; i < commanded.size(); ++i) commanded[i] -= machine_.offset[i];
    all["toolhead"] = {
        {"homed_axes", machine_.homed},
        {"axis_minimum", four(std::vector<double>(3, machine_.low))},
        {"axis_maximum", four(std::vector<double>(3, machine_.high))},
        {"position", four(track_.end())}};
    all["motion_report"] = {
        {"live_position", four(track_.position(time_s))},
        {"live_velocity", track_.speed(time_s)}};
    all["print_stats"] = {{"state", machine_.print_state}};
    all["gcode_move"] = {{"position", four(track_.end())}, {"gcode_position", four(commanded)}};
  }
  Json told = Json::object();
  for (const auto& [name, fields] : asked.items()) {
    told[name] = Json::object();
    if (!all.contains(name)) continue;
    for (const auto& [field, value] : all[name].items()) {
      const bool wanted =
          fields.is_null() || std::find(fields.begin(), fields.end(), field) != fields.end();
      if (wanted) told[name][field] = value;
    }
  }
  return told;
}

bool KlipperApi::run_move(const std::string& line, double time_s) {
  if (track_.end_s() - time_s > machine_.ahead_s) return false;
  std::vector<double> to = track_.end();
  bool out_of_range = false;
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    const auto value = word_value(line, kAxes[i]);
    if (!value) continue;
    to[i] = relative_ ? to[i] + *value : *value + machine_.offset[i];
    out_of_range = out_of_range || to[i] < machine_.low || to[i] > machine_.high;
    if (machine_.homed.find("xyz"[i]) == std::string::npos) {
      throw std::runtime_error(fmt::format(
          "Must home axis first: {:.3f} {:.3f} {:.3f} [0.000]", to[0], to[1], to[2]));
    }
  }
  if (out_of_range) {
    throw std::runtime_error(
        fmt::format("Move out of range: {:.3f} {:.3f} {:.3f} [0.000]", to[0], to[1], to[2]));
  }
  if (const auto feed = word_value(line, 'F')) feed_ = *feed;
  if (feed_ <= 0.0) throw std::runtime_error(fmt::format("Invalid speed in '{}'", line));
  track_.append(to, feed_ / 60.0, time_s);
  ++moves_;
  return true;
}

bool KlipperApi::run_line(const std::string& line, double time_s) {
  if (begins(line, "G0") || begins(line, "G1")) return run_move(line, time_s);
  if (begins(line, "M400")) return time_s + kNothing_s >= track_.end_s();
  if (begins(line, "G90") || begins(line, "G91")) {
    relative_ = begins(line, "G91");
    return true;
  }
  if (begins(line, "G21")) return true;
  if (begins(line, "M112")) {
    shut_down("Shutdown due to M112 command", time_s);
    return false;
  }
  return true;  // others are told on its terminal only
}

// One script at a time, as they came.
void KlipperApi::advance(double time_s) {
  while (!scripts_.empty()) {
    Script& now = scripts_.front();
    if (machine_.state != "ready") {
      answer(now.client, now.id, "error", error_object(machine_.state_message));
      scripts_.pop_front();
      continue;
    }
    if (now.lines.empty()) {
      answer(now.client, now.id, "result", Json::object());
      scripts_.pop_front();
      continue;
    }
    try {
      if (!run_line(now.lines.front(), time_s)) return;
      now.lines.pop_front();
    } catch (const std::runtime_error& error) {
      answer(now.client, now.id, "error", error_object(error.what()));
      scripts_.pop_front();
    }
  }
}

std::string KlipperApi::due(int client, double time_s) {
  advance(time_s);
  std::string bytes;
  std::swap(bytes, out_[client]);
  return bytes;
}

}  // namespace sixdial::mock_devices
