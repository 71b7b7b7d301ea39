// Poses that calibrate an arm by a ball in sockets: the ball is there, the stem keeps its cone,
// the same request gives the same plan, and what the plan promises is what drawn sessions at
// these poses come to.
#include "studies/socket_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "calibration/reading_space.h"
#include "calibration/space_fit.h"
#include "geometry/tool.h"
#include "report/documents/plan_json.h"
#include "report/words/plan_words.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "studies/error.h"
#include "studies/own_frame.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;
using ::testing::Not;

// A billionth of a radian in each of six joints, at the end of an arm of 700 mm.
constexpr double kRounding_mm = 1e-6;
constexpr double kSeat_mm = 0.1;

std::string arm_text() {
  return session::read_file(test_paths::source_dir() + "/examples/sockets/arm.toml");
}
geometry::Rig arm() { return session::parse_rig(arm_text(), "arm.toml"); }

SocketPlanRequest request() {
  return {
      .at_mm = {Vector3d(260, -90, 40), Vector3d(260, 90, 140)},
      .count = 16,
      .to_judge = 3,
      .distance_mm = 206.0,
      .seat_sd_mm = kSeat_mm};
}

/// The trials of such points, the ball in its socket.
std::vector<simulation::Trial> trials_of(
    const geometry::Rig& rig, const session::Plan& plan, const std::string& set) {
  std::vector<simulation::Trial> trials;
  for (const session::PlanPoint& point : plan.points) {
    if (point.set != set) continue;
    simulation::Trial& trial = trials.emplace_back();
    trial.sample = trial.point = static_cast<int>(trials.size()) - 1;
    trial.q = point.q;
    trial.reading.resize(3 * rig.instrument.sockets.size());
    for (std::size_t k = 0; k < rig.instrument.sockets.size(); ++k) {
      if (rig.instrument.sockets[k].name != point.socket) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) trial.reading[3 * k + axis] = 0.0;
    }
  }
  return trials;
}

calibration::SpaceFit fitted(
    const calibration::ObservationSpace& space, const geometry::Rig& rig) {
  calibration::SpaceFitSettings settings;
  settings.weighting = calibration::Weighting::kBySigma;
  settings.noise_mm = kSeat_mm;
  settings.fixed.assign(static_cast<std::size_t>(space.parameters()), 0);
  hold_where_it_stands(rig, settings.fixed);
  return calibration::fit_space(space, settings);
}

/// Poses all over the joints' ranges.
std::vector<VectorXd> everywhere(const geometry::Rig& rig, int count) {
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<VectorXd> poses;
  for (int i = 0; i < count; ++i) {
    VectorXd& q = poses.emplace_back(rig.robot.model->joint_count());
    for (Index k = 0; k < q.size(); ++k) {
      const auto& joint = rig.robot.model->joints[static_cast<std::size_t>(k)];
      q[k] = joint.low + share(engine) * (joint.high - joint.low);
    }
  }
  return poses;
}

TEST(SocketPlan, PutsTheBallIntoItsSocketWithinConeAndRanges) {
  const SocketPlan made = socket_plan(arm(), request());
  const session::Plan plan =
      session::parse_plan(session::plan_csv(made.plan, made.rig), "plan.csv", made.rig);
  EXPECT_EQ(plan, made.plan);
  ASSERT_EQ(plan.points.size(), 2U * (16 + 3));
  const geometry::Tool tool(made.rig);
  std::vector<geometry::Pose<double>> X(made.rig.robot.model->frames.size());
  int in_second = 0;
  for (const session::PlanPoint& point : plan.points) {
    const bool second = point.socket == "S2";
    in_second += second ? 1 : 0;
    const Vector3d at = request().at_mm[second ? 1 : 0];
    ASSERT_TRUE(made.rig.robot.model->forward(
        made.rig.robot.nominal, point.q, made.rig.robot.assembly, X));
    EXPECT_LT((X[0].p - at).norm(), kRounding_mm);
    const double lean = session::lean_of(request().seat, X[0].R);
    EXPECT_LE(lean, 45.0 * geometry::kRadPerDeg);
    for (Index k = 0; k < point.q.size(); ++k) {
      const auto& joint = made.rig.robot.model->joints[static_cast<std::size_t>(k)];
      EXPECT_GE(point.q[k], joint.low);
      EXPECT_LE(point.q[k], joint.high);
    }
  }
  EXPECT_EQ(in_second, 16 + 3);
  EXPECT_LE(made.figures.sockets[0].most_lean_rad, 45.0 * geometry::kRadPerDeg);
}

TEST(SocketPlan, ANarrowConeAndAnotherAxisAreKept) {
  SocketPlanRequest asked = request();
  asked.count = 4;
  asked.seat.cone_rad = 20.0 * geometry::kRadPerDeg;
  asked.seat.axis = Vector3d(-1, 0, 1);  // sockets in a slope towards the arm
  const SocketPlan made = socket_plan(arm(), asked);
  std::vector<geometry::Pose<double>> X(made.rig.robot.model->frames.size());
  for (const session::PlanPoint& point : made.plan.points) {
    ASSERT_TRUE(made.rig.robot.model->forward(
        made.rig.robot.nominal, point.q, made.rig.robot.assembly, X));
    const Vector3d stem = X[0].R.col(2);
    const double cosine = -stem.dot(asked.seat.axis.normalized());
    EXPECT_GE(cosine, std::cos(asked.seat.cone_rad) - 1e-12);
  }
}

TEST(SocketPlan, IsTheSameForTheSameSeedAndAnotherForAnother) {
  SocketPlanRequest asked = request();
  asked.count = 5;
  const SocketPlan once = socket_plan(arm(), asked);
  const SocketPlan again = socket_plan(arm(), asked);
  EXPECT_EQ(once.plan, again.plan);
  EXPECT_EQ(report::to_json(once.figures), report::to_json(again.figures));
  asked.seed = 2;
  EXPECT_NE(socket_plan(arm(), asked).plan, once.plan);
}

/// The plan's promise against sessions at its poses: robots that are off, balls that come back
/// to within the seat's deviation, calibrated from the nominal robot on.
TEST(SocketPlan, PromisesWhatDrawnSessionsComeTo) {
  const SocketPlan made = socket_plan(arm(), request());
  const geometry::Rig& rig = made.rig;
  const geometry::Tool tool(rig);
  const auto& parameters = rig.robot.model->parameters;
  const std::vector<VectorXd> places = everywhere(rig, 150);
  std::vector<double> squares(places.size(), 0.0);
  Eigen::Matrix3Xd is(3, std::ssize(places));
  Eigen::Matrix3Xd said(3, std::ssize(places));
  VectorXd scaled = VectorXd::Zero(std::ssize(made.figures.parameters));
  std::mt19937_64 engine(21);
  std::normal_distribution<double> normal;
  constexpr int kSessions = 120;
  for (int session = 0; session < kSessions; ++session) {
    VectorXd truth = rig.robot.nominal;
    for (Index i = 0; i < truth.size(); ++i) {
      const auto& info = parameters[static_cast<std::size_t>(i)];
      if (!info.stands) truth[i] += 0.3 * info.change * normal(engine);
    }
    const Vector3d first(261, -88, 38);
    const Vector3d way = Vector3d(0, 180, 100).normalized();
    const std::vector<Vector3d> sockets{first, first + (206.0 + 0.05 * normal(engine)) * way};
    auto trials = trials_of(rig, made.plan, "G1");
    for (simulation::Trial& trial : trials) {
      Vector3d ball = sockets[trial.reading[0] ? 0 : 1];
      for (double& each : ball) each += kSeat_mm * normal(engine);
      const auto q = tool.inverse(truth, ball, rig.robot.working_mode, trial.q);
      ASSERT_TRUE(q);
      trial.q = *q;
    }
    const auto space = calibration::reading_space(trials, rig);
    const calibration::SpaceFit fit = fitted(space, rig);
    ASSERT_EQ(fit.fit.status, calibration::FitStatus::kConverged);
    ASSERT_EQ(fit.fit.held, 0);
    const VectorXd found = fit.v.head(truth.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto k = static_cast<Index>(i);
      is.col(k) = *tool.position(truth, places[i], rig.robot.assembly);
      said.col(k) = *tool.position(found, places[i], rig.robot.assembly);
    }
    // The arm is registered where it works.
    const Eigen::Matrix4d X = Eigen::umeyama(said, is, false);
    const Eigen::Matrix3Xd left =
        ((X.topLeftCorner<3, 3>() * said).colwise() + X.topRightCorner<3, 1>()) - is;
    for (std::size_t i = 0; i < places.size(); ++i) {
      squares[i] += left.col(static_cast<Index>(i)).squaredNorm() / kSessions;
    }
    for (std::size_t k = 0; k < made.figures.parameters.size(); ++k) {
      const PlannedParameter& each = made.figures.parameters[k];
      const int i = *rig.robot.model->find_parameter(each.name);
      scaled[static_cast<Index>(k)] += std::pow((found[i] - truth[i]) / each.sd, 2) / kSessions;
    }
  }
  double mean_mm = 0.0;
  for (const double each : squares) {
    mean_mm += std::sqrt(each) / static_cast<double>(squares.size());
  }
  ASSERT_EQ(made.figures.stages.size(), 3U);
  const SocketStage& promised = made.figures.stages[1];
  ASSERT_EQ(promised.poses, 16);
  // 120 sessions know a standard deviation to 7 %; a robot that is off bends the rest.
  constexpr double kOfPromise = 0.15;
  EXPECT_NEAR(mean_mm, promised.position.mean_mm, kOfPromise * promised.position.mean_mm);
  EXPECT_NEAR(std::sqrt(scaled.mean()), 1.0, kOfPromise);
}

TEST(SocketPlan, MorePosesTellMoreAndChosenOnesMoreThanDrawnOnes) {
  SocketPlanRequest asked = request();
  asked.to_judge = asked.count;  // drawn, not chosen
  const SocketPlan made = socket_plan(arm(), asked);
  ASSERT_EQ(made.figures.stages.size(), 3U);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_LT(
        made.figures.stages[i].position.mean_mm, made.figures.stages[i - 1].position.mean_mm);
  }
  EXPECT_EQ(made.figures.stages[0].poses, 8);
  EXPECT_EQ(made.figures.stages[2].poses, 32);
  const auto worth = [&](const std::string& set) {
    const auto space =
        calibration::reading_space(trials_of(made.rig, made.plan, set), made.rig);
    const auto fit = fitted(space, made.rig).fit;
    constexpr double kUntold = 0.5 * kSeat_mm;  // what is held is no better known than that
    double sum = 0.0;
    for (Index k = 0; k < fit.free; ++k) {
      sum += std::log(std::max(fit.singular_values[k], kUntold));
    }
    return sum;  // log volume of what is known
  };
  EXPECT_GT(worth("G1"), worth("G2") + 3.0);
}

TEST(SocketPlan, SaysThatTheScaleIsOpenWithoutADistance) {
  SocketPlanRequest asked = request();
  asked.to_judge = 0;
  asked.distance_mm.reset();
  const SocketPlan open = socket_plan(arm(), asked);
  EXPECT_TRUE(open.figures.scale_is_open);
  ASSERT_EQ(open.figures.stages[1].open.size(), 1U);
  const std::string text = report::socket_plan_text(open.figures);
  EXPECT_THAT(text, HasSubstr("scale stays open"));
  EXPECT_THAT(text, HasSubstr("--distance"));
  // The direction that is open makes the arm larger in all its lengths.
  const auto a2 = std::ranges::find(open.figures.parameters, "a2", &PlannedParameter::name);
  ASSERT_NE(a2, open.figures.parameters.end());
  EXPECT_TRUE(a2->open);

  asked.distance_mm = 206.0;
  const SocketPlan closed = socket_plan(arm(), asked);
  EXPECT_FALSE(closed.figures.scale_is_open);
  EXPECT_TRUE(closed.figures.stages[1].open.empty());
  const std::string known = report::socket_plan_text(closed.figures);
  EXPECT_THAT(known, Not(HasSubstr("scale stays open")));
  EXPECT_THAT(known, HasSubstr("S1 to S2: 206.000 mm"));
  EXPECT_EQ(
      report::socket_plan_text(report::socket_plan_from_json(report::to_json(closed.figures))),
      known);
}

TEST(SocketPlan, TakesNamesAndDistancesOfTheRigFile) {
  const geometry::Rig rig = session::parse_rig(
      arm_text() +
          "[instrument]\nkind = \"socket\"\nsd_mm = 0.3\n[[socket]]\nname = \"left\"\n"
          "[[socket]]\nname = \"right\"\ndistance_mm = { left = 206.0 }\n"
          "distance_sd_mm = 0.02\n",
      "arm.toml");
  SocketPlanRequest asked = request();
  asked.count = 4;
  asked.distance_mm.reset();
  asked.seat_sd_mm.reset();
  const SocketPlan made = socket_plan(rig, asked);
  EXPECT_EQ(made.figures.sockets[1].name, "right");
  ASSERT_EQ(made.figures.distances.size(), 1U);
  EXPECT_EQ(made.figures.distances[0].sd_mm, 0.02);
  EXPECT_EQ(made.figures.seat_sd_mm, 0.3);
  EXPECT_FALSE(made.figures.seat_sd_assumed);
  EXPECT_FALSE(made.figures.scale_is_open);
}

/// What it refuses, with a word that says why.
TEST(SocketPlan, RefusesInWords) {
  struct Refused {
    std::string arm;
    SocketPlanRequest request;
    std::string words;
  };
  SocketPlanRequest one = request();
  one.at_mm.resize(1);
  SocketPlanRequest far = request();
  far.at_mm[1] = Vector3d(1500, 0, 0);
  SocketPlanRequest high = request();
  high.at_mm = {Vector3d(100, -90, 700), Vector3d(100, 90, 700)};  // only from below
  SocketPlanRequest same = request();
  same.at_mm[1] = same.at_mm[0];
  SocketPlanRequest wide = request();
  wide.seat.cone_rad = 3.0;
  SocketPlanRequest still = request();
  still.seat.stem = Vector3d::Zero();
  std::string no_ranges = arm_text();
  no_ranges.erase(no_ranges.find("low_deg"), 16);
  const std::vector<Refused> all{
      {arm_text(), one, "one socket is too few"},
      {arm_text(), {}, "no socket's place"},
      {arm_text(), far, "socket S2 at (1500.0, 0.0, 0.0) mm: the robot does not reach it"},
      {arm_text(), high, "leans by at most 45 deg"},
      {arm_text(), same, "the same place"},
      {arm_text(), wide, "cannot come into a socket"},
      {arm_text(), still, "direction of length 0"},
      {no_ranges, request(), "how far every joint may go"}};
  for (const Refused& each : all) {
    try {
      static_cast<void>(socket_plan(session::parse_rig(each.arm, "arm.toml"), each.request));
      ADD_FAILURE() << each.words << ": planned";
    } catch (const StudyError& error) {
      EXPECT_THAT(error.what(), HasSubstr(each.words));
      EXPECT_FALSE(error.hint().empty()) << each.words;
    }
  }
}

TEST(SocketPlan, OfARobotThatIsNoArmIsRefused) {
  geometry::Rig delta;
  delta.robot.model = geometry::find_robot_kind("linear_delta")->example();
  delta.robot.nominal = delta.robot.model->nominal;
  EXPECT_THROW(static_cast<void>(socket_plan(delta, request())), StudyError);
  EXPECT_THROW(static_cast<void>(socket_plan(geometry::default_rig(), request())), StudyError);
}

}  // namespace
}  // namespace sixdial::studies
