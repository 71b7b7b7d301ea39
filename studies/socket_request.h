// What sixdial plan sockets is asked (socket_plan.h), judged, and the rig that it is asked of.
#pragma once

#include <string>

#include "geometry/rig.h"
#include "studies/socket_plan.h"

namespace sixdial::studies {

/// The arm with the request's sockets as its instrument: named as its rig file does, else S1,
/// S2, ... Throws StudyError as socket_plan does.
[[nodiscard]] geometry::Rig with_sockets(
    const geometry::Rig& arm, const SocketPlanRequest& request);

/// Throws StudyError bad_data.
[[noreturn]] void refuse_arm(const std::string& message, std::string hint);

}  // namespace sixdial::studies
