// The lines of controllers that take G-code, typed from their own pages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "acquisition/robots/gcode/dialect.h"

namespace sixdial::acquisition {
namespace {

using testing::HasSubstr;

GcodeLine read(const char* dialect, std::string_view line) {
  const auto parsed = find_gcode_dialect(dialect)->parse(line);
  EXPECT_TRUE(parsed) << line;
  return parsed.value_or(GcodeLine{});
}
bool refused(const char* dialect, std::string_view line) {
  return !find_gcode_dialect(dialect)->parse(line);
}

TEST(GcodeDialects, EachSaysHowItIsSpokenTo) {
  std::set<std::string_view> names;
  for (const GcodeDialect* is : gcode_dialects()) {
    EXPECT_TRUE(names.insert(is->name).second) << is->name;
    EXPECT_EQ(find_gcode_dialect(is->name), is);
    EXPECT_FALSE(
        is->in_words.empty() || is->ask.empty() || is->wait.empty() || is->halt.empty() ||
        is->how_it_halts.empty())
        << is->name;
    EXPECT_EQ(read(is->name.data(), "ok").kind, GcodeLineKind::kOk);
  }
  EXPECT_EQ(find_gcode_dialect("fanuc"), nullptr);
}

TEST(Grbl, ReadsTheReportsOfItsInterfacePage) {
  const GcodeLine idle =
      read("grbl", "<Idle|MPos:10.000,-5.250,0.000|FS:0,0|WCO:5.000,0.000,1.500>");
  EXPECT_EQ(idle.kind, GcodeLineKind::kReport);
  EXPECT_EQ(idle.motion, Motion::kInPosition);
  ASSERT_EQ(idle.machine.size(), 3u);
  EXPECT_EQ(idle.machine[1].letter, 'Y');
  EXPECT_EQ(idle.machine[1].value, -5.25);
  EXPECT_EQ(idle.machine[1].decimals, 3);
  EXPECT_EQ(idle.offset[2].value, 1.5);
  EXPECT_TRUE(idle.position.empty());
  const GcodeLine run =
      read("grbl", "<Run|WPos:1.0,2.0,3.0,45.5|Bf:15,128|FS:500,8000|Ov:100,100,100>");
  EXPECT_EQ(run.motion, Motion::kMoving);
  EXPECT_EQ(run.position[3].letter, 'A');
  const GcodeLine held = read("grbl", "<Hold:0|MPos:0.000,0.000,0.000|FS:0,0>");
  EXPECT_EQ(held.motion, Motion::kFault);
  EXPECT_TRUE(held.halted);
  EXPECT_EQ(read("grbl", "<Hold:1|MPos:0.000,0.000,0.000>").motion, Motion::kMoving)
      << "it still slows down";
  EXPECT_THAT(read("grbl", "<Alarm|MPos:0.000,0.000,0.000>").words, HasSubstr("$X"));
}

TEST(Grbl, ReadsErrorsAlarmsAndTheGreeting) {
  const GcodeLine locked = read("grbl", "error:9");
  EXPECT_EQ(locked.kind, GcodeLineKind::kError);
  EXPECT_THAT(locked.words, HasSubstr("locked"));
  EXPECT_THAT(read("grbl", "error:79").words, HasSubstr("its manual"));
  EXPECT_TRUE(read("grbl", "error:15").unreachable);
  const GcodeLine alarm = read("grbl", "ALARM:1");
  EXPECT_EQ(alarm.kind, GcodeLineKind::kAlarm);
  EXPECT_THAT(alarm.words, HasSubstr("limit switch"));
  EXPECT_EQ(read("grbl", "Grbl 1.1h ['$' for help]").kind, GcodeLineKind::kRestarted);
  EXPECT_EQ(read("grbl", "[MSG:'$H'|'$X' to unlock]").kind, GcodeLineKind::kRemark);
  EXPECT_EQ(read("grbl", "$130=200.000").kind, GcodeLineKind::kRemark);
}

TEST(Grbl, RefusesWhatIsCutOrNoneOfItsLines) {
  for (const char* line :
       {"<Idle|MPos:10.000,-5.2", "<Idle|MPos:10.000,,0.000>", "<Idle|MPos:1e3,0,0>",
        "<Idle|MPos:nan,0,0>", "<Idle|FS:0,0>", "<Idle|MPos:0,0,0|WPos:0,0,0>",
        "<Dancing|MPos:0,0,0>", "error:", "error:-1", "error:9x", "ALARM:", "okk", "o", "<>",
        "\x80\x01", "X:1.00 Y:2.00"}) {
    EXPECT_TRUE(refused("grbl", line)) << line;
  }
}

TEST(Marlin, ReadsThePositionThatM114Prints) {
  const GcodeLine at = read("marlin", "X:10.00 Y:-5.25 Z:0.00 E:0.00 Count X:800 Y:-420 Z:0");
  EXPECT_EQ(at.kind, GcodeLineKind::kReport);
  ASSERT_EQ(at.position.size(), 4u);
  EXPECT_EQ(at.position[1].value, -5.25);
  EXPECT_EQ(at.position[1].decimals, 2);
  EXPECT_FALSE(at.motion);
  EXPECT_EQ(read("marlin", "ok P15 B3").kind, GcodeLineKind::kOk);
  EXPECT_EQ(read("marlin", "echo:busy: processing").kind, GcodeLineKind::kRemark);
  EXPECT_EQ(read("marlin", "start").kind, GcodeLineKind::kRestarted);
  const GcodeLine killed = read("marlin", "Error:Printer halted. kill() called!");
  EXPECT_EQ(killed.kind, GcodeLineKind::kError);
  EXPECT_THAT(killed.words, HasSubstr("kill"));
  for (const char* line :
       {"X:10.00 Y:", "X:10.00 Y:-5.25x", "X:1.00 X:2.00", "X:inf Y:0.00", "\x01ok"}) {
    EXPECT_TRUE(refused("marlin", line)) << line;
  }
}

TEST(Klipper, ReadsErrorsAndSaysWhichMeanOutOfReach) {
  EXPECT_TRUE(read("klipper", "!! Move out of range: 400.000 0.000 0.000 [0.000]").unreachable);
  const GcodeLine unhomed =
      read("klipper", "!! Must home axis first: 10.000 0.000 0.000 [0.000]");
  EXPECT_EQ(unhomed.kind, GcodeLineKind::kError);
  EXPECT_FALSE(unhomed.unreachable);
  EXPECT_EQ(read("klipper", "X:10.000 Y:-5.250 Z:0.000 E:0.000").position[1].value, -5.25);
  EXPECT_EQ(read("klipper", "// Klipper state: Ready").kind, GcodeLineKind::kRemark);
  EXPECT_TRUE(refused("klipper", "?;garbage"));
}

TEST(GcodeDialects, RandomBytesDoNoHarmAndFiguresAreFinite) {
  std::mt19937 random(20260302);
  constexpr std::string_view kPieces =
      "<>|:,.-0123456789XYZABCMPosWCIdleRunHold okeror!ALRM\n\x80";
  int reports = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::string line = i % 2 == 0 ? "<Idle|MPos:1.000,2.000,3.000>" : "X:1.00 Y:2.00 Z:3.00";
    for (int change = 0; change <= i % 4; ++change) {
      line[random() % line.size()] = kPieces[random() % kPieces.size()];
    }
    for (const GcodeDialect* is : gcode_dialects()) {
      const auto parsed = is->parse(line);
      if (!parsed || parsed->kind != GcodeLineKind::kReport) continue;
      ++reports;
      for (const auto* axes : {&parsed->position, &parsed->machine, &parsed->offset}) {
        for (const AxisFigure& each : *axes) ASSERT_TRUE(std::isfinite(each.value)) << line;
      }
    }
  }
  EXPECT_GT(reports, 3'000);
}

}  // namespace
}  // namespace sixdial::acquisition
