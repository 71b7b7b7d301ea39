#include "mock_devices/gcode_controller.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace sixdial::mock_devices {
namespace {

constexpr std::string_view kAllAxes = "XYZABCUVW";
constexpr double kRapid = 6000.0;  // of G0 [1/min]
constexpr int kOffsetEvery = 10;   // Grbl says its work offset in each tenth report

/// "X12.5" of "G1 X12.5 Y3".
std::optional<double> word_value(const std::string& line, char letter) {
  const std::size_t at = line.find(letter);
  if (at == std::string::npos) return std::nullopt;
  const char* begin = line.c_str() + at + 1;
  char* end = nullptr;
  const double value = std::strtod(begin, &end);
  return end == begin ? std::nullopt : std::optional(value);
}

}  // namespace

GcodeController::GcodeController(GcodeMachine machine)
    : machine_(std::move(machine)), at_(machine_.begins_at) {
  at_.resize(machine_.axes.size(), 0.0);
}

double GcodeController::end_s() const {
  return segments_.empty() ? 0.0 : segments_.back().end_s;
}

std::vector<double> GcodeController::position(double time_s) const {
  std::vector<double> now = at_;
  for (const Segment& each : segments_) {
    if (time_s < each.start_s) break;
    const double share =
        each.end_s > each.start_s
            ? std::min(1.0, (time_s - each.start_s) / (each.end_s - each.start_s))
            : 1.0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i] = each.from[i] + share * (each.to[i] - each.from[i]);
    }
  }
  if (machine_.step > 0.0) {
    for (double& value : now) value = std::round(value / machine_.step) * machine_.step;
  }
  return now;
}

void GcodeController::answer(std::string text, double time_s) {
  const char* const end = is(GcodeFirmware::kGrbl) ? "\r\n" : "\n";
  out_.push_back({time_s + machine_.before_ok_s, text + end});
}

void GcodeController::say(std::string line, double time_s) { answer(std::move(line), time_s); }

void GcodeController::greet(double time_s) {
  if (is(GcodeFirmware::kGrbl)) {
    answer("", time_s);
    answer("Grbl 1.1h ['$' for help]", time_s);
  } else if (is(GcodeFirmware::kMarlin)) {
    answer("start", time_s);
    answer("echo:Marlin 2.1.2", time_s);
  }
}

void GcodeController::restart(double time_s) {
  segments_.clear();
  out_.clear();
  in_.clear();
  at_ = machine_.begins_at;
  at_.resize(machine_.axes.size(), 0.0);
  held_ = alarm_ = dead_ = relative_ = false;
  greet(time_s);
}

void GcodeController::receive(std::string_view bytes, double time_s) {
  for (const char c : bytes) {
    if (is(GcodeFirmware::kGrbl)) {  // at once, wherever in a line they stand
      if (c == '?') {
        out_.push_back({time_s, status(time_s) + "\r\n"});
        continue;
      }
      if (c == '!') {
        hold(time_s);
        continue;
      }
      if (c == '~') {
        if (held_) {
          held_ = false;
          const std::vector<double> from = position(time_s);
          segments_ = {{from, held_to_, time_s, time_s + 0.1}};
          for (Out& out : out_) {
            if (out.of_wait) out.due_s = end_s();
          }
        }
        continue;
      }
      if (c == '\x18') {
        reset(time_s);
        continue;
      }
    }
    if (c == '\n' || c == '\r') {
      line(std::exchange(in_, {}), time_s);
    } else {
      in_ += c;
    }
  }
}

void GcodeController::hold(double time_s) {
  if (held_) return;
  held_to_ = segments_.empty() ? at_ : segments_.back().to;
  at_ = position(time_s);
  segments_.clear();
  held_ = true;
  for (Out& out : out_) {
    if (out.of_wait) out.due_s = 1e300;  // until it goes on
  }
}

void GcodeController::reset(double time_s) {
  const bool in_motion = moving(time_s);
  at_ = position(time_s);
  segments_.clear();
  out_.clear();
  in_.clear();
  held_ = false;
  if (in_motion) {
    alarm_ = true;
    answer("ALARM:3", time_s);
  }
  greet(time_s);
  if (alarm_) answer("[MSG:'$H'|'$X' to unlock]", time_s);
}

void GcodeController::line(std::string text, double time_s) {
  if (text.empty() && !is(GcodeFirmware::kGrbl)) return;
  const std::size_t remark = text.find_first_of(";(");
  if (remark != std::string::npos) text.resize(remark);
  command(text, time_s);
}

void GcodeController::command(const std::string& text, double time_s) {
  const auto begins = [&](std::string_view head) {
    return text.starts_with(head) && (text.size() == head.size() || text[head.size()] == ' ');
  };
  if (dead_) return answer("!! Printer is shutdown", time_s), answer("ok", time_s);
  const bool grbl = is(GcodeFirmware::kGrbl);
  if (grbl && text == "$X") {
    alarm_ = false;
    answer("[MSG:Caution: Unlocked]", time_s);
    return answer("ok", time_s);
  }
  if (grbl && alarm_ && !text.empty()) return answer("error:9", time_s);
  if (text.empty() || begins("G21") || begins("G90")) {
    if (begins("G90")) relative_ = false;
    return answer("ok", time_s);
  }
  if (begins("G91")) {
    relative_ = true;
    return answer("ok", time_s);
  }
  if (begins("G0") || begins("G1")) return move(text, time_s);
  if ((grbl && begins("G4")) || (!grbl && begins("M400"))) {
    out_.push_back({std::max(time_s, end_s()), grbl ? "ok\r\n" : "ok\n", true});
    if (held_) out_.back().due_s = 1e300;
    return;
  }
  if (!grbl && begins("M114")) {
    answer(m114(time_s), time_s);
    return answer("ok", time_s);
  }
  if (is(GcodeFirmware::kMarlin) && begins("M410")) {
    at_ = position(time_s);
    segments_.clear();
    for (Out& out : out_) {
      if (out.of_wait) out.due_s = time_s;
    }
    return answer("ok", time_s);
  }
  if (is(GcodeFirmware::kKlipper) && begins("M112")) {
    at_ = position(time_s);
    segments_.clear();
    out_.clear();
    dead_ = true;
    return answer("!! Shutdown due to M112 command", time_s);
  }
  if (grbl) return answer("error:20", time_s);
  answer(
      is(GcodeFirmware::kMarlin) ? "echo:Unknown command: \"" + text + "\""
                                 : "// Unknown command:\"" + text + "\"",
      time_s);
  answer("ok", time_s);
}

void GcodeController::move(const std::string& words, double time_s) {
  const std::string parameters =
      words.substr(words.find(' ') == std::string::npos ? words.size() : words.find(' '));
  const std::vector<double> from = segments_.empty() ? at_ : segments_.back().to;
  std::vector<double> to = from;
  if (const auto feed = word_value(parameters, 'F')) feed_ = *feed;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const auto value = word_value(parameters, machine_.axes[i]);
    if (!value) continue;
    to[i] = relative_ ? from[i] + *value : *value;
    const bool inside = to[i] >= machine_.low && to[i] <= machine_.high;
    if (inside) continue;
    if (is(GcodeFirmware::kMarlin)) {  // quietly goes no further than it may
      to[i] = std::clamp(to[i], machine_.low, machine_.high);
    } else if (is(GcodeFirmware::kGrbl)) {
      alarm_ = true;
      answer("ALARM:2", time_s);
      return answer("ok", time_s);
    } else {
      answer(fmt::format("!! Move out of range: {:.3f}", to[i]), time_s);
      return answer("ok", time_s);
    }
  }
  const bool rapid = words.starts_with("G0");
  if (is(GcodeFirmware::kGrbl) && !rapid && feed_ <= 0.0) return answer("error:22", time_s);
  double way = 0.0;
  for (std::size_t i = 0; i < to.size(); ++i) way += (to[i] - from[i]) * (to[i] - from[i]);
  const double feed = rapid ? kRapid : std::max(feed_, 1.0);
  const double start_s = std::max(time_s, end_s());
  segments_.push_back({from, to, start_s, start_s + std::sqrt(way) / feed * 60.0});
  ++moves_;
  answer("ok", time_s);
}

std::string GcodeController::status(double time_s) const {
  const std::vector<double> now = position(time_s);
  std::string text = alarm_ ? "<Alarm" : held_ ? "<Hold:0" : moving(time_s) ? "<Run" : "<Idle";
  text += "|MPos:";
  for (std::size_t i = 0; i < std::max<std::size_t>(3, now.size()); ++i) {
    // The axes in the machine's own order, those without a motor at rest.
    const std::size_t own = machine_.axes.find(kAllAxes[i]);
    const double value = own == std::string::npos ? 0.0 : now[own];
    text += fmt::format("{}{:.3f}", i == 0 ? "" : ",", value + machine_.work_offset);
  }
  text += "|FS:0,0";
  if (reports_++ % kOffsetEvery == 0) {
    text += "|WCO:";
    for (std::size_t i = 0; i < std::max<std::size_t>(3, now.size()); ++i) {
      text += fmt::format("{}{:.3f}", i == 0 ? "" : ",", machine_.work_offset);
    }
  }
  return text + ">";
}

std::string GcodeController::m114(double time_s) const {
  const std::vector<double> now = position(time_s);
  const int digits = is(GcodeFirmware::kMarlin) ? 2 : 3;
  std::string text;
  for (std::size_t i = 0; i < now.size(); ++i) {
    text += fmt::format("{}:{:.{}f} ", machine_.axes[i], now[i], digits);
  }
  text += fmt::format("E:{:.{}f}", 0.0, digits);
  if (is(GcodeFirmware::kMarlin)) {
    text += " Count";
    for (std::size_t i = 0; i < now.size(); ++i) {
      text += fmt::format(" {}:{}", machine_.axes[i], std::lround(now[i] * 80.0));
    }
  }
  return text;
}

std::string GcodeController::due(double time_s) {
  std::string bytes;
  // A line's answers come in order; what is asked in between overtakes a wait.
  for (auto out = out_.begin(); out != out_.end();) {
    if (out->due_s <= time_s) {
      bytes += out->bytes;
      out = out_.erase(out);
    } else {
      ++out;
    }
  }
  return bytes;
}

std::optional<double> GcodeController::next_due_s() const {
  if (out_.empty()) return std::nullopt;
  return std::ranges::min_element(out_, {}, &Out::due_s)->due_s;
}

}  // namespace sixdial::mock_devices
