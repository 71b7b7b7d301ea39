// The file itself: who may open it, which schema, copies, and what is left after kill -9.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <random>
#include <set>

#include "db/migrations.h"
#include "db/sqlite.h"
#include "tests/db/store_fixture.h"
#include "tests/support/figure.h"
#include "tests/support/paths.h"

namespace sixdial::db {
namespace {

using testing::HasSubstr;

class StoreFile : public StoreTest {};

TEST_F(StoreFile, IsSyncedFullyWithAWriteAheadLogAndKeys) {
  Store store = Store::open(file());
  EXPECT_EQ(store.schema_version(), newest_schema());
  Database raw(file(), Database::Mode::kReadOnly);
  EXPECT_EQ(raw.text("PRAGMA journal_mode"), "wal");
  EXPECT_EQ(raw.number("PRAGMA application_id"), kApplicationId);
  EXPECT_EQ(raw.number("PRAGMA user_version"), newest_schema());
  EXPECT_EQ(
      raw.number("SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND sql NOT LIKE "
                 "'%STRICT%'"),
      0);
}

TEST_F(StoreFile, WorksInMemory) {
  Store store = Store::open(":memory:");
  const SessionId id = store.create_session("s", rig_text());
  (void)store.append_sample(id, sample_at("G1", 0));
  EXPECT_EQ(store.load_session(id).samples.size(), 1U);
}

TEST_F(StoreFile, HasOneWriterAtATime) {
  Store first = Store::open(file());
  const auto error = refusal_of([&] { (void)Store::open(file()); });
  EXPECT_EQ(error.trouble, StoreTrouble::kLocked);
  EXPECT_THAT(
      error.what(), HasSubstr(
                        "another Sixdial process (process " + std::to_string(::getpid()) +
                        ") writes this database already"));
  (void)first.create_session("still works", rig_text());
  first = Store::open(file("other.db"));
  (void)Store::open(file());  // free again
}

TEST_F(StoreFile, IsReadWhileItIsWritten) {
  Store writer = Store::open(file());
  const SessionId id = writer.create_session("s", rig_text());
  Store reader = Store::open_read_only(file());
  (void)writer.append_sample(id, sample_at("G1", 0));
  EXPECT_EQ(reader.load_session(id).samples.size(), 1U);
  EXPECT_EQ(
      refusal_of([&] { (void)reader.append_sample(id, sample_at("G1", 1)); }).trouble,
      StoreTrouble::kReadOnly);
  EXPECT_EQ(reader.load_session(id).samples.size(), 1U);
}

TEST_F(StoreFile, OfANewerProgramIsRefusedInWords) {
  { (void)Store::open(file()); }
  {
    Database raw(file(), Database::Mode::kReadWrite);
    raw.execute("PRAGMA user_version = 1000");
  }
  for (const bool read_only : {false, true}) {
    const auto error = refusal_of(
        [&] { (void)(read_only ? Store::open_read_only(file()) : Store::open(file())); });
    EXPECT_EQ(error.trouble, StoreTrouble::kTooNew);
    EXPECT_THAT(
        error.what(), HasSubstr("the database has schema 1000, this program knows up to"));
  }
  Database raw(file(), Database::Mode::kReadOnly);
  EXPECT_EQ(raw.number("PRAGMA user_version"), 1000) << "it was not touched";
}

TEST_F(StoreFile, OfAnotherProgramIsRefusedAndLeftAlone) {
  {
    Database raw(file(), Database::Mode::kReadWrite);
    raw.execute("CREATE TABLE recipes (name TEXT)");
  }
  const auto error = refusal_of([&] { (void)Store::open(file()); });
  EXPECT_EQ(error.trouble, StoreTrouble::kNotOurs);
  {
    Database raw(file(), Database::Mode::kReadOnly);
    EXPECT_EQ(raw.number("SELECT count(*) FROM sqlite_schema"), 1);
    EXPECT_EQ(raw.text("PRAGMA journal_mode"), "delete");
  }
  session::write_file(
      file("text.db"), "this is a letter, and long enough to have been a header");
  EXPECT_EQ(
      refusal_of([&] { (void)Store::open(file("text.db")); }).trouble, StoreTrouble::kNotOurs);
  EXPECT_EQ(
      refusal_of([&] { (void)Store::open_read_only(file("none.db")); }).trouble,
      StoreTrouble::kCannotOpen);
  EXPECT_EQ(
      refusal_of([&] { (void)Store::open(file("no_folder/a.db")); }).trouble,
      StoreTrouble::kCannotOpen);
}

// Every earlier schema, filled as its program would have, comes up to today's with its data.
TEST_F(StoreFile, OfEveryEarlierSchemaIsBroughtUpToDate) {
  ASSERT_GE(newest_schema(), 4);
  for (int version = 1; version < newest_schema(); ++version) {
    const std::string path = file("v" + std::to_string(version) + ".db");
    {
      Database raw(path, Database::Mode::kReadWrite);
      EXPECT_EQ(migrate(raw, version), 0);
      Statement(raw, "INSERT INTO rigs (sha256, text) VALUES (?, ?)")
          .bind(std::string(64, 'a'), rig_text())
          .run();
      raw.execute(
          "INSERT INTO sessions (name, rig_id, origin, created_utc, program_version, line_end, "
          "csv_end) VALUES ('old', 1, 'measured', '2026-01-01T00:00:00.000Z', '0', char(10), "
          "char(10));");
      raw.execute(
          version < 4
              ? "INSERT INTO samples (session_id, set_name, point, repeat, theta1_rad, "
                "theta2_rad, stored_utc) VALUES (1, 'G1', 7, 0, 1.5, 3.0, "
                "'2026-01-01T00:00:00.000Z')"
              : "INSERT INTO samples (id, session_id, set_name, point, repeat, stored_utc) "
                "VALUES (1, 1, 'G1', 7, 0, '2026-01-01T00:00:00.000Z');"
                "INSERT INTO sample_joints (sample_id, joint_index, joint, unit, value) "
                "VALUES (1, 0, 'theta1', 'rad', 1.5), (1, 1, 'theta2', 'rad', 3.0)");
    }
    EXPECT_EQ(
        refusal_of([&] { (void)Store::open_read_only(path); }).trouble, StoreTrouble::kTooOld);
    Store store = Store::open(path);
    EXPECT_EQ(store.schema_version(), newest_schema());
    const auto session = store.load_session(store.find_session("old"));
    ASSERT_EQ(session.samples.size(), 1U);
    EXPECT_EQ(session.samples[0].point, 7);
    EXPECT_EQ(session.samples[0].q, Eigen::Vector2d(1.5, 3.0));
    EXPECT_TRUE(store.check().empty());
  }
}

// Files kept from each schema's own time (tests/data/schemas/make.py).
TEST_F(StoreFile, StoredInEveryEarlierSchemaComesUpWithAllItHad) {
  int tried = 0;
  for (int version = 1; version < newest_schema(); ++version) {
    const std::string name = "schema_" + std::to_string(version) + ".db";
    const std::string kept = test_paths::test_data() + "/schemas/" + name;
    ASSERT_TRUE(std::filesystem::exists(kept))
        << kept << " is missing: make it with tests/data/schemas/make.py and keep it";
    std::filesystem::copy_file(kept, file(name));
    std::filesystem::permissions(
        file(name), std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
    Store store = Store::open(file(name));
    EXPECT_EQ(store.schema_version(), newest_schema());
    EXPECT_TRUE(store.check().empty()) << version;
    const SessionId id = store.find_session("old");
    const session::Session session = store.load_session(id);
    ASSERT_EQ(session.samples.size(), 2U) << "one was retaken, one withdrawn";
    EXPECT_EQ(session.samples[0].point, 1);
    EXPECT_EQ(session.samples[0].channels[5].reason, "timeout");
    EXPECT_EQ(session.samples[1].channels[0].value, 4.0);
    EXPECT_EQ(store.list_samples(id).size(), 4U);
    EXPECT_EQ(store.load_plan(id)->points.size(), 4U);
    EXPECT_EQ(store.open_points(id).size(), 2U);
    if (version >= 2) {
      EXPECT_EQ(store.load_results(id).at(0).json, R"({"rmse_mm":0.003})");
      EXPECT_EQ(store.fail_unfinished_jobs("ended"), 1);
    }
    (void)store.append_sample(id, sample_at("G2", 0));
    ++tried;
  }
  EXPECT_EQ(tried, newest_schema() - 1);
  test::figure("migration.schemas", tried);
}

TEST_F(StoreFile, AMigrationThatBreaksLeavesTheOldSchema) {
  {
    Database raw(file(), Database::Mode::kReadWrite);
    (void)migrate(raw, 1);
    // In the way of step 4, after those that have nothing against it.
    raw.execute("CREATE TABLE sample_joints (x INTEGER)");
  }
  EXPECT_THROW((void)Store::open(file()), StoreError);
  Database raw(file(), Database::Mode::kReadOnly);
  EXPECT_EQ(raw.number("PRAGMA user_version"), 1);
  EXPECT_EQ(raw.number("SELECT count(*) FROM sqlite_schema WHERE name = 'jobs'"), 0);
}

TEST_F(StoreFile, IsCopiedWholeIntoOneFileWhileItIsOpen) {
  Store store = Store::open(file());
  const SessionId id =
      store.import_session(session::read_bundle(test_paths::test_data() + "/sessions/00"));
  store.backup(file("copy.db"));
  (void)store.undo_last(id);
  Store copy = Store::open_read_only(file("copy.db"));
  EXPECT_EQ(copy.load_session(id).samples.size(), 150U);
  EXPECT_TRUE(copy.check().empty());
  EXPECT_FALSE(std::filesystem::exists(file("copy.db-wal")));
  EXPECT_EQ(refusal_of([&] { store.backup(file("copy.db")); }).trouble, StoreTrouble::kRefused)
      << "no copy is overwritten";
}

TEST_F(StoreFile, ThatIsDamagedSaysSo) {
  {
    Store store = Store::open(file());
    (void)store.import_session(session::read_bundle(test_paths::test_data() + "/sessions/00"));
    store.checkpoint();
  }
  {
    std::fstream raw(file(), std::ios::in | std::ios::out | std::ios::binary);
    raw.seekp(5 * 4096);
    const std::string junk(3 * 4096, '\x5A');
    raw.write(junk.data(), static_cast<std::streamsize>(junk.size()));
  }
  bool noticed = false;
  try {
    Store store = Store::open(file());
    noticed = !store.check().empty();
  } catch (const StoreError& error) {
    noticed = error.trouble == StoreTrouble::kCorrupt;
  }
  EXPECT_TRUE(noticed);
}

// The child's whole life: open, append, tell each id once append_sample has returned.
[[noreturn]] void append_until_killed(const std::string& path, int tell, int first_point) {
  try {
    Store store = Store::open(path);
    const SessionId id = store.find_session("s");
    for (int point = first_point;; ++point) {
      const SampleId sample = store.append_sample(id, sample_at("G1", point));
      const std::array<std::int64_t, 2> told{sample.value, point};
      if (::write(tell, told.data(), sizeof told) != sizeof told) ::_exit(2);
    }
  } catch (...) {
    ::_exit(3);
  }
}

TEST_F(StoreFile, LosesNoAcknowledgedSampleToKill9) {
  // The suite's share; scripts/reliability.sh asks for thousands.
  const int kills = test::size_of_run("SIXDIAL_CRASHES", 200);
  constexpr int kKillsAFile = 50;  // a file that grows for ever is checked ever more slowly
  constexpr int kPatience_ms = 60'000;
  std::mt19937_64 random(9);
  std::string path;
  std::map<std::int64_t, std::int64_t> acknowledged;  // id -> point
  std::size_t acknowledged_before = 0;
  int lost = 0;
  int unsound = 0;
  int next_point = 0;
  const auto begun = std::chrono::steady_clock::now();
  for (int kill_number = 0; kill_number < kills; ++kill_number) {
    if (kill_number % kKillsAFile == 0) {
      if (!path.empty()) std::filesystem::remove(path);
      path = file("crash_" + std::to_string(kill_number) + ".db");
      Store store = Store::open(path);
      (void)store.create_session("s", rig_text());
      acknowledged_before += acknowledged.size();
      acknowledged.clear();
      next_point = 0;
    }
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      ::close(pipe[0]);
      append_until_killed(path, pipe[1], next_point);
    }
    ::close(pipe[1]);
    // Let it get a few samples through, then strike a random while later.
    const int wanted = std::uniform_int_distribution<int>(0, 6)(random);
    const int delay_us = std::uniform_int_distribution<int>(0, 8000)(random);
    int got = 0;
    bool killed = false;
    while (true) {
      if (got >= wanted && !killed) {
        const timespec delay{0, delay_us * 1000L};
        ::nanosleep(&delay, nullptr);
        ::kill(child, SIGKILL);
        killed = true;
      }
      pollfd ready{pipe[0], POLLIN, 0};
      ASSERT_GT(::poll(&ready, 1, kPatience_ms), 0) << "the child says nothing";
      std::array<std::int64_t, 2> told{};
      const ssize_t count = ::read(pipe[0], told.data(), sizeof told);
      if (count != sizeof told) break;
      acknowledged[told[0]] = told[1];
      next_point = std::max(next_point, static_cast<int>(told[1]) + 1);
      ++got;
    }
    ::close(pipe[0]);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(killed && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
        << "the child ended by itself, status " << status;

    Store store = Store::open(path);  // the lock went with the child
    if (!store.check().empty()) ++unsound;
    std::map<std::int64_t, session::Sample> stored;
    for (StoredSample& sample : store.list_samples(store.find_session("s"))) {
      stored.emplace(sample.id.value, std::move(sample.sample));
    }
    for (const auto& [id, point] : acknowledged) {
      const auto found = stored.find(id);
      if (found == stored.end()) {
        ++lost;
        continue;
      }
      expect_equal(found->second, sample_at("G1", static_cast<int>(point)));
    }
    // One sample may have been stored whose acknowledgement was cut off.
    EXPECT_LE(
        stored.size(),
        acknowledged.size() + static_cast<std::size_t>(kill_number % kKillsAFile) + 1);
    for (const auto& [id, sample] : stored) next_point = std::max(next_point, sample.point + 1);
  }
  acknowledged_before += acknowledged.size();
  EXPECT_GE(acknowledged_before, static_cast<std::size_t>(kills));
  EXPECT_EQ(lost, 0) << "acknowledged, and not in the file";
  EXPECT_EQ(unsound, 0);
  const std::chrono::duration<double, std::milli> took =
      std::chrono::steady_clock::now() - begun;
  test::figure("crash.runs", kills);
  test::figure("crash.samples_acknowledged", acknowledged_before);
  test::figure("crash.samples_lost", lost);
  test::figure("crash.integrity_failures", unsound);
  test::figure("crash.ms_a_kill", took.count() / kills);
}

// A file-size limit makes writes fail as a broken disk does. The child says how many samples
// were acknowledged before, and whether the store then refused to go on.
[[noreturn]] void append_until_the_disk_fails(const std::string& path, int tell) {
  constexpr rlim_t kBytesMore = 200'000;
  ::signal(SIGXFSZ, SIG_IGN);
  int acknowledged = 0;
  int refused = 0;
  try {
    Store store = Store::open(path);
    const SessionId id = store.find_session("s");
    const rlimit limit{kBytesMore, RLIM_INFINITY};
    const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    for (int point = 0; point < 10'000 && refused < 2; ++point) {
      try {
        (void)store.append_sample(id, sample_at("G1", point));
        ++acknowledged;
      } catch (const StoreError& error) {
        if (error.trouble != StoreTrouble::kDiskFailed) ::_exit(4);
        ++refused;
        if (::setrlimit(RLIMIT_FSIZE, &none) != 0) ::_exit(2);  // the disk seems well again
      }
    }
  } catch (...) {
    ::_exit(3);
  }
  const std::array<int, 2> told{acknowledged, refused};
  ::_exit(::write(tell, told.data(), sizeof told) == sizeof told ? 0 : 5);
}

TEST_F(StoreFile, StopsWhenTheDiskFailsAndKeepsWhatItHas) {
  {
    Store store = Store::open(file());
    (void)store.create_session("s", rig_text());
  }
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) append_until_the_disk_fails(file(), pipe[1]);
  ::close(pipe[1]);
  std::array<int, 2> told{};
  const ssize_t count = ::read(pipe[0], told.data(), sizeof told);
  ::close(pipe[0]);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "status " << status;
  ASSERT_EQ(count, static_cast<ssize_t>(sizeof told));
  const auto [acknowledged, refused] = told;
  EXPECT_GT(acknowledged, 0);
  EXPECT_EQ(refused, 2) << "it must not go on after a failed write";
  Store store = Store::open(file());
  EXPECT_TRUE(store.check().empty());
  EXPECT_EQ(
      store.load_session(store.find_session("s")).samples.size(),
      static_cast<std::size_t>(acknowledged));
}

}  // namespace
}  // namespace sixdial::db
