// The mock machine that takes G-code, spoken to by hand.
#include "mock_devices/gcode_controller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mock_devices/gcode_cable.h"

namespace sixdial::mock_devices {
namespace {

using testing::HasSubstr;

TEST(GcodeController, MovesAsLongAsItsFeedSays) {
  GcodeController machine({});
  machine.receive("G1 X10 F600\n", 1.0);
  EXPECT_EQ(machine.due(1.0), "ok\r\n");
  EXPECT_NEAR(machine.position(1.5)[0], 5.0, 1e-9) << "10 mm/s";
  machine.receive("G4 P0.01\n", 1.5);
  EXPECT_EQ(machine.due(1.9), "");
  EXPECT_EQ(machine.due(2.0), "ok\r\n");
  machine.receive("?", 2.0);
  EXPECT_THAT(machine.due(2.0), HasSubstr("<Idle|MPos:10.000,0.000,0.000|"));
}

TEST(GcodeController, AFeedHoldStopsItAndAResetKeepsItsPlace) {
  GcodeController machine({});
  machine.receive("G1 X10 F600\n", 0.0);
  machine.receive("!", 0.25);
  (void)machine.due(0.25);
  EXPECT_NEAR(machine.position(9.0)[0], 2.5, 1e-9);
  machine.receive("?", 9.0);
  EXPECT_THAT(machine.due(9.0), HasSubstr("<Hold:0|MPos:2.500"));
  machine.receive("\x18", 9.0);
  EXPECT_THAT(machine.due(9.0), HasSubstr("Grbl 1.1"));
  machine.receive("G1 X3 F600\n", 9.0);
  EXPECT_EQ(machine.due(9.0), "ok\r\n");
}

TEST(GcodeController, AResetInAMoveIsAnAlarmUntilItIsUnlocked) {
  GcodeController machine({});
  machine.receive("G1 X10 F600\n\x18", 0.0);
  machine.receive("G1 X1\n", 0.1);
  EXPECT_THAT(machine.due(0.1), testing::AllOf(HasSubstr("ALARM:3"), HasSubstr("error:9")));
  machine.receive("$X\nG1 X1 F600\n", 0.2);
  EXPECT_THAT(machine.due(0.2), testing::EndsWith("ok\r\nok\r\n"));
}

TEST(GcodeController, MarlinPrintsItsPositionInTwoDigits) {
  GcodeController machine({.firmware = GcodeFirmware::kMarlin});
  machine.receive("G1 X1.23456 F60000\nM400\nM114\n", 0.0);
  EXPECT_THAT(machine.due(1.0), HasSubstr("X:0.00 Y:0.00 Z:0.00 E:0.00 Count"));
  machine.receive("M114\n", 1.0);
  EXPECT_THAT(machine.due(1.0), HasSubstr("X:1.23 Y:0.00 Z:0.00 E:0.00 Count X:99 Y:0 Z:0"));
}

TEST(GcodeCable, WhatTheMachineSaysGoesToEachClientAndIsLostWithoutOne) {
  GcodeCable cable({});
  cable.machine().say("unheard", 0.0);
  cable.connected(1, 1.0);
  cable.connected(2, 1.0);
  EXPECT_EQ(cable.due(1, 1.0), "");
  cable.receive(2, "G1 X10 F600\n", 1.0);
  EXPECT_EQ(cable.due(1, 1.0), "ok\r\n");
  cable.gone(1);
  cable.machine().say("heard", 2.0);
  EXPECT_EQ(cable.due(2, 2.0), "ok\r\nheard\r\n");
}

}  // namespace
}  // namespace sixdial::mock_devices
