#include "acquisition/robots/klipper/robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLook{100};  // on the wall, between two looks at a move
constexpr double kRests = 1e-6;     // slower than this a second is no motion

/// Of an axis in Klipper's lists.
std::size_t place_of(char letter) { return kKlipperAxes.find(letter); }

RobotFault answered_with(std::string_view script, const std::string& words) {
  const bool far = words.find("out of range") != std::string::npos;
  return {
      far ? RobotFaultKind::kUnreachable : RobotFaultKind::kController,
      fmt::format("{} is answered with {}", script, words)};
}

}  // namespace

KlipperRobot::KlipperRobot(
    AxisSettings settings, Open open, Clock& clock, std::span<const RobotJoint> joints)
    : AxisRobot(std::move(settings), std::move(open), clock, joints) {}

tl::expected<std::optional<KlipperMessage>, RobotFault> KlipperRobot::message_by(
    WallTime deadline, const std::stop_token& stop) {
  return hear(
      deadline, stop, parse_klipper,
      "message of Klipper's API server: is this the socket of its -a?");
}

tl::expected<KlipperMessage, RobotFault> KlipperRobot::answer_to(
    std::int64_t id, std::string_view asked, const std::stop_token& stop) {
  const auto deadline = answer_by();
  for (;;) {
    auto message = message_by(deadline, stop);
    if (!message) return tl::unexpected(message.error());
    if (!*message) return tl::unexpected(silent(asked));
    if ((*message)->id != id) continue;  // of something before
    if ((*message)->error) {
      return tl::unexpected(answered_with(asked, *(*message)->error));
    }
    return **std::move(message);
  }
}

std::optional<RobotFault> KlipperRobot::not_ready(const KlipperStatus& status) const {
  if (status.state == "ready") return std::nullopt;
  return RobotFault{
      RobotFaultKind::kController,
      fmt::format(
          "Klipper is not ready but in its state {}: {}; look at the machine, then "
          "FIRMWARE_RESTART, and home it",
          status.state.empty() ? "unknown" : status.state, status.message)};
}

tl::expected<void, RobotFault> KlipperRobot::ready(const std::stop_token& stop) {
  const auto fresh = open_channel();
  if (!fresh) return tl::unexpected(fresh.error());
  if (!*fresh) return {};
  const std::int64_t id = ++last_id_;
  if (const auto told = tell(klipper_info_request(id)); !told) return told;
  const auto info = answer_to(id, "info", stop);
  if (!info) return tl::unexpected(info.error());
  if (auto fault = not_ready(info->status)) {
    close_channel();  // it may say more the next time
    return tl::unexpected(*std::move(fault));
  }
  return {};
}

tl::expected<KlipperStatus, RobotFault> KlipperRobot::status(const std::stop_token& stop) {
  const std::int64_t id = ++last_id_;
  if (const auto told = tell(klipper_status_request(id)); !told) {
    return tl::unexpected(told.error());
  }
  auto answer = answer_to(id, "objects/query", stop);
  if (!answer) return tl::unexpected(answer.error());
  KlipperStatus& status = answer->status;
  if (auto fault = not_ready(status)) return tl::unexpected(*std::move(fault));
  const std::size_t axes = kKlipperAxes.size();
  if (status.live.size() < axes || status.planned.size() < axes ||
      status.commanded.size() < axes) {
    return tl::unexpected(link_fault(
        {FaultKind::kBadFrame,
         "objects/query is answered without motion_report and gcode_move: is it older than "
         "version 0.10?"}));
  }
  return std::move(status);
}

// Klipper tells the live position in the machine's coordinates, its offsets (SET_GCODE_OFFSET,
// G92) by the same end of all moves in both.
std::vector<double> KlipperRobot::stands_at(const KlipperStatus& status) const {
  std::vector<double> values;
  for (const char letter : settings_.axes) {
    const std::size_t i = place_of(letter);
    values.push_back(status.live[i] - (status.planned[i] - status.commanded[i]));
  }
  return values;
}

RobotState KlipperRobot::shown_by(const KlipperStatus& status) const {
  const bool moves = std::abs(status.velocity) > kRests;
  const Motion rests = halted_ ? Motion::kFault : Motion::kInPosition;
  return state_of(stands_at(status), moves ? Motion::kMoving : rests);
}

tl::expected<RobotState, RobotFault> KlipperRobot::state_now(const std::stop_token& stop) {
  if (const auto good = ready(stop); !good) return tl::unexpected(good.error());
  const auto now = status(stop);
  if (!now) return tl::unexpected(now.error());
  return shown_by(*now);
}

std::optional<RobotFault> KlipperRobot::beyond(
    const KlipperStatus& status, const std::vector<double>& target) const {
  for (std::size_t j = 0; j < target.size(); ++j) {
    const std::size_t i = place_of(settings_.axes[j]);
    const double machine = target[j] + status.planned[i] - status.commanded[i];
    const bool under = i < status.low.size() && machine < status.low[i];
    const bool over = i < status.high.size() && machine > status.high[i];
    if (!under && !over) continue;
    return RobotFault{
        RobotFaultKind::kUnreachable,
        fmt::format(
            "{} ({}) would go to {}, its travel ends at {}", settings_.axes[j], joints_[j].name,
            figure_text(machine), figure_text(under ? status.low[i] : status.high[i]))};
  }
  return std::nullopt;
}

/// Where the move begins, in the coordinates of commands.
tl::expected<std::vector<double>, RobotFault> KlipperRobot::ready_to_move(
    const std::vector<double>& target, const std::stop_token& stop) {
  auto before = status(stop);
  if (!before) return tl::unexpected(before.error());
  const bool moves = std::abs(before->velocity) > kRests && !halted_;
  if (moves || before->print == "printing") {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController,
        "the machine moves already: let what runs on it come to its end"});
  }
  for (std::size_t j = 0; j < target.size(); ++j) {
    const char small = static_cast<char>(settings_.axes[j] - 'A' + 'a');
    if (before->homed.find(small) != std::string::npos) continue;
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController,
        fmt::format("axis {} ({}) is not homed: G28", settings_.axes[j], joints_[j].name)});
  }
  if (auto fault = beyond(*before, target)) return tl::unexpected(*std::move(fault));
  // The rest of a stopped move is run through, and targets are targets, not steps.
  if (const auto done = script("M400\nG90", answer_by() + kKlipperAhead, stop); !done) {
    if (done.error().kind != RobotFaultKind::kNotThere) return tl::unexpected(done.error());
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController,
        "Klipper is busy with another script: let it come to its end"});
  }
  const auto now = status(stop);
  if (!now) return tl::unexpected(now.error());
  std::vector<double> from;
  for (const char letter : settings_.axes) from.push_back(now->commanded[place_of(letter)]);
  return from;
}

// Klipper answers queries at once, whatever script it is at: it is looked at meanwhile.
tl::expected<void, RobotFault> KlipperRobot::script(
    const std::string& text, WallTime deadline, const std::stop_token& stop) {
  const std::int64_t id = ++last_id_;
  if (const auto told = tell(klipper_script_request(id, text)); !told) return told;
  auto next_look = steady_clock::now() + kLook;
  std::int64_t look = 0;  // asked, and not answered yet
  auto silent_at = steady_clock::now() + longest_wait();
  for (;;) {
    const auto now = steady_clock::now();
    if (now >= deadline) {
      return tl::unexpected(
          RobotFault{RobotFaultKind::kNotThere, "the move has not ended in its time"});
    }
    if (look == 0 && now >= next_look) {
      look = ++last_id_;
      silent_at = now + longest_wait();
      if (const auto told = tell(klipper_status_request(look)); !told) return told;
    }
    const auto message =
        message_by(std::min(deadline, look == 0 ? next_look : silent_at), stop);
    if (!message) return tl::unexpected(message.error());
    if (!*message) {
      if (look != 0 && steady_clock::now() >= silent_at) {
        return tl::unexpected(silent("objects/query"));
      }
      continue;
    }
    const KlipperMessage& said = **message;
    if (said.id == id) {
      if (said.error) return tl::unexpected(answered_with(text, *said.error));
      return {};
    }
    if (look == 0 || said.id != look) continue;
    look = 0;
    next_look = steady_clock::now() + kLook;
    if (said.error) return tl::unexpected(answered_with("objects/query", *said.error));
    if (auto fault = not_ready(said.status)) return tl::unexpected(*std::move(fault));
  }
}

tl::expected<void, RobotFault> KlipperRobot::move_in_pieces(
    const std::vector<double>& from, const std::vector<double>& target, WallTime deadline,
    const std::stop_token& stop) {
  double way = 0.0;
  for (std::size_t j = 0; j < target.size(); ++j) way = std::hypot(way, target[j] - from[j]);
  const double fast = feed();
  const double pieces = std::max(1.0, std::ceil(way / (fast / 60.0 * kKlipperPiece_s)));
  std::vector<double> next(target.size());
  for (double piece = 1.0; piece <= pieces; piece += 1.0) {
    if (stop_asked_) return {};
    for (std::size_t j = 0; j < target.size(); ++j) {
      next[j] = from[j] + (target[j] - from[j]) * (piece / pieces);
    }
    const std::string words = move_words(piece == pieces ? target : next, fast);
    if (const auto taken = script(words, deadline, stop); !taken) return taken;
  }
  return script("M400", deadline, stop);
}

tl::expected<RobotState, RobotFault> KlipperRobot::go_to(
    const std::vector<double>& target, milliseconds timeout, const std::stop_token& stop) {
  if (const auto good = ready(stop); !good) return tl::unexpected(good.error());
  const auto from = ready_to_move(target, stop);
  if (!from) return tl::unexpected(from.error());
  halted_ = false;
  ++moves_;
  const auto ended = move_in_pieces(*from, target, ends_by(timeout), stop);
  if (ended && !stop_asked_) {
    const auto now = status(stop);
    if (!now) return tl::unexpected(now.error());
    if (auto fault = not_there(stands_at(*now), target)) {
      return tl::unexpected(*std::move(fault));
    }
    return shown_by(*now);
  }
  // It gets no more of the move; what it has already it runs through.
  halted_ = true;
  const bool answers = ended || ended.error().kind == RobotFaultKind::kUnreachable ||
                       ended.error().kind == RobotFaultKind::kController;
  if (answers) {
    const auto by = steady_clock::now() + clock_.wall_timeout(kKlipperAhead, kKlipperAhead);
    (void)script("M400", by, stop);  // best effort: the cause is reported anyway
  }
  if (!ended) return tl::unexpected(ended.error());
  return tl::unexpected(RobotFault{RobotFaultKind::kHalted, "the robot was stopped"});
}

tl::expected<void, RobotFault> KlipperRobot::halt(const std::stop_token& stop) {
  if (moving_) {
    stop_asked_ = true;
    return {};
  }
  const auto turn = turn_of_halt();
  if (!turn) return {};
  if (const auto good = ready(stop); !good) return good;
  const auto now = status(stop);
  if (!now) return tl::unexpected(now.error());
  if (std::abs(now->velocity) <= kRests) return {};
  if (halted_) return {};  // the rest of a stopped move
  return tl::unexpected(RobotFault{
      RobotFaultKind::kController,
      "it moves, and not by this program: Klipper ends such a move only by its emergency stop "
      "(M112)"});
}

}  // namespace sixdial::acquisition
