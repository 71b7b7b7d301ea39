// A gantry: its joints slide, so that nothing of them is an angle, in figures or in words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/tool.h"
#include "report/documents/diagnosis_json.h"
#include "report/sections/sections_of_studies.h"
#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_text.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"
#include "studies/diagnose.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kGantry =
    "name = \"gantry\"\n[robot]\nmodel = \"serial\"\ntool_z_mm = 40\n"
    "[[joint]]\nkind = \"prismatic\"\nalpha_deg = 90\n"
    "[[joint]]\nkind = \"prismatic\"\ntheta_deg = 90\nalpha_deg = 90\n"
    "[[joint]]\nkind = \"prismatic\"\n"
    "[instrument]\nkind = \"position\"\nsd_mm = 0.01\n";
constexpr double kStroke_mm = 300.0;
constexpr double kBacklash_mm = 0.05;

/// Backlash of the first slide.
session::Session gantry_session() {
  session::Session session;
  session.name = "gantry";
  session.rig_text = kGantry;
  session.rig = session::parse_rig(session.rig_text, "rig.toml");
  const geometry::Tool tool(session.rig);
  const geometry::Robot& robot = session.rig.robot;
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> stroke(0.0, kStroke_mm);
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (int i = 0; i < 90; ++i) {
    session::Sample sample;
    sample.set = i < 60 ? "G1" : "G2";
    sample.point = i;
    const Eigen::Vector3d q(stroke(engine), stroke(engine), stroke(engine));
    sample.q = q;
    Eigen::VectorXd stood = q;
    // It lags behind; nobody knows from where it came to the first pose.
    if (i > 0) stood[0] -= 0.5 * kBacklash_mm * (q[0] > before[0] ? 1.0 : -1.0);
    before = q;
    geometry::Position p = tool.position(robot.nominal, stood, robot.assembly).value();
    for (double& each : p) each += 0.01 * normal(engine);
    session::set_position(sample, 0, p);
    session.samples.push_back(sample);
  }
  return session;
}

TEST(GantryDiagnosis, SpeaksOfTravelInMillimetres) {
  const DiagnosisResult made =
      diagnose(gantry_session(), {.bootstrap = 0, .with_gain = false, .threads = 1});
  // As the document brings it.
  const DiagnosisResult result = report::diagnosis_from_json(report::to_json(made));
  int slides = 0;
  for (const LeftAlong& along : result.left_along) {
    EXPECT_NE(along.along.axis, CurveAxis::kJointAngle);
    if (along.along.axis != CurveAxis::kJointSlide) continue;
    EXPECT_EQ(report::axis_unit(along.along), "mm");
    for (const LeftInClass& each : along.classes) {
      EXPECT_GE(each.low, 0.0);
      EXPECT_LE(each.high, kStroke_mm);
    }
    ++slides;
  }
  EXPECT_EQ(slides, 3);
  const auto found = std::ranges::find_if(result.causes, [](const FoundCause& each) {
    return each.id.name() == "joint_backlash@joint1";
  });
  ASSERT_NE(found, result.causes.end()) << report::diagnosis_text(result);
  const FoundCause& cause = *found;
  ASSERT_TRUE(cause.signature);
  EXPECT_EQ(cause.signature->quantity, Quantity::kJointSlideError);
  EXPECT_EQ(cause.signature->along.axis, CurveAxis::kJointSlide);
  EXPECT_EQ(report::quantity_name(*cause.signature), "travel error of joint 1");
  for (const CurveGroup& group : cause.signature->panels.at(0).groups) {
    for (const double model_mm : group.model) {
      EXPECT_NEAR(std::abs(model_mm), kBacklash_mm / 2, 0.005);
    }
  }
  EXPECT_THAT(report::diagnosis_text(result), Not(HasSubstr("theta")));
  std::string titles;
  for (const report::Section& section : report::diagnosis_sections(result)) {
    for (const report::Block& block : section.blocks) {
      const auto* figure = std::get_if<report::Figure>(&block);
      if (figure == nullptr) continue;
      titles += figure->title + '|' + figure->here + '\n';
      for (const report::Panel& panel : figure->chart.panels) {
        titles += panel.title + '|' + panel.x.label + '|' + panel.y.label + '\n';
      }
    }
  }
  EXPECT_THAT(titles, HasSubstr("travel of joint 3"));
  EXPECT_THAT(titles, Not(HasSubstr("theta")));
  EXPECT_THAT(titles, Not(HasSubstr("angle")));
}

}  // namespace
}  // namespace sixdial::studies
