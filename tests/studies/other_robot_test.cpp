// A kind of robot that the program is not built with: three joints, one of them sliding, six
// parameters, measured by an instrument that gives positions. From a session file with its own
// columns through the store to calibration, comparison, document and report page.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "db/store.h"
#include "geometry/tool.h"
#include "geometry/units.h"
#include "report/documents/calibration_json.h"
#include "report/report_run.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/compensate.h"
#include "tests/support/rig_for_tests.h"
#include "tests/support/test_arms.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNoise_mm = 0.003;

const char* const kRig = R"(name = "planar arm under a camera"
[robot]
model = "planar_arm"
working_mode = "left"
x0_mm = 5.0
y0_mm = -3.0
first_mm = 200.0
second_mm = 150.0
offset1_rad = 0.1
offset2_rad = -0.2
[instrument]
kind = "position"
sd_mm = 0.003
)";

Eigen::VectorXd true_robot() {
  Eigen::VectorXd v(6);
  v << 5.4, -3.3, 200.35, 149.8, 0.103, -0.196;
  return v;
}

/// 60 points of G1 and 30 of G2; the elbow in degrees, as its controller shows it.
void write_arm_session(const std::filesystem::path& folder) {
  const geometry::Tool tool(geometry::planar_arm().example(), 2);
  const Eigen::VectorXd& nominal = tool.robot().nominal;
  std::mt19937_64 engine(7);
  std::normal_distribution<double> noise_mm(0.0, kNoise_mm);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "rig.toml") << kRig;
  std::ofstream csv(folder / "session.csv");
  csv << "set,point,repeat,shoulder_rad,elbow_deg,wrist_mm,target_x_mm,target_y_mm,x_mm,y_mm\n";
  for (int i = 0; i < 90; ++i) {
    Eigen::VectorXd q(3);
    for (Eigen::Index joint = 0; joint < 3; ++joint) {
      const geometry::JointInfo& info = tool.robot().joints[static_cast<std::size_t>(joint)];
      q[joint] = std::uniform_real_distribution<double>(info.low, info.high)(engine);
    }
    const auto target = tool.position(nominal, q, geometry::Assembly::kLeft).value();
    const auto p = tool.position(true_robot(), q, geometry::Assembly::kLeft).value();
    csv << fmt::format(
        "{},{},0,{:.12f},{:.10f},{:.9f},{:.6f},{:.6f},{:.6f},{:.6f}\n", i < 60 ? "G1" : "G2",
        i % 60, q[0], q[1] * geometry::kDegPerRad, q[2], target.x(), target.y(),
        p.x() + noise_mm(engine), p.y() + noise_mm(engine));
  }
}

class OtherRobot : public ::testing::Test {
 protected:
  OtherRobot() {
    const auto folder = directory_.path() / "arm";
    write_arm_session(folder);
    const session::Session read = session::read_bundle(folder.string());
    db::Store store = db::Store::open((directory_.path() / "store.db").string());
    session_ = store.load_session(store.import_session(read));
  }
  [[nodiscard]] std::string page_of(const CalibrationResult& result) const {
    const auto folder = directory_.path() / "report";
    static_cast<void>(report::write_report(result, session_, "A. Person", folder));
    return text_of(folder / "report.html");
  }
  static std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  testing::TempDirectory directory_;
  session::Session session_;
};

TEST_F(OtherRobot, GoesThroughTheStoreWithItsJointsAndChannels) {
  ASSERT_EQ(session_.samples.size(), 90U);
  EXPECT_EQ(session_.rig.robot.model->kind, &geometry::planar_arm());
  EXPECT_EQ(session_.samples[3].q.size(), 3);
  EXPECT_EQ(session_.samples[3].channels.size(), 2U);
}

class OtherRobotBy : public OtherRobot, public ::testing::WithParamInterface<const char*> {};

TEST_P(OtherRobotBy, IsCalibratedAndReported) {
  CalibrationRequest request;
  request.method = GetParam();
  request.particles = 20;
  request.qpso1_iterations = 10;
  request.qpso2_iterations = 150;
  request.anfis_epochs = 10;
  const CalibrationResult found = calibrate(session_, request);
  const CalibrationResult result = report::calibration_from_json(report::to_json(found));
  EXPECT_EQ(report::to_json(result), report::to_json(found));
  ASSERT_EQ(result.parameters.size(), 6U);
  const Eigen::VectorXd truth = true_robot();
  for (std::size_t i = 0; i < 6; ++i) {
    const ParameterRow& row = result.parameters[i];
    EXPECT_EQ(row.name, session_.rig.robot.model->parameters[i].name);
    EXPECT_GT(row.sd, 0.0) << row.name;
    EXPECT_LT(std::abs(row.identified - truth[static_cast<Eigen::Index>(i)]), 4.5 * row.sd)
        << row.name;
  }
  ASSERT_NE(result.method(result.result_method), nullptr);
  EXPECT_GT(result.method("before")->g2->mean_mm, 0.1);
  EXPECT_LT(result.method(result.result_method)->g2->mean_mm, 0.01);
  ASSERT_TRUE(result.assessment->position_uncertainty);

  const std::string page = page_of(result);
  for (const char* words : {"shoulder", "elbow", "wrist", "first", "offset2"}) {
    EXPECT_THAT(page, HasSubstr(words)) << words;
  }
  for (const char* words : {"theta1", "dtheta1", "leg 1"}) {
    EXPECT_THAT(page, Not(HasSubstr(words))) << words;
  }
}

INSTANTIATE_TEST_SUITE_P(
    , OtherRobotBy, ::testing::Values("ekf_dqpso+anfis", "lm", "lm+gp"), [](const auto& each) {
      std::string name = each.param;
      std::ranges::replace(name, '+', '_');
      return name;
    });

TEST_F(OtherRobot, IsComparedByEveryMethodNamed) {
  CompareRequest request;
  request.methods = {"before", "lse", "lm", "ekf", "ekf_dqpso", "lm+rbf"};
  request.particles = 20;
  request.qpso1_iterations = 10;
  request.qpso2_iterations = 150;
  const ComparisonResult compared = compare(session_, request);
  ASSERT_EQ(compared.methods.size(), request.methods.size());
  for (const ComparedRow& row : compared.methods) {
    ASSERT_TRUE(row.g2) << row.id;
    EXPECT_EQ(row.g2->unreachable, 0) << row.id;
    if (!row.robot) continue;
    EXPECT_LT(row.g2->mean_mm, 0.05) << row.id;
    EXPECT_EQ(row.robot->parameters.size(), 6U) << row.id;
  }
  EXPECT_FALSE(compared.precision);  // there are no dials to compare with
}

TEST_F(OtherRobot, IsCommandedToItsTargets) {
  CalibrationRequest request;
  request.method = "lm";
  const CalibrationResult result = calibrate(session_, request);
  const auto model = compensation_model(result, session_.rig, CompensateBy::kKinematics);
  const Eigen::Vector2d target_mm(250.0, 80.0);
  const CommandedTarget at = compensated_target(
      model, CompensateBy::kKinematics, target_mm, session_.rig.robot.working_mode);
  ASSERT_EQ(at.theta_rad.size(), 3U);
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(at.theta_rad.data(), 3);
  const auto reached = model.tool.position(true_robot(), q, geometry::Assembly::kLeft).value();
  EXPECT_LT((reached - target_mm).norm(), 0.01);  // what 60 points of 3 um tell
}

}  // namespace
}  // namespace sixdial::studies
