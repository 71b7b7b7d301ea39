// Whether an instrument knows the frame in which it measures, of every kind that has places.
#include "geometry/instrument_frame.h"

#include <gtest/gtest.h>

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {
namespace {

Rig arm_under(const std::string& kind) {
  Rig rig;
  rig.robot.model = find_robot_kind("serial")->example();
  rig.robot.nominal = rig.robot.model->nominal;
  rig.instrument.kind = kind;
  rig.instrument.dimensions = 3;
  rig.instrument.sockets = {{.name = "S1"}, {.name = "S2"}};
  rig.instrument.anchors = {{.name = "K1"}, {.name = "K2"}, {.name = "K3"}};
  rig.instrument.surfaces = {{.place = {.name = "ball"}, .radius_mm = 20.0}};
  return rig;
}

TEST(InstrumentFrame, IsKnownWherePositionsAreMeasured) {
  EXPECT_TRUE(knows_the_frame(default_rig()));
  EXPECT_TRUE(knows_the_frame(arm_under("position")));
  EXPECT_TRUE(knows_the_frame(arm_under("pose")));
}

TEST(InstrumentFrame, IsNotKnownWhereNoPlaceIs) {
  for (const char* const kind : {"socket", "distance", "probe"}) {
    EXPECT_FALSE(knows_the_frame(arm_under(kind))) << kind;
  }
}

TEST(InstrumentFrame, IsKnownByOnePlaceHoweverWell) {
  for (const double sd_mm : {0.0, 0.5}) {
    const ReferencePoint known{"there", Eigen::Vector3d(500, 0, 100), sd_mm};
    Rig rig = arm_under("socket");
    rig.instrument.sockets.push_back(known);
    EXPECT_TRUE(knows_the_frame(rig)) << sd_mm;
    rig = arm_under("distance");
    rig.instrument.anchors.push_back(known);
    EXPECT_TRUE(knows_the_frame(rig)) << sd_mm;
    rig = arm_under("probe");
    rig.instrument.surfaces.push_back({.place = known, .radius_mm = 10.0});
    EXPECT_TRUE(knows_the_frame(rig)) << sd_mm;
  }
}

TEST(InstrumentFrame, ADistanceOfSocketsIsNoPlace) {
  Rig rig = arm_under("socket");
  rig.instrument.socket_distances = {{"S1", "S2", 150.0, 0.05}};
  EXPECT_FALSE(knows_the_frame(rig));
}

}  // namespace
}  // namespace sixdial::geometry
