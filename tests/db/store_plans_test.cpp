// Plans, jobs, results and the views of a store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <iostream>
#include <thread>

#include "db/migrations.h"
#include "db/sample_writer.h"
#include "db/sqlite.h"
#include "db/store.h"
#include "tests/db/store_fixture.h"
#include "tests/support/paths.h"

namespace sixdial::db {
namespace {

using session::Session;
using testing::HasSubstr;

class StorePlans : public StoreSamples {};

TEST_F(StorePlans, ComeBackEqualAndTheNewestCounts) {
  EXPECT_FALSE(store_.load_plan(id_).has_value());
  const auto plan = session::plan_random(geometry::default_rig(), 12, {.seed = 3}).value();
  const auto newer = session::plan_random(geometry::default_rig(), 5, {.seed = 4}).value();
  (void)store_.save_plan(id_, plan);
  EXPECT_EQ(store_.load_plan(id_), plan);
  (void)store_.save_plan(id_, newer);
  EXPECT_EQ(store_.load_plan(id_), newer);
  EXPECT_EQ(store_.session_info(id_).planned, 5);
}

TEST_F(StorePlans, KnowWhatIsDoneAndWhatIsNext) {
  const auto plan = session::plan_random(geometry::default_rig(), 4, {.seed = 3}).value();
  (void)store_.save_plan(id_, plan);
  EXPECT_EQ(store_.open_points(id_), plan.points);
  (void)store_.append_sample(id_, sample_at("G1", 0));
  (void)store_.append_sample(id_, sample_at("G1", 2));
  EXPECT_EQ(store_.done_points(id_), (std::vector<PointKey>{{"G1", 0, 0}, {"G1", 2, 0}}));
  EXPECT_EQ(
      store_.open_points(id_),
      (std::vector<session::PlanPoint>{plan.points[1], plan.points[3]}));
  (void)store_.undo_last(id_);
  EXPECT_EQ(store_.open_points(id_).size(), 3U);
}

TEST_F(StorePlans, WithAPointTwiceAreRefused) {
  auto plan = session::plan_random(geometry::default_rig(), 4, {.seed = 3}).value();
  plan.points[3] = plan.points[0];
  EXPECT_EQ(
      refusal_of([&] { (void)store_.save_plan(id_, plan); }).trouble, StoreTrouble::kRefused);
  EXPECT_FALSE(store_.load_plan(id_).has_value());
}

TEST_F(StorePlans, WithATurnOfTheToolAreRefused) {
  // It would come back without its turn, and as another plan.
  auto plan = session::plan_random(geometry::default_rig(), 4, {.seed = 3}).value();
  plan.points[2].target_turn_rad = Eigen::Vector3d(0.1, 0.2, 0.3);
  const StoreError refused = refusal_of([&] { (void)store_.save_plan(id_, plan); });
  EXPECT_EQ(refused.trouble, StoreTrouble::kRefused);
  EXPECT_THAT(refused.what(), HasSubstr("asks for a turn of the tool"));
  EXPECT_FALSE(store_.load_plan(id_).has_value());
}

class StoreJobs : public StoreSamples {};

TEST_F(StoreJobs, GoThroughTheirStatesAndStayFinal) {
  const JobId job = store_.save_job({"calibrate", id_, R"({"seed": 1})", {"ann", 1000, 5}});
  EXPECT_EQ(store_.load_job(job).state, JobState::kQueued);
  store_.update_job(job, {JobState::kRunning, R"({"done": 1, "total": 9})", {}});
  JobRecord record = store_.load_job(job);
  EXPECT_EQ(record.state, JobState::kRunning);
  EXPECT_EQ(record.progress, R"({"done": 1, "total": 9})");
  EXPECT_EQ(record.request, R"({"seed": 1})");
  EXPECT_EQ(record.who.name, "ann");
  EXPECT_TRUE(record.started_utc.has_value());
  EXPECT_FALSE(record.finished_utc.has_value());
  store_.update_job(job, {JobState::kDone, {}, {}});
  EXPECT_TRUE(store_.load_job(job).finished_utc.has_value());
  EXPECT_THAT(
      refusal_of([&] {
        store_.update_job(job, {JobState::kRunning, {}, {}});
      }).what(),
      HasSubstr("is done already"));
  EXPECT_EQ(
      refusal_of([&] { (void)store_.load_job(JobId{99}); }).trouble, StoreTrouble::kNotFound);
}

TEST_F(StoreJobs, LeftByACrashAreFailedAndTheOthersStay) {
  const JobId done = store_.save_job({"a", {}, "{}", {}});
  store_.update_job(done, {JobState::kDone, {}, {}});
  const JobId running = store_.save_job({"b", id_, "{}", {}});
  store_.update_job(running, {JobState::kRunning, {}, {}});
  (void)store_.save_job({"c", id_, "{}", {}});
  EXPECT_EQ(store_.fail_unfinished_jobs("the service stopped"), 2);
  EXPECT_EQ(store_.load_job(done).state, JobState::kDone);
  EXPECT_EQ(store_.load_job(running).error, "the service stopped");
  EXPECT_EQ(store_.list_jobs().size(), 3U);
  EXPECT_EQ(store_.list_jobs(id_).size(), 2U);
}

TEST_F(StoreJobs, ResultsKeepTheirInputs) {
  (void)store_.append_sample(id_, sample_at("G1", 0));
  const JobId job = store_.save_job({"calibrate", id_, "{}", {}});
  constexpr std::uint64_t kLargestSeed = 18446744073709551615ULL;
  const ResultId id = store_.save_result(
      {.session = id_,
       .kind = "calibration",
       .json = R"({"rmse_mm":0.0033})",
       .settings = R"({"profile":"paper"})",
       .seed = kLargestSeed,
       .data_sha256 = "",
       .job = job});
  (void)store_.save_result({.session = id_, .kind = "diagnosis", .json = "{}"});
  const ResultRecord result = store_.load_result(id);
  EXPECT_EQ(result.json, R"({"rmse_mm":0.0033})");
  EXPECT_EQ(result.settings, R"({"profile":"paper"})");
  EXPECT_EQ(result.seed, kLargestSeed);
  EXPECT_EQ(result.program_version, SIXDIAL_VERSION);
  EXPECT_EQ(result.job, job);
  const Session session = store_.load_session(id_);
  EXPECT_EQ(result.data_sha256, session::data_sha256(session));
  EXPECT_EQ(result.rig_sha256, session::rig_sha256(session));
  EXPECT_EQ(store_.load_results(id_).size(), 2U);
  EXPECT_EQ(store_.load_results(id_, "diagnosis").size(), 1U);
  EXPECT_EQ(
      refusal_of([&] {
        (void)store_.save_result({.session = id_, .kind = "calibration", .json = "{\"a\":"});
      }).trouble,
      StoreTrouble::kRefused)
      << "not JSON";
}

TEST_F(StoreJobs, ActionsAreKeptWithWhoDidThem) {
  store_.record_action({"ann", 1000, 42}, "session.create", id_, "s");
  store_.record_action({}, "shutdown");
  const auto actions = store_.list_actions();
  ASSERT_EQ(actions.size(), 2U);
  EXPECT_EQ(actions[0].who.name, "ann");
  EXPECT_EQ(actions[0].who.pid, 42);
  EXPECT_EQ(actions[0].session, id_);
  EXPECT_FALSE(actions[1].session.has_value());
  EXPECT_EQ(store_.list_actions(1)[0].action, "shutdown");
}

class StoreViews : public StoreSamples {};

TEST_F(StoreViews, HaveUnitsInTheirColumnNames) {
  (void)store_.append_sample(id_, sample_at("G1", 0));
  (void)store_.retake_sample(id_, sample_at("G1", 0));
  (void)store_.save_result({.session = id_, .kind = "calibration", .json = "{}"});
  Database raw(file(), Database::Mode::kReadOnly);
  EXPECT_EQ(raw.number("SELECT count(*) FROM v_samples"), 2);
  EXPECT_EQ(raw.number("SELECT count(*) FROM v_samples WHERE is_live"), 1);
  EXPECT_EQ(
      raw.number("SELECT count(theta1_rad + target_x_mm + temperature_c) FROM v_samples"), 2);
  EXPECT_EQ(
      raw.text(
          "SELECT group_concat(dial || displacement_mm, ' ') FROM v_readings WHERE is_live"),
      "A0.0 B1.0 C2.0 D3.0 E4.0 F5.0");
  EXPECT_EQ(raw.text("SELECT session || kind FROM v_results"), "scalibration");
  EXPECT_EQ(raw.number("SELECT samples FROM v_sessions"), 1);
}

}  // namespace
}  // namespace sixdial::db
