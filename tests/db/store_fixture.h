// A folder of its own for each test, and samples to put into a store.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "db/store.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "session/rig_file.h"

namespace sixdial::db {

class StoreTest : public testing::Test {
 protected:
  StoreTest() {
    std::string pattern = testing::TempDir() + "/sixdial_db_XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
  }
  ~StoreTest() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name = "store.db") const {
    return (folder_ / name).string();
  }

  std::filesystem::path folder_;
};

inline std::string rig_text() { return session::write_rig(geometry::default_rig()); }

inline session::Sample sample_at(const std::string& set, int point, int repeat = 0) {
  session::Sample sample;
  sample.set = set;
  sample.point = point;
  sample.repeat = repeat;
  sample.time_utc =
      session::from_iso8601("2026-03-02T08:30:00Z").value() + std::chrono::seconds(point);
  sample.q = Eigen::Vector2d(1.5 + 1e-8 * point, 3.0);
  sample.target_mm = Eigen::Vector2d(18.402564, 54.24929);
  sample.approach = {1, std::nullopt};
  sample.temperature_c = 20.03;
  sample.channels.resize(6);
  for (std::size_t i = 0; i < 6; ++i) {
    sample.channels[i].value = 0.001 * point + static_cast<double>(i);
    sample.channels[i].time_utc = sample.time_utc;
  }
  return sample;
}

inline void expect_equal(const session::Sample& a, const session::Sample& b) {
  EXPECT_EQ(a.set, b.set);
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.repeat, b.repeat);
  EXPECT_EQ(a.time_utc, b.time_utc);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.target_mm, b.target_mm);
  EXPECT_EQ(a.approach, b.approach);
  EXPECT_EQ(a.temperature_c, b.temperature_c);
  EXPECT_EQ(a.line, b.line);
  EXPECT_EQ(a.source_row, b.source_row);
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t i = 0; i < a.channels.size(); ++i) {
    EXPECT_EQ(a.channels[i].value, b.channels[i].value);
    EXPECT_EQ(a.channels[i].quality, b.channels[i].quality);
    EXPECT_EQ(a.channels[i].reason, b.channels[i].reason);
    EXPECT_EQ(a.channels[i].time_utc, b.channels[i].time_utc);
  }
}

template <typename Action>
StoreError refusal_of(Action action) {
  try {
    action();
  } catch (const StoreError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return {StoreTrouble::kOther, "", "", ""};
}

/// A store with a session in it.
class StoreSamples : public StoreTest {
 protected:
  Store store_ = Store::open(file());
  SessionId id_ = store_.create_session("s", rig_text());
};

}  // namespace sixdial::db
