// A small URDF with everything that a chain may have: fixed joints, a slide, a mimic joint, a
// branch, an axis against the usual direction.
#pragma once

#include <string_view>

namespace sixdial::geometry {

inline constexpr std::string_view kGripperUrdf = R"(<?xml version="1.0"?>
<robot name="gripper">
  <link name="world"/><link name="plate"/><link name="column"/><link name="palm"/>
  <link name="thumb"/><link name="finger"/><link name="finger_tip"/><link name="camera"/>
  <joint name="bolted" type="fixed">
    <parent link="world"/><child link="plate"/><origin xyz="0 0 0.02"/>
  </joint>
  <joint name="lift" type="prismatic">
    <parent link="plate"/><child link="column"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.25" effort="1" velocity="1"/>
  </joint>
  <joint name="arm" type="fixed">
    <parent link="column"/><child link="palm"/><origin xyz="0.2 0 0"/>
  </joint>
  <joint name="knuckle" type="revolute">
    <parent link="palm"/><child link="thumb"/><axis xyz="0 -1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="second" type="revolute">
    <parent link="thumb"/><child link="finger"/><origin xyz="0.05 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
    <mimic joint="knuckle" multiplier="-0.5" offset="0.1"/>
  </joint>
  <joint name="nail" type="fixed">
    <parent link="finger"/><child link="finger_tip"/><origin xyz="0.03 0 0"/>
  </joint>
  <joint name="eye" type="fixed">
    <parent link="palm"/><child link="camera"/><origin xyz="0 0 0.1"/>
  </joint>
</robot>
)";

}  // namespace sixdial::geometry
