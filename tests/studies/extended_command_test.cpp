// Commanding with the extended model of a diagnosis: angles that close with robot and causes
// together, and on a robot with a hidden effect nearer to the target than the paper's method.
#include "studies/extended_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "session/bundle.h"
#include "session/rig_file.h"
#include "session/trials.h"
#include "studies/diagnose.h"
#include "studies/validate.h"
#include "tests/support/job_answers.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using testing::error_code_of;
using testing::LineClient;
using testing::RunningService;

constexpr double kSpeed = 80.0;  // rig seconds a wall second
// Where compensate() stops.
constexpr double kClosure_mm = 1e-8;

DiagnosisResult diagnosis_of(const std::string& number) {
  DiagnosisRequest request;
  request.bootstrap = 0;
  request.with_gain = false;
  const auto folder = std::filesystem::path(test_paths::test_data()) / "sessions" / number;
  return diagnose(session::read_bundle(folder), request);
}

TEST(ExtendedCommand, ClosesAtTheTargetWithRobotAndCausesTogether) {
  const geometry::Rig rig = geometry::default_rig();
  const ExtendedCommand command(diagnosis_of("06").extended_fit, rig);
  int tried = 0;
  for (double x_mm = 17; x_mm < 40; x_mm += 4) {
    for (double y_mm = 31; y_mm < 66; y_mm += 5) {
      const Eigen::Vector2d target_mm(x_mm, y_mm);
      const auto found = command.solve(target_mm, rig.robot.working_mode, {});
      ASSERT_TRUE(found) << found.error().message;
      const auto assembly =
          geometry::assembly_at(rig.robot.nominal, found->nominal_q, target_mm);
      const auto there = command.position(found->q, *assembly, {});
      ASSERT_TRUE(there);
      EXPECT_LT((*there - target_mm).norm(), kClosure_mm);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 42);
}

TEST(ExtendedCommand, ABacklashIsTakenUpOnTheSideOfArrival) {
  const geometry::Rig rig = geometry::default_rig();
  const DiagnosisResult diagnosis = diagnosis_of("01");
  const ExtendedCommand command(diagnosis.extended_fit, rig);
  const Eigen::Vector2d target_mm(28, 48);
  const auto up = command.solve(target_mm, rig.robot.working_mode, {.approach = {1, 1}});
  const auto down = command.solve(target_mm, rig.robot.working_mode, {.approach = {1, -1}});
  ASSERT_TRUE(up && down);
  const double backlash_rad = diagnosis.causes[0].estimate[0].value;
  EXPECT_LT(std::abs((up->q[1] - down->q[1]) - backlash_rad), 1e-9);  // rad: of the closure
  EXPECT_LT(std::abs(up->q[0] - down->q[0]), 1e-9);
}

TEST(ExtendedCommand, APlansAnglesAreSolvedForTheMovesThatThePlanMakes) {
  const geometry::Rig rig = geometry::default_rig();
  const ExtendedCommand command(diagnosis_of("01").extended_fit, rig);
  session::PlanOptions options;
  options.seed = 3;
  const session::Plan plan =
      extended_plan(session::plan_random(rig, 40, options).value(), command, rig);
  int up = 0;
  for (std::size_t i = 1; i < plan.points.size(); ++i) {
    const session::PlanPoint& point = plan.points[i];
    const Eigen::Vector2d way = point.q - plan.points[i - 1].q;
    const CommandMoment moment{.approach = {way[0] > 0 ? 1 : -1, way[1] > 0 ? 1 : -1}};
    up += way[1] > 0 ? 1 : 0;
    const auto assembly = geometry::assembly_at(rig.robot.nominal, point.q, point.target_mm);
    const auto there = command.position(point.q, *assembly, moment);
    ASSERT_TRUE(there);
    EXPECT_LT((*there - point.target_mm).norm(), kClosure_mm) << i;
  }
  EXPECT_GT(up, 10);
  EXPECT_LT(up, 30);
  session::Plan beyond = plan;
  beyond.points[3].target_mm = Eigen::Vector2d(400, 0);
  EXPECT_THROW(static_cast<void>(extended_plan(beyond, command, rig)), StudyError);
}

/// A backlash and a smooth error that no cause explains, 100 points of G1 and 50 of G2.
session::Session with_backlash_and_warp() {
  mock_devices::World world = testing::simple_world(2021);
  world.warp.amplitude_mm = 0.02;
  world.effects = {mock_devices::parse_effect(world.rig, "joint_backlash:joint2:0.0006", 1)};
  session::PlanOptions options;
  options.seed = 1;
  session::Plan plan = session::plan_random(world.rig, 100, options).value();
  options.set = "G2";
  options.seed = 2;
  const session::Plan g2 = session::plan_random(world.rig, 50, options).value();
  plan.points.insert(plan.points.end(), g2.points.begin(), g2.points.end());
  return testing::measured(world, plan);
}

/// Mean distance of the model's position from the measured one on G2.
double missed_on_g2_mm(const session::Session& session, const ExtendedCommand& command) {
  double sum_mm = 0.0;
  int count = 0;
  for (const simulation::Trial& trial : session::trials_of(session, "G2")) {
    if (!trial.position_mm) continue;
    const auto there = command.position(
        trial.q, trial.assembly, {.approach = {trial.approach.begin(), trial.approach.end()}});
    if (!there) continue;
    sum_mm += (*there - *trial.position_mm).norm();
    ++count;
  }
  return sum_mm / count;
}

TEST(ExtendedCommand, BesideSomethingNamelessItDoesAsWellAsItsGainSays) {
  const session::Session session = with_backlash_and_warp();
  const DiagnosisResult diagnosis = diagnose(session, {.bootstrap = 0});
  ASSERT_TRUE(diagnosis.unexplained.significant);
  // Positions of three dials are noisier than the shift of the tool that all six tell.
  constexpr double kPositionNoise_mm = 0.004;
  for (const bool full : {false, true}) {
    const GainRow* row = gain_row(diagnosis, diagnosis::GainModel::kExtended, full);
    ASSERT_NE(row, nullptr);
    const ExtendedCommand command(
        diagnosis.extended_fit, session.rig,
        full ? CompensateBy::kExtendedFull : CompensateBy::kExtended);
    EXPECT_LT(missed_on_g2_mm(session, command), row->mean_mm + kPositionNoise_mm) << full;
  }
  EXPECT_LT(
      gain_row(diagnosis, diagnosis::GainModel::kExtended, true)->mean_mm,
      0.5 * gain_row(diagnosis, diagnosis::GainModel::kExtended)->mean_mm);
}

TEST(ExtendedCommand, WithoutAResidualModelItSaysWhatToDo) {
  ExtendedFit fit = diagnosis_of("01").extended_fit;
  ASSERT_FALSE(fit.residual_model.has_value());  // diagnosed without the gain
  try {
    const ExtendedCommand command(fit, geometry::default_rig(), CompensateBy::kExtendedFull);
    ADD_FAILURE() << "commanded by a residual model that is not there";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kBadData);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("residual model"));
  }
}

TEST(ExtendedCommand, ADiagnosisOfAnotherRigIsRefused) {
  const geometry::Rig rig = geometry::default_rig();
  ExtendedFit fit = diagnosis_of("01").extended_fit;
  fit.effects[0].id.where = "joint7";
  EXPECT_THROW(ExtendedCommand(fit, rig), StudyError);
  fit.effects.clear();
  fit.model.pop_back();
  EXPECT_THROW(ExtendedCommand(fit, rig), StudyError);
}

using testing::finished;
using testing::whole_result;

struct Hidden {
  const char* effect;  // of the mock rig
  const char* named;   // as the diagnosis must say
  double least_gain;   // error by the paper's method over that by the extended model
};
struct CommandedRobot : ::testing::TestWithParam<Hidden> {};

mock_devices::MockRigOptions rig_with(const char* effect) {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.world.dials.curve_mm = 0.0;
  options.world.dials.hysteresis_mm = 0.0;
  options.world.seed = 2021;
  options.world.effects = {mock_devices::parse_effect(options.world.rig, effect, 1)};
  options.clock_speed = kSpeed;
  return options;
}

/// A five-bar has two joints: a side of its fifth is a mistake.
void expect_sides_of_its_joints_only(LineClient& client) {
  const Json target{{"session", "demo"}, {"x_mm", 28.0}, {"y_mm", 48.0}, {"approach5", 1}};
  EXPECT_EQ(error_code_of(client.call("compensate.target", target)), "invalid_params");
}

/// 60 points of G1, 15 of G2.
session::Plan plan_of_both_sets() {
  session::PlanOptions options;
  options.seed = 1;
  session::Plan plan = session::plan_random(geometry::default_rig(), 60, options).value();
  options.set = "G2";
  const session::Plan g2 = session::plan_random(geometry::default_rig(), 15, options).value();
  plan.points.insert(plan.points.end(), g2.points.begin(), g2.points.end());
  return plan;
}

TEST_P(CommandedRobot, ReachesByItsDiagnosisWhatThePapersMethodDoesNot) {
  mock_devices::MockRig mock(rig_with(GetParam().effect));
  mock.start();
  service::ServiceOptions options;
  options.clock_speed = kSpeed;
  options.clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()));
  RunningService running({}, options);
  LineClient client = running.client();
  client.call(
      "session.create",
      {{"name", "demo"}, {"rig_toml", session::write_rig(mock.connected_rig("modbus-tcp"))}});
  client.call(
      "collect.start",
      {{"session", "demo"},
       {"plan_csv",
        session::plan_csv(plan_of_both_sets(), session::layout_of(geometry::default_rig()))}});
  Json status;
  do {
    status = client.call("collect.wait", {{"timeout_s", 60}})["result"];
  } while (status["state"] == "running" || status["state"] == "starting");
  ASSERT_EQ(status["state"], "done") << status;

  ASSERT_EQ(
      finished(
          client, client.call("calibrate.start", {{"session", "demo"}})["result"])["state"],
      "done");
  const Json ways{{"session", "demo"}, {"by", {"kinematics", "full", "extended"}}};
  EXPECT_EQ(error_code_of(client.call("validate.start", ways)), "not_found");
  EXPECT_EQ(
      error_code_of(client.call(
          "compensate.target",
          {{"session", "demo"}, {"x_mm", 28.0}, {"y_mm", 48.0}, {"by", "extended"}})),
      "not_found");
  const Json diagnosed = finished(
      client, client.call("diagnose.start", {{"session", "demo"}, {"bootstrap", 0}})["result"]);
  ASSERT_EQ(diagnosed["state"], "done") << diagnosed;
  const Json verdict = whole_result(client, diagnosed["result"]);
  // The first sample has no last move: its readings may stand out.
  const auto name_of = [](const Json& id) {
    return id.value("cause", "") + "@" + id.value("where", "");
  };
  int names = 0;
  std::vector<std::string> named_or_tied;
  for (const Json& cause : verdict["causes"]) {
    if (cause["where"] == "samples") continue;
    ++names;
    named_or_tied.push_back(name_of(cause));
    for (const Json& rival : cause["tied_with"]) named_or_tied.push_back(name_of(rival));
  }
  // The noise is drawn by the machine's timing: of a hundred such sessions two give a set that
  // holds the name, as eccentricity and second harmonic over half a radian are alike.
  ASSERT_THAT(named_or_tied, ::testing::Contains(std::string(GetParam().named))) << verdict;
  ASSERT_LE(names, 2);

  const Json target = client.call(
      "compensate.target", {{"session", "demo"},
                            {"x_mm", 28.0},
                            {"y_mm", 48.0},
                            {"by", "extended"},
                            {"approach2", 1}})["result"];
  EXPECT_LT(target["closure_mm"], kClosure_mm);
  EXPECT_EQ(target["result"], diagnosed["result"]);
  expect_sides_of_its_joints_only(client);

  const Json validated = finished(client, client.call("validate.start", ways)["result"]);
  ASSERT_EQ(validated["state"], "done") << validated;
  const Json document = whole_result(client, validated["result"]);
  EXPECT_EQ(document["inputs"]["diagnosis_result"], diagnosed["result"]);
  std::map<std::string, double> mean_mm;
  for (const Json& method : document["methods"]) {
    EXPECT_EQ(method["errors"]["points"], 15);
    mean_mm[method["id"]] = method["errors"]["mean_mm"];
  }
  EXPECT_GT(mean_mm["full"], GetParam().least_gain * mean_mm["extended"]);
  // A position from three dials of 0.002 mm noise.
  EXPECT_LT(mean_mm["extended"], 0.005);
  RecordProperty("kinematics_mm", std::to_string(mean_mm["kinematics"]));
  RecordProperty("full_mm", std::to_string(mean_mm["full"]));
  RecordProperty("extended_mm", std::to_string(mean_mm["extended"]));
}

// The side that a joint arrives from is no function of the angles: no network has it. An
// eccentricity is one, and ANFIS learns most of it; naming it must do about as well.
INSTANTIATE_TEST_SUITE_P(
    , CommandedRobot,
    ::testing::Values(
        Hidden{"joint_backlash:joint2:0.001", "joint_backlash@joint2", 2.5},
        Hidden{"joint_eccentricity:joint2:0.01", "joint_eccentricity@joint2", 0.7}));

}  // namespace
}  // namespace sixdial::studies
