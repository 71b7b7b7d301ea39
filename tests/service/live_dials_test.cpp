// What a person sees of a dial: words for every code, and no alarm while it merely moves.
#include "service/live_dials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "acquisition/dial_protocol.h"
#include "acquisition/modbus_bus.h"
#include "session/reason.h"
#include "session/reason_words.h"

namespace sixdial::service {
namespace {

using acquisition::CollectorStage;
using acquisition::FaultKind;
using ::testing::HasSubstr;

constexpr std::array kKinds{
    FaultKind::kTimeout,      FaultKind::kDisconnected, FaultKind::kBadFrame,
    FaultKind::kWrongChannel, FaultKind::kRange,        FaultKind::kUnit,
    FaultKind::kDevice,       FaultKind::kNoDial,       FaultKind::kBusy,
    FaultKind::kWrongDial,    FaultKind::kStale};

Json shown(FaultKind kind, CollectorStage stage) {
  const geometry::Rig rig = geometry::default_rig();
  std::vector<acquisition::Reading> readings(
      rig.dials.size(), acquisition::good_reading(12.0, acquisition::DeviceTime(1), {}));
  readings[2] = acquisition::bad_reading(
      acquisition::Fault{kind, "evidence"}, acquisition::DeviceTime(1), {});
  acquisition::CollectorProgress now;
  now.stage = stage;
  return LiveDials(rig).show(readings, nullptr, now)["dials"]["C"];
}

TEST(LiveDials, ADialThatGivesNoValueWhileItMovesIsNotLost) {
  for (const FaultKind kind :
       {FaultKind::kNoDial, FaultKind::kBusy, FaultKind::kDevice, FaultKind::kTimeout}) {
    EXPECT_EQ(shown(kind, CollectorStage::kMoving)["state"], "waiting");
    EXPECT_EQ(shown(kind, CollectorStage::kSettling)["state"], "lost");
  }
  for (const FaultKind kind :
       {FaultKind::kDisconnected, FaultKind::kUnit, FaultKind::kWrongDial}) {
    EXPECT_EQ(shown(kind, CollectorStage::kMoving)["state"], "lost");
  }
  EXPECT_EQ(shown(FaultKind::kStale, CollectorStage::kMoving)["state"], "stale");
}

TEST(LiveDials, EveryReasonHasWordsThatFitBesideAFigure) {
  for (const FaultKind kind : kKinds) {
    const std::string_view code = acquisition::reason(kind);
    const std::string_view brief = session::brief_words(code);
    EXPECT_LE(brief.size(), 14U) << code;
    EXPECT_GT(session::reason_words(code).size(), code.size()) << code;
    EXPECT_EQ(shown(kind, CollectorStage::kSettling)["words"], std::string(brief));
  }
  EXPECT_EQ(session::brief_words("of another program"), "of another program");
}

TEST(DialCodes, EachIsSaidInWords) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> codes{
      {"mux10", {"911\r", "912\r", "918\r", "919\r"}},
      {"sylvac", {"ERR0\r", "ERR1\r", "ERR2\r", "ERR3\r"}},
      {"mahr", {"ERR2\r", "ERR3\r", "ERR4\r"}},
      {"mw", {"3 TO 999999.99 mm\r\n"}}};
  for (const auto& [name, frames] : codes) {
    const auto* protocol = acquisition::find_dial_protocol(name);
    ASSERT_NE(protocol, nullptr);
    ASSERT_NE(protocol->says, nullptr) << name;
    for (const std::string& frame : frames) {
      EXPECT_FALSE(protocol->parse(frame, 3)) << frame;
      EXPECT_GT(protocol->says(frame).size(), 15U) << name << ' ' << frame;
    }
    EXPECT_TRUE(protocol->says("+012.345\r").empty());
    EXPECT_TRUE(protocol->says("").empty());
  }
  constexpr std::array<std::uint16_t, 5> kStates{18, 19, 42, 246, 247};
  for (const std::uint16_t status : kStates) {
    const auto fault = acquisition::fault_of_status(status);
    ASSERT_TRUE(fault);
    EXPECT_THAT(fault->detail, HasSubstr(std::to_string(status)));
    EXPECT_GT(fault->detail.size(), 25U) << "words, not the number alone";
  }
}

}  // namespace
}  // namespace sixdial::service
