// From a calibration to the robot and back: angles that close the inverse problem, commanded
// through real protocol bytes, measured again, and told as in Fig. 7.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "report/documents/calibration_json.h"
#include "report/documents/validation_json.h"
#include "report/words/validation_words.h"
#include "session/bundle.h"
#include "session/rig_file.h"
#include "studies/calibrate.h"
#include "studies/validate.h"
#include "tests/support/job_answers.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

using testing::error_code_of;
using testing::LineClient;
using testing::RunningService;

constexpr double kSpeed = 80.0;  // rig seconds a wall second
// A position from three dials of 0.002 mm noise, their error curves and hysteresis of some um:
// measured distances from the target of about 0.003 mm mean where the robot is perfect.
constexpr double kMeasuring_mm = 0.003;
constexpr double kFewTimes = 3.0;
// The plan file's nine decimals of a radian on 120 mm of arm.
constexpr double kPlanRounding_mm = 2e-7;

const std::filesystem::path kBundle =
    std::filesystem::path(test_paths::test_data()) / "session_00";

CalibrationRequest quick() {
  CalibrationRequest request;
  request.seed = 7;
  request.particles = 20;
  request.qpso1_iterations = 10;
  request.qpso2_iterations = 60;
  request.anfis_epochs = 20;
  return request;
}

const Json& method_of(const Json& document, const std::string& id) {
  for (const Json& method : document["methods"]) {
    if (method["id"] == id) return method;
  }
  throw std::runtime_error("no method " + id);
}

/// The robot of Table 2 with a smooth error of 0.02 mm that kinematics cannot explain.
mock_devices::MockRigOptions warped_rig() {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.world.warp.amplitude_mm = 0.02;
  options.world.seed = 2021;
  options.clock_speed = kSpeed;
  return options;
}

using testing::finished;
using testing::whole_result;

TEST(Validation, OnTheRobotEachStepOfTheMethodBringsTheToolNearerToItsTargets) {
  mock_devices::MockRig mock(warped_rig());
  mock.start();
  service::ServiceOptions options;
  options.clock_speed = kSpeed;
  options.clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()));
  RunningService running({}, options);
  LineClient client = running.client();
  client.call(
      "session.create",
      {{"name", "demo"}, {"rig_toml", session::write_rig(mock.connected_rig("modbus-tcp"))}});
  session::PlanOptions plan_options;
  plan_options.seed = 1;
  session::Plan plan = session::plan_random(geometry::default_rig(), 90, plan_options).value();
  plan_options.set = "G2";
  const session::Plan g2 =
      session::plan_random(geometry::default_rig(), 15, plan_options).value();
  plan.points.insert(plan.points.end(), g2.points.begin(), g2.points.end());
  client.call(
      "collect.start",
      {{"session", "demo"},
       {"plan_csv", session::plan_csv(plan, session::layout_of(geometry::default_rig()))}});
  Json status;
  do {
    status = client.call("collect.wait", {{"timeout_s", 60}})["result"];
  } while (status["state"] == "running" || status["state"] == "starting");
  ASSERT_EQ(status["state"], "done") << status;

  EXPECT_EQ(error_code_of(client.call("validate.start", {{"session", "demo"}})), "not_found");
  const Json calibrated = finished(
      client, client.call("calibrate.start", {{"session", "demo"}, {"seed", 1}})["result"]);
  ASSERT_EQ(calibrated["state"], "done") << calibrated;
  EXPECT_EQ(
      error_code_of(client.call("validate.start", {{"session", "demo"}, {"set", "G7"}})),
      "bad_data");
  EXPECT_EQ(
      error_code_of(client.call("validate.start", {{"session", "demo"}, {"by", {"best"}}})),
      "invalid_params");
  const Json validated =
      finished(client, client.call("validate.start", {{"session", "demo"}})["result"]);
  ASSERT_EQ(validated["state"], "done") << validated;
  const Json document = whole_result(client, validated["result"]);

  EXPECT_EQ(document["schema"], "sixdial.validation");
  EXPECT_EQ(document["inputs"]["calibration_result"], calibrated["result"]);
  const auto mean = [&](const char* id) {
    return method_of(document, id)["errors"]["mean_mm"].get<double>();
  };
  for (const char* id : {"before", "kinematics", "full"}) {
    EXPECT_EQ(method_of(document, id)["errors"]["points"], 15) << id;
    EXPECT_EQ(method_of(document, id)["without_position"], 0) << id;
  }
  EXPECT_GT(mean("before"), 2.0);
  EXPECT_LT(mean("kinematics"), 0.03);  // the warp stays
  EXPECT_GT(mean("kinematics"), 1.2 * mean("full"));
  EXPECT_LT(mean("full"), kFewTimes * kMeasuring_mm);

  // A session as any other, with the raw readings, linked to the calibrated one.
  db::Store& reader = running.service().reader();
  const db::SessionId id =
      reader.find_session(document["inputs"]["validation_session"].get<std::string>());
  EXPECT_EQ(reader.load_session(id).samples.size(), 45U);
  EXPECT_THAT(reader.session_info(id).note, ::testing::HasSubstr("session demo"));
  EXPECT_THAT(
      report::validation_text(report::validation_from_json(document)),
      ::testing::HasSubstr("after kinematics + ANFIS"));
}

TEST(Validation, EachWayHasAPassOfItsOwnWithStatedSidesOfArrival) {
  const session::Session session = session::read_bundle(kBundle);
  const CalibrationResult calibration = calibrate(session, quick());
  ValidationRequest request;
  request.by = {CompensateBy::kBefore, CompensateBy::kFull};
  const session::Plan plan = validation_plan(session, calibration, request);
  ASSERT_EQ(plan.points.size(), 100U);
  // A short move from another way's angles would make the backlash that of this move.
  for (std::size_t i = 0; i < 50; ++i) {
    const session::PlanPoint& before = plan.points[i];
    const session::PlanPoint& full = plan.points[i + 50];
    EXPECT_EQ(before.set, "G2.before");
    EXPECT_EQ(full.set, "G2.full");
    EXPECT_EQ(before.target_mm, full.target_mm);
    EXPECT_EQ(before.point, full.point);
    EXPECT_GT((before.q - full.q).norm(), 1e-3);
    EXPECT_EQ(before.approach, full.approach);
    for (std::size_t joint = 0; joint < 2; ++joint) {
      const auto sample = std::ranges::find_if(session.samples, [&](const auto& each) {
        return each.set == "G2" && each.point == before.point;
      });
      const int side = session::approach_of(*sample, joint).value_or(0);
      EXPECT_EQ(session::approach_of(before, joint), side == 0 ? 1 : side);
    }
  }
  request.set = "G9";
  EXPECT_THROW((void)validation_plan(session, calibration, request), StudyError);
}

TEST(Compensation, AStoredResultAnswersAsTheNumbersItWasMadeFrom) {
  const session::Session session = session::read_bundle(kBundle);
  const CalibrationResult calibration = report::calibration_from_json(
      Json::parse(report::to_json(calibrate(session, quick())).dump()));
  const auto full = compensation_model(calibration, session.rig, CompensateBy::kFull);
  const auto kinematics =
      compensation_model(calibration, session.rig, CompensateBy::kKinematics);
  const auto before = compensation_model(calibration, session.rig, CompensateBy::kBefore);
  EXPECT_EQ(before.v, session.rig.robot.nominal);
  EXPECT_NE(kinematics.v, before.v);
  // The residuals of the document, by kinematics and by the full model, differ by what the
  // networks say.
  const auto column = [&](const char* id) {
    return static_cast<std::size_t>(calibration.method(id) - calibration.methods.data());
  };
  for (const PointResiduals& point : calibration.points) {
    const session::Sample& sample = session.samples[static_cast<std::size_t>(point.sample)];
    const Eigen::Vector2d learned = point.residual_mm.at(column("ekf_dqpso")).value() -
                                    point.residual_mm.at(column("ekf_dqpso+anfis")).value();
    EXPECT_LT((full.correction(sample.q) - learned).norm(), 1e-12);
  }
  EXPECT_THROW((void)report::calibration_from_json({{"schema", "other"}}), StudyError);
}

TEST(Compensation, APlanKeepsItsPointsAndClosesAtEachTarget) {
  const session::Session session = session::read_bundle(kBundle);
  const auto model =
      compensation_model(calibrate(session, quick()), session.rig, CompensateBy::kKinematics);
  const session::Plan plan = session::plan_grid(session.rig, 7, 9).value();
  const session::Plan written = session::parse_plan(
      session::plan_csv(
          compensated_plan(plan, model, session.rig), session::layout_of(session.rig)),
      "plan", session.rig);
  ASSERT_EQ(written.points.size(), plan.points.size());
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    EXPECT_EQ(written.points[i].target_mm, plan.points[i].target_mm);
    const auto pose =
        geometry::forward(model.v, written.points[i].q, session.rig.robot.assembly);
    ASSERT_TRUE(pose);
    EXPECT_LT((pose->p_WE - plan.points[i].target_mm).norm(), kPlanRounding_mm);
  }
  session::Plan beyond = plan;
  beyond.points[3].target_mm = Eigen::Vector2d(400, 0);
  try {
    static_cast<void>(compensated_plan(beyond, model, session.rig));
    ADD_FAILURE() << "a target out of reach was accepted";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kBadData);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("400.000"));
  }
}

}  // namespace
}  // namespace sixdial::studies
