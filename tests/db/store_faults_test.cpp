// A whole session on a disk that fails: at every write, sync and truncation in turn, full,
// torn, without power. Acknowledged samples lost: none. Damaged databases: none. And it says
// so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "db/migrations.h"
#include "tests/db/faulty_disk.h"
#include "tests/db/store_fixture.h"
#include "tests/support/figure.h"

namespace sixdial::db {
namespace {

using testing::HasSubstr;
using Fault = FaultyDisk::Fault;

constexpr int kSamples = 5;

struct Done {
  std::map<SampleId, session::Sample> acknowledged;
  std::set<SampleId> withdrawn;
  bool session = false;
  bool result = false;
  std::vector<StoreError> errors;
  int before_closing = 0;  // operations of the disk
  bool went_on = false;    // something was stored after a step had failed on the disk
};

// Everything a session does to its database. A step that fails is noted and the next is tried.
void live_a_session(const std::string& path, const FaultyDisk& disk, Done& done) {
  bool failed = false;
  const auto step = [&](const std::function<void()>& action, bool stores = true) {
    try {
      action();
      done.went_on = done.went_on || (failed && stores);
      return true;
    } catch (const StoreError& error) {
      failed = failed || (stores && error.trouble == StoreTrouble::kDiskFailed);
      done.errors.push_back(error);
      return false;
    }
  };
  std::optional<Store> store;
  if (!step([&] { store.emplace(Store::open(path, disk.name())); }, false)) return;
  SessionId id;
  const bool made = step([&] {
    id = store->create_session("s", rig_text());
    done.session = true;
  });
  if (!made) return;
  step([&] {
    (void)store->save_plan(
        id, session::plan_random(geometry::default_rig(), kSamples, {.seed = 3}).value());
  });
  for (int point = 0; point < kSamples; ++point) {
    step([&] {
      const session::Sample sample = sample_at("G1", point);
      done.acknowledged[store->append_sample(id, sample)] = sample;
    });
  }
  step([&] {
    session::Sample again = sample_at("G1", 0);
    again.channels[0].value = 9.5;
    done.acknowledged[store->retake_sample(id, again)] = again;
  });
  step([&] {
    if (const auto undone = store->undo_last(id)) done.withdrawn.insert(*undone);
  });
  step([&] { store->checkpoint(); }, false);
  step([&] {
    const JobId job = store->save_job({"calibrate", id, "{}", {}});
    store->update_job(job, {JobState::kRunning, {}, {}});
    (void)store->save_result({.session = id, .kind = "calibration", .json = "{}", .job = job});
    done.result = true;
  });
  done.before_closing = disk.operations();
}

class StoreFaults : public StoreTest {
 protected:
  // After the fault is over: sound, and everything that was acknowledged is there.
  void expect_nothing_lost(const std::string& vfs, const Done& done, const std::string& when) {
    Store store = Store::open(file(), vfs);
    ASSERT_EQ(store.check(), std::vector<std::string>{}) << when;
    if (!done.session) return;
    const SessionId id = store.find_session("s");
    std::map<SampleId, StoredSample> stored;
    for (StoredSample& each : store.list_samples(id)) stored[each.id] = std::move(each);
    for (const auto& [sample, value] : done.acknowledged) {
      ASSERT_TRUE(stored.contains(sample)) << when << ": sample " << sample.value << " is lost";
      expect_equal(stored[sample].sample, value);
    }
    for (const SampleId undone : done.withdrawn) {
      EXPECT_FALSE(stored.at(undone).live) << when << ": an undo is lost";
    }
    // What was not acknowledged may be there or not, but only the one in hand.
    EXPECT_LE(stored.size(), done.acknowledged.size() + 1) << when;
    if (done.result) {
      EXPECT_EQ(store.load_results(id).size(), 1U) << when;
    }
    // And it can be gone on with.
    (void)store.append_sample(id, sample_at("G2", 77));
    ++checked_;
  }
  static void expect_words(const Done& done, const std::string& when) {
    for (const StoreError& error : done.errors) {
      EXPECT_FALSE(error.problem.empty()) << when;
      const bool known = error.trouble == StoreTrouble::kDiskFailed ||
                         error.trouble == StoreTrouble::kDiskFull ||
                         error.trouble == StoreTrouble::kCannotOpen ||
                         error.trouble == StoreTrouble::kNotFound;  // retake of what failed
      EXPECT_TRUE(known) << when << ": " << error.what();
      EXPECT_FALSE(error.hint.empty()) << when << ": " << error.what();
    }
  }
  int operations_of_a_session() {
    FaultyDisk disk;
    Done done;
    live_a_session(file(), disk, done);
    EXPECT_TRUE(done.errors.empty());
    EXPECT_EQ(done.acknowledged.size(), static_cast<std::size_t>(kSamples) + 1);
    before_closing_ = done.before_closing;
    return disk.operations();
  }
  int checked_ = 0;
  int before_closing_ = 0;
};

TEST_F(StoreFaults, EveryWriteSyncAndTruncationOfASessionFailsOnceAndNothingIsLost) {
  const int operations = operations_of_a_session();
  ASSERT_GT(operations, 80);
  // The suite fails every operation in one way and every third in the others.
  const int stride = test::size_of_run("SIXDIAL_SWEEP_STRIDE", 3);
  int swept = 0;
  int said = 0;
  for (const Fault fault :
       {Fault::kErrorOnce, Fault::kTornOnce, Fault::kErrorForEver, Fault::kFullOnce}) {
    for (int at = 1; at <= operations; at += fault == Fault::kErrorOnce ? 1 : stride) {
      const std::string when =
          "fault " + std::to_string(static_cast<int>(fault)) + " at " + std::to_string(at);
      FaultyDisk disk;
      disk.order(fault, at);
      Done done;
      live_a_session(file(), disk, done);
      ASSERT_TRUE(disk.struck()) << when;
      expect_words(done, when);
      said += done.errors.empty() ? 0 : 1;
      // Only the checkpoint at closing may fail unsaid: what it moves is safe in the log.
      EXPECT_TRUE(!done.errors.empty() || at > before_closing_) << when;
      // A failed write or sync stops the store, whatever the disk does next.
      EXPECT_FALSE(done.went_on) << when;
      disk.restart();
      expect_nothing_lost(disk.name(), done, when);
      if (HasFatalFailure()) return;
      ++swept;
    }
  }
  EXPECT_GE(swept, operations + 3 * (operations / stride));
  EXPECT_GT(said, swept / 2);
  test::figure("sweep.operations", operations);
  test::figure("sweep.fault_points", swept);
  test::figure("sweep.told_at_once", said);
  test::figure("sweep.samples_lost", 0);
  test::figure("sweep.integrity_failures", 0);
}

TEST_F(StoreFaults, PowerMayGoAtEveryOperationAndTakeWhatWasNotSynced) {
  const int operations = operations_of_a_session();
  // Luck of the sectors: none arrives, all arrive, and so many mixtures of torn writes.
  const int seeds = test::size_of_run("SIXDIAL_POWER_SEEDS", 1);
  int losses = 0;
  for (int at = 1; at <= operations; ++at) {
    for (int k = 0; k < seeds; ++k) {
      const int seed = seeds == 1 ? at % 5 : k;
      const std::string when =
          "power lost at " + std::to_string(at) + ", seed " + std::to_string(seed);
      FaultyDisk disk;
      disk.order(Fault::kPowerLoss, at);
      Done done;
      live_a_session(file(), disk, done);
      disk.restart(static_cast<std::uint64_t>(seed));
      expect_nothing_lost(disk.name(), done, when);
      if (HasFatalFailure()) return;
      ++losses;
    }
  }
  EXPECT_EQ(losses, operations * seeds);
  test::figure("power.losses", losses);
  test::figure("power.samples_lost", 0);
  test::figure("power.integrity_failures", 0);
}

TEST_F(StoreFaults, AStoreThatDidNotSyncWouldBeCaught) {
  // The disk itself is tried: what is written and not synced goes with the power.
  FaultyDisk disk;
  FaultyDisk::File& file_on_it = *(disk.files["x"] = std::make_shared<FaultyDisk::File>());
  ASSERT_EQ(disk.write(file_on_it, "kept", 4, 0), 0);
  ASSERT_EQ(disk.sync(file_on_it), 0);
  ASSERT_EQ(disk.write(file_on_it, "lost", 4, 4), 0);
  disk.order(Fault::kPowerLoss, 1);
  EXPECT_NE(disk.sync(file_on_it), 0);
  EXPECT_NE(disk.sync(file_on_it), 0);
  disk.restart(0);
  EXPECT_EQ(file_on_it.now, "kept");
}

TEST_F(StoreFaults, AFullDiskIsSaidAndWithMoreRoomItGoesOn) {
  FaultyDisk disk;
  Store store = Store::open(file(), disk.name());
  const SessionId id = store.create_session("s", rig_text());
  std::size_t used = 0;
  for (const auto& [path, on_disk] : disk.files) used += on_disk->now.size();
  disk.set_capacity(used + 100'000);
  int stored = 0;
  std::optional<StoreError> full;
  for (int point = 0; point < 1000 && !full; ++point) {
    try {
      (void)store.append_sample(id, sample_at("G1", point));
      ++stored;
    } catch (const StoreError& error) {
      full = error;
    }
  }
  ASSERT_TRUE(full.has_value());
  EXPECT_GT(stored, 0);
  EXPECT_EQ(full->trouble, StoreTrouble::kDiskFull);
  EXPECT_THAT(full->what(), HasSubstr("full"));
  EXPECT_THAT(full->hint, HasSubstr("make room"));
  EXPECT_THROW((void)store.append_sample(id, sample_at("G1", stored)), StoreError);
  EXPECT_EQ(store.load_session(id).samples.size(), static_cast<std::size_t>(stored))
      << "what there is can still be read";
  disk.set_capacity(std::nullopt);
  (void)store.append_sample(id, sample_at("G1", stored));
  EXPECT_EQ(store.load_session(id).samples.size(), static_cast<std::size_t>(stored) + 1);
  EXPECT_TRUE(store.check().empty());
}

TEST_F(StoreFaults, AReadOnlyFileIsRefusedInWords) {
  FaultyDisk disk;
  {
    Store store = Store::open(file(), disk.name());
    (void)store.create_session("s", rig_text());
  }
  disk.set_read_only(true);
  const StoreError error = refusal_of([&] {
    Store store = Store::open(file(), disk.name());
    (void)store.append_sample(store.find_session("s"), sample_at("G1", 0));
  });
  EXPECT_TRUE(
      error.trouble == StoreTrouble::kReadOnly || error.trouble == StoreTrouble::kCannotOpen)
      << error.what();
  EXPECT_THAT(error.hint, HasSubstr("rights"));
}

TEST_F(StoreFaults, AClockThatStepsBackChangesNeitherOrderNorContent) {
  Store store = Store::open(file());
  const SessionId id = store.create_session("s", rig_text());
  std::vector<session::Sample> samples;
  for (int point = 0; point < 6; ++point) {
    session::Sample sample = sample_at("G1", point);
    if (point >= 3) sample.time_utc = *sample.time_utc - std::chrono::hours(1);
    (void)store.append_sample(id, sample);
    samples.push_back(std::move(sample));
  }
  EXPECT_TRUE(store.undo_last(id).has_value());
  const session::Session loaded = store.load_session(id);
  ASSERT_EQ(loaded.samples.size(), 5U) << "the newest is the last stored, not the latest";
  for (std::size_t i = 0; i < loaded.samples.size(); ++i) {
    expect_equal(loaded.samples[i], samples[i]);
  }
}

}  // namespace
}  // namespace sixdial::db
