#include "studies/socket_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "geometry/instrument_kind.h"
#include "session/plan_in_space.h"
#include "studies/error.h"

namespace sixdial::studies {
namespace {

[[noreturn]] void refuse_request(
    std::string_view param, const std::string& message, std::string hint) {
  throw StudyError(
      StudyErrorCode::kInvalidParams, message, {{"param", std::string(param)}},
      std::move(hint));
}

void check_arm(const geometry::Rig& arm) {
  const geometry::RobotModel& robot = *arm.robot.model;
  if (robot.axes != 3) {
    refuse_arm(
        fmt::format("a {} works in the plane", robot.kind->in_words),
        "A ball in sockets calibrates arms that work in space.");
  }
  if (!session::lists_its_joints(arm) || robot.kind->inverse == nullptr) {
    refuse_arm(
        fmt::format("a {} does not turn its tool in many ways", robot.kind->in_words),
        "A ball in sockets calibrates arms, of which rig.toml lists every [[joint]].");
  }
  if (session::lacks_ranges(arm)) {
    refuse_arm(
        "rig.toml does not say how far every joint may go",
        "Give each [[joint]] its low_deg and high_deg (low_mm and high_mm of one that slides): "
        "the poses are drawn from these ranges.");
  }
}

void check_request(const SocketPlanRequest& request) {
  if (request.at_mm.size() < 2) {
    refuse_request(
        "at", request.at_mm.empty() ? "no socket's place is given" : "one socket is too few",
        "With one socket a robot that is larger, or stands elsewhere, fits as well: print a "
        "second one, then sixdial plan sockets ... --at X Y Z --at X Y Z");
  }
  constexpr double kSame_mm = 1.0;
  for (std::size_t i = 0; i < request.at_mm.size(); ++i) {
    if (!request.at_mm[i].allFinite()) {
      refuse_request("at", "a place is no number", "Give x, y and z in mm.");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if ((request.at_mm[i] - request.at_mm[k]).norm() > kSame_mm) continue;
      refuse_request(
          "at", fmt::format("the {}. and the {}. socket are at the same place", k + 1, i + 1),
          "Give each socket its own place.");
    }
  }
  if (request.count < 1 || request.to_judge < 0) {
    refuse_request(
        "count", "so many poses make no plan", "Ask for one or more of each socket.");
  }
  if (!(request.seat.cone_rad > 0.0) || request.seat.cone_rad > std::numbers::pi / 2) {
    refuse_request(
        "cone", "a ball cannot come into a socket so",
        "Give the angle between stem and axis in degrees, above 0 and at most 90.");
  }
  for (const auto& [name, direction] :
       {std::pair{"axis", request.seat.axis}, std::pair{"stem", request.seat.stem}}) {
    if (direction.allFinite() && direction.norm() > 0.0) continue;
    refuse_request(name, "a direction of length 0 is none", "Give one, such as 0 0 1.");
  }
  if (request.seat_sd_mm && !(*request.seat_sd_mm > 0.0)) {
    refuse_request("seat-sd", "the ball comes back to within nothing", "Give mm above 0.");
  }
  if (request.distance_mm && !(*request.distance_mm > 0.0 && request.distance_sd_mm > 0.0)) {
    refuse_request(
        "distance", "a distance and its deviation are above 0",
        "Say both in mm: sixdial plan sockets ... --distance 180 --distance-sd 0.05");
  }
}

/// Deviation of the seat, names, distances of pairs.
void set_sockets(const SocketPlanRequest& request, geometry::Instrument& is) {
  const bool had_sd = is.kind == "socket" && is.sd_mm > 0.0;
  if (!had_sd) is.sd_mm = kUsualSeat_mm;
  if (request.seat_sd_mm) is.sd_mm = *request.seat_sd_mm;
  is.kind = "socket";
  is.dimensions = 3;
  const std::size_t count = request.at_mm.size();
  if (!is.sockets.empty() && is.sockets.size() != count) {
    refuse_request(
        "at",
        fmt::format(
            "{} places are given, and rig.toml has {} [[socket]] rows", count,
            is.sockets.size()),
        "Give the place of each in their order, or take the rows out.");
  }
  while (is.sockets.size() < count) {
    is.sockets.push_back({.name = fmt::format("S{}", is.sockets.size() + 1)});
  }
  for (std::size_t i = 1; request.distance_mm && i < count; i += 2) {
    const std::string& first = is.sockets[i - 1].name;
    const std::string& second = is.sockets[i].name;
    std::erase_if(is.socket_distances, [&](const geometry::SocketDistance& known) {
      return (known.first == first && known.second == second) ||
             (known.first == second && known.second == first);
    });
    is.socket_distances.push_back(
        {first, second, *request.distance_mm, request.distance_sd_mm});
  }
}

}  // namespace

void refuse_arm(const std::string& message, std::string hint) {
  throw StudyError(StudyErrorCode::kBadData, message, {}, std::move(hint));
}

geometry::Rig with_sockets(const geometry::Rig& arm, const SocketPlanRequest& request) {
  check_arm(arm);
  check_request(request);
  geometry::Rig rig = arm;
  set_sockets(request, rig.instrument);
  try {
    static_cast<void>(geometry::instrument_of(rig));
  } catch (const std::invalid_argument& fault) {
    refuse_arm(fault.what(), "Look at the [[socket]] rows of rig.toml.");
  }
  return rig;
}

}  // namespace sixdial::studies
