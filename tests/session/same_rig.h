// Two rigs alike in every figure that a rig file can hold.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "geometry/rig.h"

namespace sixdial::session {

inline void expect_same(const geometry::RobotModel& a, const geometry::RobotModel& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.frames, b.frames);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_EQ(a.joints[i].name, b.joints[i].name);
    EXPECT_EQ(a.joints[i].kind, b.joints[i].kind);
    EXPECT_NEAR(a.joints[i].low, b.joints[i].low, 1e-12);
    EXPECT_NEAR(a.joints[i].high, b.joints[i].high, 1e-12);
    EXPECT_EQ(a.joints[i].geared, b.joints[i].geared);
  }
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    EXPECT_EQ(a.parameters[i].name, b.parameters[i].name);
    EXPECT_EQ(a.parameters[i].rig_key, b.parameters[i].rig_key);
  }
}

inline void expect_same(
    const std::vector<geometry::ReferencePoint>& a,
    const std::vector<geometry::ReferencePoint>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].at_mm, b[i].at_mm);
    EXPECT_EQ(a[i].sd_mm, b[i].sd_mm);
  }
}

inline void expect_same(const geometry::Instrument& a, const geometry::Instrument& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.sd_mm, b.sd_mm);
  EXPECT_NEAR(a.sd_rad, b.sd_rad, 1e-16);
  EXPECT_EQ(a.dimensions, b.dimensions);
  EXPECT_EQ(a.orientation, b.orientation);
  expect_same(a.tool_points, b.tool_points);
  expect_same(a.anchors, b.anchors);
  expect_same(a.sockets, b.sockets);
  ASSERT_EQ(a.socket_distances.size(), b.socket_distances.size());
  for (std::size_t i = 0; i < a.socket_distances.size(); ++i) {
    EXPECT_EQ(a.socket_distances[i].first, b.socket_distances[i].first);
    EXPECT_EQ(a.socket_distances[i].second, b.socket_distances[i].second);
    EXPECT_EQ(a.socket_distances[i].mm, b.socket_distances[i].mm);
    EXPECT_EQ(a.socket_distances[i].sd_mm, b.socket_distances[i].sd_mm);
  }
  ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
  for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
    expect_same({a.surfaces[i].place}, {b.surfaces[i].place});
    EXPECT_EQ(a.surfaces[i].radius_mm, b.surfaces[i].radius_mm);
    EXPECT_EQ(a.surfaces[i].normal, b.surfaces[i].normal);
  }
}

/// Angles may differ in their last bit.
inline void expect_same(const geometry::Rig& a, const geometry::Rig& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.tolerance_mm, b.tolerance_mm);
  expect_same(*a.robot.model, *b.robot.model);
  ASSERT_EQ(a.robot.nominal.size(), b.robot.nominal.size());
  for (Eigen::Index i = 0; i < a.robot.nominal.size(); ++i) {
    EXPECT_NEAR(a.robot.nominal[i], b.robot.nominal[i], 1e-15 * std::abs(a.robot.nominal[i]));
  }
  EXPECT_EQ(a.robot.working_mode, b.robot.working_mode);
  EXPECT_EQ(a.robot.assembly, b.robot.assembly);
  EXPECT_EQ(a.robot.connection, b.robot.connection);
  expect_same(a.instrument, b.instrument);
  EXPECT_EQ(a.cuboid.side_mm, b.cuboid.side_mm);
  EXPECT_EQ(a.cuboid.mount, b.cuboid.mount);
  EXPECT_EQ(a.cuboid.reference_pose_mm, b.cuboid.reference_pose_mm);
  EXPECT_TRUE(a.cuboid.deviations == b.cuboid.deviations);
  ASSERT_EQ(a.dials.size(), b.dials.size());
  for (std::size_t i = 0; i < a.dials.size(); ++i) {
    const geometry::Dial& dial = a.dials[i];
    const geometry::Dial& other = b.dials[i];
    EXPECT_EQ(dial.id, other.id);
    EXPECT_EQ(dial.geometry.position_mm, other.geometry.position_mm);
    EXPECT_EQ(dial.geometry.axis, other.geometry.axis);
    EXPECT_EQ(dial.geometry.travel_mm, other.geometry.travel_mm);
    EXPECT_EQ(dial.geometry.tip_radius_mm, other.geometry.tip_radius_mm);
    EXPECT_EQ(dial.resolution_mm, other.resolution_mm);
    EXPECT_EQ(dial.accuracy_mm, other.accuracy_mm);
    EXPECT_EQ(dial.repeatability_mm, other.repeatability_mm);
    EXPECT_EQ(dial.force_n, other.force_n);
    EXPECT_EQ(dial.spring_n_per_mm, other.spring_n_per_mm);
    EXPECT_EQ(dial.connection, other.connection);
    EXPECT_TRUE(dial.deviations == other.deviations);
  }
}

}  // namespace sixdial::session
