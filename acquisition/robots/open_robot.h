// What a connection string of a robot becomes: its port, made once its site is known. For the
// rows in this folder.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "acquisition/robot_driver.h"

namespace sixdial::acquisition {

/// Makes a Robot(parts ..., clock, joints).
template <typename Robot, typename... Parts>
[[nodiscard]] OpenRobot opens(std::span<const RobotJoint> joints, Parts... parts) {
  return [own = std::vector(joints.begin(), joints.end()),
          ... parts = std::move(parts)](const RobotSite& site) {
    return std::make_unique<Robot>(parts..., site.clock, own);
  };
}

}  // namespace sixdial::acquisition
