// Names of what an unexplained rest depends on, there and back.
#include "diagnosis/covariate.h"

#include <gtest/gtest.h>

namespace sixdial::diagnosis {
namespace {

TEST(DependenceNames, ComeBackAsWhatTheyWere) {
  for (const DependsOnWhat& what :
       {DependsOnWhat{.on = DependsOn::kJointAngle, .joint = 0},
        DependsOnWhat{.on = DependsOn::kJointAngle, .joint = 11},
        DependsOnWhat{.on = DependsOn::kToolX}, DependsOnWhat{.on = DependsOn::kToolY},
        DependsOnWhat{.on = DependsOn::kCuboidAngle}, DependsOnWhat{.on = DependsOn::kTime},
        DependsOnWhat{.on = DependsOn::kTemperature},
        DependsOnWhat{.on = DependsOn::kApproach, .joint = 2},
        DependsOnWhat{.on = DependsOn::kReading, .dial = "A"},
        DependsOnWhat{.on = DependsOn::kReading, .dial = "left reading"}}) {
    const std::string name = dependence_name(what);
    const auto back = dependence_from(name);
    ASSERT_TRUE(back) << name;
    EXPECT_EQ(back->on, what.on) << name;
    EXPECT_EQ(back->joint, what.joint) << name;
    EXPECT_EQ(back->dial, what.dial) << name;
  }
}

TEST(DependenceNames, AreThoseOfDocuments) {
  EXPECT_EQ(dependence_name({.on = DependsOn::kJointAngle, .joint = 1}), "theta2");
  EXPECT_EQ(dependence_name({.on = DependsOn::kApproach, .joint = 0}), "approach1");
  EXPECT_EQ(dependence_name({.on = DependsOn::kReading, .dial = "C"}), "dial C reading");
  for (const char* other :
       {"", "theta", "theta0", "theta2x", "approach", "dial  reading", "dial C", "weather"}) {
    EXPECT_FALSE(dependence_from(other)) << other;
  }
}

}  // namespace
}  // namespace sixdial::diagnosis
