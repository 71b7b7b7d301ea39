#include "db/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <iostream>
#include <thread>

#include "db/migrations.h"
#include "db/sample_writer.h"
#include "db/sqlite.h"
#include "tests/db/store_fixture.h"
#include "tests/support/paths.h"

namespace sixdial::db {
namespace {

using session::Session;
using testing::HasSubstr;

const std::string kHeader = "set,point,theta1_rad,theta2_rad,dial_B_mm,note";

Session odd_bundle() {
  const std::string csv = "\xEF\xBB\xBF" + kHeader +
                          "\r\nG1,0,1.509623367,3.069803861,25.194,\"a, \"\"b\"\"\"\r\n" +
                          "G1,1,oops,3.069803861,25.194,\r\nG2,0,1.5096,3.0698,,\xC3\xA9";
  return session::parse_session(
      csv, "session.csv", rig_text() + "# a comment\r\n", "rig.toml",
      {.skip_bad_rows = true, .name = "odd"});
}

class StoreSessions : public StoreTest {};

TEST_F(StoreSessions, GiveBackTheBytesOfEveryImportedBundle) {
  Store store = Store::open(file());
  for (const char* name : {"00", "01", "12"}) {
    const std::string folder = test_paths::test_data() + "/sessions/" + name;
    const Session in = session::read_bundle(folder);
    const SessionId id = store.import_session(in);
    const Session out = store.load_session(id);
    EXPECT_EQ(session::session_csv(out), session::read_file(folder + "/session.csv"));
    EXPECT_EQ(session::rig_toml(out), session::read_file(folder + "/rig.toml"));
    ASSERT_EQ(out.samples.size(), in.samples.size());
    for (std::size_t i = 0; i < in.samples.size(); ++i) {
      expect_equal(out.samples[i], in.samples[i]);
    }
  }
  EXPECT_TRUE(store.check().empty());
}

TEST_F(StoreSessions, GiveBackOddBytesAndRejectedRowsAfterReopening) {
  const Session in = odd_bundle();
  ASSERT_EQ(in.rejected.size(), 1U);
  { (void)Store::open(file()).import_session(in); }
  Store store = Store::open(file());
  const Session out = store.load_session(store.find_session("odd"));
  EXPECT_EQ(session::session_csv(out), session::session_csv(in));
  EXPECT_EQ(out.rig_text, in.rig_text);
  ASSERT_EQ(out.rejected.size(), 1U);
  EXPECT_EQ(out.rejected[0].line, 3);
  EXPECT_EQ(out.rejected[0].text, in.rejected[0].text);
  EXPECT_EQ(out.rejected[0].reason, in.rejected[0].reason);
}

TEST_F(StoreSessions, AreListedAndFoundByNameAndNumber) {
  Store store = Store::open(file());
  const SessionId first =
      store.create_session("press 4", rig_text(), {"ann", 1000, 77}, "note");
  const SessionId second = store.create_session("2", rig_text());
  store.append_sample(first, sample_at("G1", 0));
  store.append_sample(first, sample_at("G1", 1));
  store.append_sample(first, sample_at("G2", 0));
  EXPECT_EQ(store.find_session("press 4"), first);
  EXPECT_EQ(store.find_session("2"), second) << "a name goes before a number";
  EXPECT_EQ(store.find_session("1"), first);
  const auto error = refusal_of([&] { (void)store.find_session("pres 4"); });
  EXPECT_EQ(error.trouble, StoreTrouble::kNotFound);
  EXPECT_THAT(error.what(), HasSubstr("the nearest name is 'press 4'"));

  const auto sessions = store.list_sessions();
  ASSERT_EQ(sessions.size(), 2U);
  const SessionInfo& info = sessions[0];
  EXPECT_EQ(info.name, "press 4");
  EXPECT_EQ(info.origin, "measured");
  EXPECT_EQ(info.note, "note");
  EXPECT_EQ(info.who.name, "ann");
  EXPECT_EQ(info.who.uid, 1000);
  EXPECT_EQ(info.sample_count, 3);
  EXPECT_EQ(info.samples.at("G1"), 2);
  EXPECT_EQ(info.samples.at("G2"), 1);
  EXPECT_EQ(info.first_utc, "2026-03-02T08:30:00.000Z");
  EXPECT_EQ(info.last_utc, "2026-03-02T08:30:01.000Z");
  EXPECT_EQ(info.rig_sha256, session::rig_sha256(store.load_session(first)));
  EXPECT_EQ(info.rig_sha256, sessions[1].rig_sha256) << "one rig file is one rig";
}

TEST_F(StoreSessions, HaveUniqueProperNames) {
  Store store = Store::open(file());
  (void)store.create_session("one", rig_text());
  EXPECT_EQ(
      refusal_of([&] { (void)store.create_session("one", rig_text()); }).trouble,
      StoreTrouble::kNameTaken);
  for (const std::string& name :
       {std::string(), std::string("a\nb"), std::string(201, 'x'), std::string("\xE9")}) {
    EXPECT_EQ(
        refusal_of([&] { (void)store.create_session(name, rig_text()); }).trouble,
        StoreTrouble::kRefused);
  }
  EXPECT_THROW((void)store.create_session("bad rig", "name = 5"), session::DataError);
  EXPECT_EQ(store.list_sessions().size(), 1U);
}

TEST_F(StoreSessions, AreImportedWholeOrNotAtAll) {
  Store store = Store::open(file());
  Session session = session::read_bundle(test_paths::test_data() + "/sessions/00");
  session.samples[149].channels[2].value = std::nan("");
  const auto error = refusal_of([&] { (void)store.import_session(session); });
  EXPECT_EQ(error.trouble, StoreTrouble::kRefused);
  EXPECT_THAT(error.what(), HasSubstr("dial C is not finite"));
  session.samples[149] = session.samples[0];  // the same key
  EXPECT_EQ(
      refusal_of([&] { (void)store.import_session(session); }).trouble, StoreTrouble::kRefused);
  EXPECT_TRUE(store.list_sessions().empty());
  Database raw(file(), Database::Mode::kReadOnly);
  EXPECT_EQ(raw.number("SELECT count(*) FROM samples"), 0);
}

TEST_F(StoreSessions, OfTenThousandRowsAreImportedAndLoadedQuickly) {
  Session session;
  session.name = "large";
  session.rig = geometry::default_rig();
  for (int i = 0; i < 10'000; ++i) session.samples.push_back(sample_at("G1", i));
  const std::string csv = session::session_csv(session);
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::time_point from) {
    return std::chrono::duration<double>(Clock::now() - from).count();
  };
  Store store = Store::open(file());
  auto from = Clock::now();
  const Session read = session::parse_session(
      csv, "session.csv", rig_text(), "rig.toml", {.skip_bad_rows = false, .name = "large"});
  const double parse_s = seconds(from);
  from = Clock::now();
  const SessionId id = store.import_session(read);
  const double import_s = seconds(from);
  from = Clock::now();
  const Session loaded = store.load_session(id);
  std::cout << "10,000 rows: read " << parse_s << " s, import " << import_s << " s, load "
            << seconds(from) << " s\n";
  EXPECT_EQ(loaded.samples.size(), 10'000U);
  EXPECT_EQ(session::session_csv(loaded), csv);
}

TEST_F(StoreSamples, ComeBackExactlyWithQualityAndReason) {
  session::Sample sample = sample_at("G1", 0);
  sample.channels[1] = {std::nullopt, session::Quality::kBad, "timeout", std::nullopt};
  sample.channels[2] = {1.0 / 3.0, session::Quality::kUncertain, "unsettled", sample.time_utc};
  session::set_position(sample, 6, Eigen::Vector2d(1e-300, 0.1 + 0.2));
  const SampleId id = store_.append_sample(id_, sample);
  EXPECT_GT(id.value, 0);
  const Session session = store_.load_session(id_);
  ASSERT_EQ(session.samples.size(), 1U);
  expect_equal(session.samples[0], sample);
}

TEST_F(StoreSamples, HoldAnyNumberOfJointsAndCoordinates) {
  const session::SampleLayout arm = session::make_layout(
      {{"q1", "rad"}, {"q2", "rad"}, {"q3", "mm"}, {"q4", "rad"}}, {}, {"x", "y", "z"});
  session::Sample sample;
  sample.set = "G1";
  sample.q = Eigen::Vector4d(0.1 + 0.2, -1.5, 250.0, 1e-9);
  sample.approach = {1, std::nullopt, 0, -1};
  sample.target_mm = Eigen::Vector3d(300, -20, 150);
  session::set_position(sample, 0, Eigen::Vector3d(300.1, -20.2, 150.3));
  {
    Database raw(file(), Database::Mode::kReadWrite);
    Transaction transaction(raw);
    (void)SampleWriter(raw).write(id_, sample, std::nullopt, arm);
    transaction.commit();
    EXPECT_EQ(
        raw.text("SELECT group_concat(joint || '_' || unit || '=' || value, ' ') FROM v_joints "
                 "WHERE is_live AND joint <> 'q1'"),
        "q2_rad=-1.5 q3_mm=250.0 q4_rad=1.0e-09");
    EXPECT_EQ(
        raw.text("SELECT group_concat(channel || '_' || unit || '=' || value, ' ') FROM "
                 "v_channels WHERE session = 's'"),
        "x_mm=300.1 y_mm=-20.2 z_mm=150.3");
    EXPECT_EQ(raw.number("SELECT count(theta1_rad) FROM v_samples"), 0) << "not its joint";
  }
  const Session session = store_.load_session(id_);
  ASSERT_EQ(session.samples.size(), 1U);
  expect_equal(session.samples[0], sample);
}

TEST_F(StoreSamples, KeepWhatADeviceSentAsTextEvenIfItIsNone) {
  session::Sample sample = sample_at("G1", 0);
  sample.channels[0] = {
      std::nullopt, session::Quality::kBad, std::string("parse: \xFF\xFE\0!", 11), {}};
  (void)store_.append_sample(id_, sample);
  EXPECT_EQ(
      store_.load_session(id_).samples[0].channels[0].reason,
      "parse: ?"
      "?"
      "?!");
}

TEST_F(StoreSamples, OfAKeyThatIsMeasuredAreRefused) {
  (void)store_.append_sample(id_, sample_at("G1", 0));
  (void)store_.append_sample(id_, sample_at("G1", 0, 1));
  const auto error = refusal_of([&] { (void)store_.append_sample(id_, sample_at("G1", 0)); });
  EXPECT_EQ(error.trouble, StoreTrouble::kAlreadyThere);
  EXPECT_THAT(error.what(), HasSubstr("set G1, point 0, repeat 0 is measured already"));
  EXPECT_EQ(store_.load_session(id_).samples.size(), 2U);
}

TEST_F(StoreSamples, WithoutSenseAreRefusedInWords) {
  session::Sample sample = sample_at("G1", 0);
  sample.q[0] = std::nan("");
  EXPECT_EQ(
      refusal_of([&] { (void)store_.append_sample(id_, sample); }).trouble,
      StoreTrouble::kRefused);
  sample = sample_at("G1", 0);
  sample.channels.pop_back();
  EXPECT_THAT(
      refusal_of([&] { (void)store_.append_sample(id_, sample); }).what(),
      HasSubstr("5 dial readings for 6 dials"));
  EXPECT_EQ(
      refusal_of([&] {
        (void)store_.append_sample(SessionId{99}, sample_at("G1", 0));
      }).trouble,
      StoreTrouble::kNotFound);
}

TEST_F(StoreSamples, AreRetakenByANewRowAndTheOldOneIsKept) {
  const SampleId old = store_.append_sample(id_, sample_at("G1", 0));
  session::Sample again = sample_at("G1", 0);
  again.channels[0].value = 9.999;
  EXPECT_EQ(
      refusal_of([&] { (void)store_.retake_sample(id_, sample_at("G1", 5)); }).trouble,
      StoreTrouble::kNotFound);
  const SampleId fresh = store_.retake_sample(id_, again);
  const auto all = store_.list_samples(id_);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].id, old);
  EXPECT_FALSE(all[0].live);
  EXPECT_TRUE(all[1].live);
  EXPECT_EQ(all[1].supersedes, old);
  EXPECT_EQ(all[0].sample.channels[0].value, 0.0);
  const Session session = store_.load_session(id_);
  ASSERT_EQ(session.samples.size(), 1U);
  EXPECT_EQ(session.samples[0].channels[0].value, 9.999);
  // Undone, the retake gives way to what it had replaced.
  store_.withdraw_sample(fresh, "by mistake", {"ann", {}, {}});
  EXPECT_EQ(store_.load_session(id_).samples[0].channels[0].value, 0.0);
  EXPECT_EQ(
      refusal_of([&] { store_.withdraw_sample(fresh, "twice"); }).trouble,
      StoreTrouble::kNotFound);
}

TEST_F(StoreSamples, AreUndoneFromTheNewestAndCanBeMeasuredAgain) {
  EXPECT_FALSE(store_.undo_last(id_).has_value());
  (void)store_.append_sample(id_, sample_at("G1", 0));
  const SampleId second = store_.append_sample(id_, sample_at("G1", 1));
  EXPECT_EQ(store_.undo_last(id_), second);
  EXPECT_EQ(store_.load_session(id_).samples.size(), 1U);
  (void)store_.append_sample(id_, sample_at("G1", 1));
  EXPECT_EQ(store_.load_session(id_).samples.size(), 2U);
  EXPECT_EQ(store_.list_samples(id_).size(), 3U);
}

TEST_F(StoreSamples, CannotBeChangedOrDeletedEvenBySql) {
  (void)store_.append_sample(id_, sample_at("G1", 0));
  store_.withdraw_sample(store_.append_sample(id_, sample_at("G1", 1)), "undo");
  Database raw(file(), Database::Mode::kReadWrite);
  raw.execute("PRAGMA recursive_triggers = ON");
  const std::vector<std::string> attempts{
      "UPDATE samples SET temperature_c = 0",
      "UPDATE sample_joints SET value = 0",
      "DELETE FROM sample_joints",
      "DELETE FROM samples",
      "UPDATE sample_channels SET value = 0",
      "DELETE FROM sample_channels",
      ("REPLACE INTO sample_channels SELECT sample_id, channel_index, channel, unit, 0, "
       "quality, reason, time_utc FROM sample_channels"),
      "DELETE FROM withdrawals",
      "UPDATE rigs SET text = ''",
      "DELETE FROM sessions",
      "UPDATE sessions SET rig_id = 2",
  };
  for (const std::string& sql : attempts) {
    EXPECT_THAT(
        refusal_of([&] { raw.execute(sql); }).what(), testing::ContainsRegex("never|keeps"))
        << sql;
  }
  EXPECT_EQ(store_.load_session(id_).samples[0].channels[1].value, 1.0);
}

TEST_F(StoreSamples, AddedByTwoThreadsAreAllThere) {
  const auto add = [&](const char* set) {
    for (int i = 0; i < 20; ++i) (void)store_.append_sample(id_, sample_at(set, i));
  };
  std::thread other([&] { add("G2"); });
  add("G1");
  other.join();
  EXPECT_EQ(store_.load_session(id_).samples.size(), 40U);
}

}  // namespace
}  // namespace sixdial::db
