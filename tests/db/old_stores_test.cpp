// Stores that earlier programs used (tests/data/stores/ORIGIN.md): everything is there after
// they are brought up to date, exports have the bytes of before, results still belong to their
// data. And where the disk fails meanwhile, the file is either the old one or the new one.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <map>

#include "db/migrations.h"
#include "db/sqlite.h"
#include "session/sha256.h"
#include "tests/db/faulty_disk.h"
#include "tests/db/store_fixture.h"
#include "tests/support/paths.h"

namespace sixdial::db {
namespace {

const std::string kStores = test_paths::test_data() + "/stores/";
constexpr std::array kSessions{"part", "tracker", "collected"};

constexpr std::array kSampleColumns{
    "sample_id",     "session",    "set_name",    "point",       "repeat",    "time_utc",
    "theta1_rad",    "theta2_rad", "target_x_mm", "target_y_mm", "approach1", "approach2",
    "temperature_c", "x_mm",       "y_mm",        "supersedes",  "is_live"};
constexpr std::array kReadingColumns{
    "session",   "set_name",   "point",           "repeat",       "is_live",
    "sample_id", "dial",       "displacement_mm", "quality",      "reason",
    "time_utc",  "theta1_rad", "theta2_rad",      "temperature_c"};

/// Every row of a view as text, to the last digit.
template <std::size_t N>
std::vector<std::string> rows_of(
    Database& database, const std::string& view, const std::array<const char*, N>& columns,
    const std::string& order) {
  std::string sql = "SELECT ''";
  for (const char* column : columns) sql += std::string(" || quote(") + column + ") || ','";
  Statement statement(database, sql + " FROM " + view + " ORDER BY " + order);
  std::vector<std::string> rows;
  while (statement.step()) rows.push_back(statement.text(0));
  return rows;
}

struct Views {
  std::vector<std::string> samples;
  std::vector<std::string> readings;
};
Views views_of(const std::string& path) {
  Database raw(path, Database::Mode::kReadOnly);
  return {
      rows_of(raw, "v_samples", kSampleColumns, "sample_id"),
      rows_of(raw, "v_readings", kReadingColumns, "sample_id, dial")};
}

class OldStores : public StoreTest {
 protected:
  std::string copied(int schema) {
    const std::string name = "schema_" + std::to_string(schema) + ".db";
    std::filesystem::copy_file(kStores + name, file(name));
    std::filesystem::permissions(
        file(name), std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
    return file(name);
  }

  static void expect_the_exports_of_before(Store& store) {
    for (const char* name : kSessions) {
      const session::Session session = store.load_session(store.find_session(name));
      const std::string csv = session::read_file(kStores + name + "/session.csv");
      EXPECT_EQ(session::session_csv(session), csv) << name;
      EXPECT_EQ(session::rig_toml(session), session::read_file(kStores + name + "/rig.toml"));
      EXPECT_EQ(session::data_sha256(session), session::sha256(csv));
    }
  }
};

TEST_F(OldStores, OfEverySchemaKeepEveryRowAndExportTheSameBytes) {
  for (int schema = 1; schema <= 3; ++schema) {
    SCOPED_TRACE(schema);
    const std::string path = copied(schema);
    std::map<std::string, std::int64_t> rows;
    {
      Database raw(path, Database::Mode::kReadOnly);
      EXPECT_EQ(raw.number("PRAGMA user_version"), schema);
      for (const char* table : {"samples", "withdrawals", "plans", "plan_points", "readings"}) {
        rows[table] = raw.number(std::string("SELECT count(*) FROM ") + table);
      }
      rows["positions"] = raw.number("SELECT count(x_mm) + count(y_mm) FROM samples");
    }
    EXPECT_EQ(rows["samples"], 52);
    Store store = Store::open(path);
    EXPECT_EQ(store.schema_version(), newest_schema());
    EXPECT_TRUE(store.check().empty());
    expect_the_exports_of_before(store);
    EXPECT_EQ(store.open_points(store.find_session("collected")).size(), 1U) << "it was undone";
    EXPECT_EQ(store.list_samples(store.find_session("collected")).size(), 6U);
    Database raw(path, Database::Mode::kReadOnly);
    const auto count = [&](const std::string& table) {
      return raw.number("SELECT count(*) FROM " + table);
    };
    for (const char* table : {"samples", "withdrawals", "plans", "plan_points"}) {
      EXPECT_EQ(count(table), rows[table]) << table;
    }
    EXPECT_EQ(count("sample_channels"), rows["readings"] + rows["positions"]);
    EXPECT_EQ(count("sample_joints"), 2 * rows["samples"]);
    EXPECT_EQ(count("plan_joints"), 2 * rows["plan_points"]);
    // It can be gone on with.
    (void)store.append_sample(store.find_session("collected"), sample_at("G2", 7));
  }
}

TEST_F(OldStores, KeepTheColumnsAndValuesOfTheDocumentedViews) {
  const std::string path = copied(3);
  const Views before = views_of(path);
  EXPECT_EQ(before.samples.size(), 52U);
  EXPECT_GT(before.readings.size(), 250U);
  { (void)Store::open(path); }
  const Views after = views_of(path);
  EXPECT_EQ(after.samples, before.samples);
  EXPECT_EQ(after.readings, before.readings);
}

TEST_F(OldStores, HaveResultsThatStillBelongToTheirData) {
  for (int schema = 2; schema <= 3; ++schema) {
    Store store = Store::open(copied(schema));
    const SessionId id = store.find_session("part");
    const auto results = store.load_results(id);
    ASSERT_EQ(results.size(), 1U);
    EXPECT_EQ(results[0].kind, "calibration");
    EXPECT_EQ(results[0].data_sha256, session::data_sha256(store.load_session(id)));
    EXPECT_EQ(results[0].rig_sha256, session::rig_sha256(store.load_session(id)));
  }
}

// Every write, sync and truncation of the migration fails in turn.
TEST_F(OldStores, AreWholeWhateverFailsWhileTheyAreBroughtUpToDate) {
  const std::string bytes = session::read_file(kStores + "schema_1.db");
  const std::string path = file("store.db");
  const auto with_the_store = [&](FaultyDisk& disk) {
    auto kept = std::make_shared<FaultyDisk::File>();
    kept->now = kept->synced = bytes;
    disk.files[path] = std::move(kept);
  };
  int operations = 0;
  {
    FaultyDisk disk;
    with_the_store(disk);
    { (void)Store::open(path, disk.name()); }
    operations = disk.operations();
  }
  ASSERT_GT(operations, 20);
  int old = 0;
  for (int at = 1; at <= operations; ++at) {
    FaultyDisk disk;
    with_the_store(disk);
    disk.order(at % 2 == 0 ? FaultyDisk::Fault::kFullOnce : FaultyDisk::Fault::kPowerLoss, at);
    try {
      (void)Store::open(path, disk.name());
    } catch (const StoreError&) {
    }
    disk.restart(static_cast<std::uint64_t>(at));
    {
      Database raw(path, Database::Mode::kReadWrite, disk.name());
      const auto version = raw.number("PRAGMA user_version");
      EXPECT_TRUE(version == 1 || version == newest_schema()) << at << ": " << version;
      EXPECT_EQ(raw.number("SELECT count(*) FROM samples"), 52) << at;
      old += version == 1 ? 1 : 0;
    }
    Store store = Store::open(path, disk.name());
    expect_the_exports_of_before(store);
    EXPECT_TRUE(store.check().empty()) << at;
  }
  EXPECT_GT(old, operations / 2);
}

}  // namespace
}  // namespace sixdial::db
