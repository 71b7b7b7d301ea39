// A real sixdiald whose disk fills up, stops syncing or turns read-only while it collects: what
// the operator is told, what goes on, and that nothing acknowledged is lost.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <array>
#include <atomic>
#include <fstream>

#include "session/bundle.h"
#include "session/csv.h"
#include "tests/support/live_rig.h"
#include "tests/support/paths.h"

namespace sixdial::service {
namespace {

using testing::create;
using testing::Daemon;
using testing::error_code_of;
using testing::eventually;
using ::testing::HasSubstr;
using testing::Key;
using testing::key_of;
using testing::LineClient;
using testing::Rig;
using testing::start;
using testing::TempDirectory;
using testing::wait_for_end;

constexpr int kPoints = 8;

/// What is ordered from tests/support/disk_shim.c in the daemon.
class Disk {
 public:
  explicit Disk(const std::filesystem::path& directory) : path_(directory / "disk-faults") {
    const int fd = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    const std::array<char, 8> none{'-'};
    if (fd < 0 || ::write(fd, none.data(), none.size()) != ssize_t{none.size()}) {
      throw std::runtime_error("no page for the disk's faults");
    }
    page_ = static_cast<char*>(
        ::mmap(nullptr, none.size(), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
    ::close(fd);
  }
  ~Disk() { ::munmap(page_, 8); }
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;

  void order(char fault) { std::atomic_ref(*page_).store(fault); }
  [[nodiscard]] std::uint32_t refused() const {
    return std::atomic_ref(*reinterpret_cast<std::uint32_t*>(page_ + 4)).load();
  }
  [[nodiscard]] std::vector<std::string> environment() const {
    return {
        "SIXDIAL_DISK_FAULTS=" + path_.string(),
        std::string("LD_PRELOAD=") + test_paths::bin_dir() + "/libsixdial_disk.so",
        "ASAN_OPTIONS=verify_asan_link_order=0"};
  }

 private:
  std::filesystem::path path_;
  char* page_ = nullptr;
};

class DiskTrouble : public ::testing::Test {
 protected:
  /// Collects, orders the fault once two samples are acknowledged, and reads events until the
  /// collection pauses or ends; returns that event.
  Json collect_until_it_strikes(Daemon& daemon, char fault) {
    LineClient client = daemon.client();
    EXPECT_EQ(error_code_of(create(client, rig_)), "");
    LineClient watcher = daemon.client();
    watcher.call("events.subscribe", {{"topics", {"sample", "collect"}}});
    EXPECT_EQ(error_code_of(start(client, Rig::plan(kPoints))), "");
    for (;;) {
      const Json params = watcher.read()["params"];
      const Json& data = params["data"];
      if (params["topic"] == "sample") {
        acknowledged_[key_of(data)] = data;
        if (acknowledged_.size() == 2) disk_.order(fault);
      } else if (
          data["type"] == "paused" || data["type"] == "failed" || data["type"] == "done") {
        EXPECT_GT(disk_.refused(), 0U);
        return data;
      }
    }
  }
  /// Every acknowledged sample is in the store with the readings that were told.
  void expect_nothing_lost(LineClient& client, std::size_t samples) {
    const auto folder = directory_.path() / "exported";
    client.call("session.export", {{"session", "live"}, {"path", folder.string()}});
    const session::Session session = session::read_bundle(folder);
    EXPECT_EQ(session.samples.size(), samples);
    std::size_t found = 0;
    for (const session::Sample& sample : session.samples) {
      const auto told = acknowledged_.find({sample.set, sample.point, sample.repeat});
      if (told == acknowledged_.end()) continue;
      ++found;
      const Json& shown = told->second["dials"]["A"]["value_mm"];
      ASSERT_EQ(shown.is_number(), sample.channels[0].value.has_value());
      if (shown.is_number()) {
        EXPECT_NEAR(shown.get<double>(), *sample.channels[0].value, 0.0005);
      }
    }
    EXPECT_EQ(found, acknowledged_.size());
  }

  TempDirectory directory_;
  Rig rig_;
  Disk disk_{directory_.path()};
  std::map<Key, Json> acknowledged_;
};

TEST_F(DiskTrouble, AFullDiskPausesTheCollectionAndWithRoomItGoesOnWithTheSameSample) {
  Daemon daemon(directory_.path(), rig_.now(), disk_.environment());
  const Json paused = collect_until_it_strikes(daemon, 'F');
  ASSERT_EQ(paused["state"], "paused") << paused;
  EXPECT_THAT(paused["message"].get<std::string>(), HasSubstr("full"));
  EXPECT_THAT(paused["message"].get<std::string>(), HasSubstr("make room and resume"));
  const auto stored = paused["stored_in_this_run"].get<std::size_t>();
  EXPECT_EQ(stored, acknowledged_.size());
  const Json& point = paused["point"];

  LineClient client = daemon.client();
  client.call("collect.resume");  // too early: still full
  LineClient watcher = daemon.client();
  watcher.call("events.subscribe", {{"topics", {"sample"}}});
  ASSERT_TRUE(eventually([&] {
    const Json status = client.call("collect.status")["result"];
    return status["state"] == "paused" && status["stored_in_this_run"] == stored;
  }));
  EXPECT_EQ(client.call("session.show", {{"session", "live"}})["result"]["samples"], stored)
      << "reading goes on";
  disk_.order('-');
  ASSERT_TRUE(eventually([&] {
    const Json status = client.call("collect.status")["result"];
    if (status["state"] == "paused") client.call("collect.resume");
    return status["state"] == "done";
  }));
  const Json next = watcher.read()["params"]["data"];
  EXPECT_EQ(next["point"], point["point"]) << "the sample in hand was dropped";
  EXPECT_EQ(next["set"], point["set"]);
  expect_nothing_lost(client, kPoints);
  EXPECT_EQ(daemon.end(SIGTERM), 0);
}

TEST_F(DiskTrouble, AFailingSyncEndsTheCollectionUntilTheServiceStartsAgain) {
  std::size_t stored = 0;
  {
    Daemon daemon(directory_.path(), rig_.now(), disk_.environment());
    const Json failed = collect_until_it_strikes(daemon, 'S');
    ASSERT_EQ(failed["state"], "failed") << failed;
    EXPECT_EQ(failed["error"]["data"]["code"], "storage");
    EXPECT_THAT(failed["error"]["message"].get<std::string>(), HasSubstr("disk I/O error"));
    EXPECT_THAT(
        failed["error"]["data"]["hint"].get<std::string>(),
        HasSubstr("what was acknowledged before is kept"));
    EXPECT_THAT(session::read_file(daemon.log().string()), HasSubstr("disk I/O error"));
    // Well again or not, nobody knows what that disk holds: nothing more is written.
    disk_.order('-');
    LineClient client = daemon.client();
    const Json refused = client.call("collect.start", {{"session", "live"}});
    EXPECT_EQ(error_code_of(refused), "storage") << refused;
    EXPECT_THAT(
        refused["error"]["message"].get<std::string>(), HasSubstr("an earlier step failed"));
    stored = client.call("session.show", {{"session", "live"}})["result"]["samples"]
                 .get<std::size_t>();
    EXPECT_GE(stored, acknowledged_.size());
    static_cast<void>(daemon.end(SIGTERM));
  }
  Daemon daemon(directory_.path(), rig_.now());
  LineClient client = daemon.client();
  ASSERT_EQ(error_code_of(client.call("collect.start", {{"session", "live"}})), "");
  EXPECT_EQ(wait_for_end(client)["state"], "done");
  expect_nothing_lost(client, kPoints);
}

TEST_F(DiskTrouble, ADiskThatTurnsReadOnlyEndsTheCollectionInWords) {
  Daemon daemon(directory_.path(), rig_.now(), disk_.environment());
  const Json failed = collect_until_it_strikes(daemon, 'R');
  ASSERT_EQ(failed["state"], "failed") << failed;
  EXPECT_EQ(failed["error"]["data"]["code"], "storage");
  EXPECT_FALSE(failed["error"]["data"]["hint"].get<std::string>().empty());
  LineClient client = daemon.client();
  const Json shown = client.call("session.show", {{"session", "live"}})["result"];
  EXPECT_EQ(shown["samples"], acknowledged_.size()) << "what was stored can still be read";
  EXPECT_EQ(WEXITSTATUS(daemon.end(SIGTERM)), 0);
}

/// The output and the exit code of the command line.
std::pair<std::string, int> run_cli(const std::string& words, const Daemon& daemon) {
  const std::string command = test_paths::bin_dir() + "/sixdial --socket '" +
                              daemon.socket().string() + "' " + words + " 2>&1 </dev/null";
  FILE* pipe = ::popen(command.c_str(), "r");
  std::string said;
  std::array<char, 4096> piece{};
  for (std::size_t size = 0; (size = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) {
    said.append(piece.data(), size);
  }
  return {said, WEXITSTATUS(::pclose(pipe))};
}

TEST_F(DiskTrouble, IsToldByTheCommandLineWithAnExitCode) {
  Daemon daemon(directory_.path(), rig_.now(), disk_.environment());
  LineClient client = daemon.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  const auto plan = directory_.path() / "plan.csv";
  std::ofstream(plan) << session::plan_csv(
      Rig::plan(kPoints), session::layout_of(geometry::default_rig()));
  client.call("events.subscribe", {{"topics", {"sample"}}});
  std::thread breaks([&] {
    client.read();
    disk_.order('S');
  });
  const auto [said, code] = run_cli("collect " + plan.string() + " --session live", daemon);
  breaks.join();
  EXPECT_EQ(code, 1) << said;
  EXPECT_THAT(said, HasSubstr("disk I/O error"));
  EXPECT_THAT(said, HasSubstr("what was acknowledged before is kept"));
}

}  // namespace
}  // namespace sixdial::service
