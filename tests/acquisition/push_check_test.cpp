// "Push each with a finger", on readings as a bank of dials gives them.
#include "acquisition/push_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "acquisition/port_rights.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Finger : public ::testing::Test {
 protected:
  /// One scan; dials that are not named show their rest.
  void show(const std::map<std::string, double>& values_mm) {
    std::vector<Reading> readings;
    for (const geometry::Dial& dial : rig_.dials) {
      const auto found = values_mm.find(dial.id);
      const double value_mm = found == values_mm.end() ? rest_mm_[dial.id] : found->second;
      Reading reading = good_reading(value_mm, DeviceTime(++now_), {});
      if (found == values_mm.end() && value_mm == 0.0) {
        reading.value_mm.reset();
        reading.reason = session::reason::kNoContact;
      }
      readings.push_back(reading);
    }
    check_.take(readings);
  }
  void push(const std::string& id, double by_mm) {
    show({});
    for (const double share : {0.4, 1.0, 0.5}) show({{id, rest_mm_[id] + share * by_mm}});
    show({});
  }
  [[nodiscard]] PushVerdict verdict(std::size_t i) const { return check_.dials()[i].verdict; }
  [[nodiscard]] std::string words(std::size_t i) const {
    return describe(check_.dials()[i], rig_.dials[i].geometry.travel_mm);
  }

  geometry::Rig rig_ = geometry::default_rig();
  PushCheck check_{rig_};
  std::map<std::string, double> rest_mm_;
  int now_ = 0;
};

TEST_F(Finger, EachPushedAllTheWayInItsTurnIsGood) {
  for (const geometry::Dial& dial : rig_.dials) {
    EXPECT_THAT(check_.instruction(), HasSubstr("Push dial " + dial.id + " with a finger"));
    push(dial.id, 0.95 * dial.geometry.travel_mm);
  }
  EXPECT_TRUE(check_.done());
  EXPECT_TRUE(check_.good());
  EXPECT_EQ(check_.instruction(), "");
}

TEST_F(Finger, SaysWhereTheDialStandsAndWhichWayItPoints) {
  EXPECT_THAT(check_.instruction(), HasSubstr("points to the left (-x)"));
}

TEST_F(Finger, ExchangedCablesAreNamedByBothLetters) {
  push("B", 40.0);  // A was asked for
  EXPECT_EQ(verdict(0), PushVerdict::kOther);
  EXPECT_THAT(words(0), HasSubstr("A: B moved instead"));
  push("A", 40.0);
  EXPECT_EQ(verdict(1), PushVerdict::kOther);
  EXPECT_EQ(check_.asked(), 2U);
  EXPECT_FALSE(check_.good());
}

TEST_F(Finger, ADialThatCountsDownWhenPushedInIsReversed) {
  push("A", -40.0);
  EXPECT_EQ(verdict(0), PushVerdict::kReversed);
  EXPECT_THAT(words(0), HasSubstr("counts down when pushed in"));
}

TEST_F(Finger, InchesAreToldFromMillimetres) {
  push("A", 48.0 / 25.4);
  EXPECT_EQ(verdict(0), PushVerdict::kInch);
  EXPECT_THAT(words(0), HasSubstr("Switch it to mm"));
}

TEST_F(Finger, AHalfHeartedPushIsAskedForOnceMore) {
  push("A", 8.0);
  EXPECT_EQ(verdict(0), PushVerdict::kShort);
  EXPECT_EQ(check_.asked(), 0U);
  push("A", 48.0);
  EXPECT_EQ(verdict(0), PushVerdict::kGood);
  EXPECT_EQ(check_.asked(), 1U);
}

TEST_F(Finger, TwoThatMoveTogetherAreNoWiringThatIsKnown) {
  show({});
  show({{"A", 40.0}, {"D", 40.0}});
  show({});
  EXPECT_EQ(verdict(0), PushVerdict::kTogether);
  EXPECT_THAT(words(0), HasSubstr("A, D moved together"));
}

TEST_F(Finger, AZeroThatIsNoneIsToldBesideTheRest) {
  rest_mm_["A"] = 3.2;
  push("A", 45.0);
  EXPECT_EQ(verdict(0), PushVerdict::kGood);
  EXPECT_THAT(words(0), HasSubstr("With the plunger free it showed +3.200 mm"));
  for (std::size_t i = 1; i < rig_.dials.size(); ++i) push(rig_.dials[i].id, 45.0);
  EXPECT_TRUE(check_.done());
  EXPECT_FALSE(check_.good());
}

TEST_F(Finger, AHandOnTheTableIsNoPush) {
  show({});
  show({{"A", 0.05}, {"B", 0.04}});
  show({});
  EXPECT_EQ(verdict(0), PushVerdict::kOpen);
}

TEST_F(Finger, AskedAgainAtTheEndOnlyWhatWasNotGoodIsOpen) {
  push("A", 40.0);
  check_.skip();
  for (std::size_t i = 2; i < rig_.dials.size(); ++i) push(rig_.dials[i].id, 45.0);
  ASSERT_TRUE(check_.done());
  EXPECT_EQ(verdict(1), PushVerdict::kSkipped);
  check_.again();
  EXPECT_EQ(check_.asked(), 1U);
  push("B", 45.0);
  EXPECT_TRUE(check_.done());
  EXPECT_TRUE(check_.good());
}

TEST(PortRights, NobodyIsAdvisedIntoTheGroupOfRoot) {
  for (const PortGroup& group :
       {PortGroup{.name = "root", .may_open = true, .is_root = true},
        PortGroup{.name = "root", .may_open = false, .is_root = true},
        PortGroup{.name = "dialout", .may_open = false},
        PortGroup{.name = "", .may_open = true}}) {
    const std::string advice = rights_advice(group);
    EXPECT_THAT(advice, Not(HasSubstr("-aG root")));
    EXPECT_THAT(advice, HasSubstr("/etc/udev/rules.d/"));
    EXPECT_THAT(advice, HasSubstr("-aG dialout"));
  }
  EXPECT_THAT(
      rights_advice(PortGroup{.name = "uucp", .may_open = true}),
      HasSubstr("sudo usermod -aG uucp $USER"));
  EXPECT_THAT(
      rights_advice(PortGroup{.name = "dialout", .may_open = true, .user_is_in = true}),
      HasSubstr("since your last login"));
}

}  // namespace
}  // namespace sixdial::acquisition
