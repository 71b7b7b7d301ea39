// A real sixdiald and files that hang or are not what they should be: a pipe, a share that is
// gone, one database by two names, another program that holds the database.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "db/sqlite.h"
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
using testing::LineClient;
using testing::Rig;
using testing::start;
using testing::TempDirectory;

std::vector<std::string> with_dead_share() {
  return {
      std::string("LD_PRELOAD=") + test_paths::bin_dir() + "/libsixdial_disk.so",
      "ASAN_OPTIONS=verify_asan_link_order=0"};
}

class HungFiles : public ::testing::Test {
 protected:
  std::filesystem::path folder(const std::string& name) {
    const auto path = directory_.path() / name;
    std::filesystem::create_directories(path);
    return path;
  }
  TempDirectory directory_;
  Rig rig_;
};

TEST_F(HungFiles, APipeInsteadOfAFileIsRefusedByName) {
  Daemon daemon(directory_.path(), rig_.now());
  LineClient client = daemon.client();
  const auto bundle = folder("piped");
  std::ofstream(bundle / "rig.toml") << rig_.toml();
  ASSERT_EQ(::mkfifo((bundle / "session.csv").c_str(), 0600), 0);
  const Json refused =
      client.call("session.import", {{"path", bundle.string()}, {"name", "piped"}});
  EXPECT_EQ(error_code_of(refused), "bad_data");
  EXPECT_THAT(
      refused["error"]["message"].get<std::string>(),
      HasSubstr((bundle / "session.csv").string() + ": is a pipe, not a plain file"));
}

TEST_F(HungFiles, AShareThatIsGoneHoldsUpNobodyElseAndNotTheEnd) {
  Daemon daemon(directory_.path(), rig_.now(), with_dead_share());
  LineClient other = daemon.client();
  const auto share = folder("dead-share");
  std::vector<std::jthread> waiting;
  for (int i = 0; i < 3; ++i) {
    waiting.emplace_back([&, number = i] {
      try {
        LineClient client = daemon.client();
        client.call(
            "session.import",
            {{"path", share.string()}, {"name", "gone-" + std::to_string(number)}});
      } catch (const std::runtime_error&) {
        // The daemon has ended meanwhile.
      }
    });
  }
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(error_code_of(other.call("session.list")), "");
    EXPECT_EQ(error_code_of(other.call("collect.status")), "");
  }
  EXPECT_EQ(error_code_of(create(other, rig_)), "") << "the store takes sessions meanwhile";
  const Json told = other.call("session.import", {{"path", share.string()}, {"name", "too"}});
  EXPECT_EQ(error_code_of(told), "file");
  EXPECT_THAT(
      told["error"]["message"].get<std::string>(),
      HasSubstr(share.string() + " does not answer"));
  EXPECT_THAT(
      told["error"]["data"]["hint"].get<std::string>(), HasSubstr("share that is gone"));
  EXPECT_EQ(daemon.end(SIGTERM), 0);
}

TEST_F(HungFiles, OneDatabaseByTwoNamesHasOneWriter) {
  Daemon first(directory_.path(), rig_.now());
  LineClient client = first.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  const auto real = directory_.path() / "daemon.db";
  const auto elsewhere = folder("elsewhere");
  const std::vector<std::pair<std::string, std::filesystem::path>> links{
      {"symbolic", folder("symbolic") / "daemon.db"}, {"hard", folder("hard") / "daemon.db"}};
  std::filesystem::create_symlink(real, links[0].second);
  std::filesystem::create_hard_link(real, links[1].second);
  for (const auto& [kind, link] : links) {
    Daemon second(link.parent_path(), rig_.now());
    EXPECT_NE(WEXITSTATUS(second.ended()), 0) << kind;
    const std::string log = session::read_file(second.log().string());
    EXPECT_THAT(log, HasSubstr("writes this database already")) << kind;
    EXPECT_THAT(log, HasSubstr(link.string())) << "the path is named";
  }
  EXPECT_EQ(error_code_of(client.call("session.show", {{"session", "live"}})), "");
}

TEST_F(HungFiles, ADatabaseThatIsNoPlainFileIsRefusedAtOnce) {
  const auto odd = folder("odd");
  ASSERT_EQ(::mkfifo((odd / "daemon.db").c_str(), 0600), 0);
  Daemon daemon(odd, rig_.now());
  EXPECT_NE(WEXITSTATUS(daemon.ended()), 0);
  EXPECT_THAT(session::read_file(daemon.log().string()), HasSubstr("no plain file"));
}

TEST_F(HungFiles, ADatabaseThatAnotherProgramHoldsPausesTheCollection) {
  constexpr int kPoints = 6;
  Daemon daemon(directory_.path(), rig_.now());
  LineClient client = daemon.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  LineClient watcher = daemon.client();
  watcher.call("events.subscribe", {{"topics", {"sample", "collect"}}});
  ASSERT_EQ(error_code_of(start(client, Rig::plan(kPoints))), "");
  while (watcher.read()["params"]["topic"] != "sample") {
  }
  db::Database holder(
      (directory_.path() / "daemon.db").string(), db::Database::Mode::kReadWrite);
  holder.execute("BEGIN IMMEDIATE");
  Json paused;
  do {
    paused = watcher.read()["params"]["data"];
  } while (paused["type"] != "paused" && paused["type"] != "failed");
  EXPECT_EQ(paused["state"], "paused") << paused;
  EXPECT_EQ(paused["pause_reason"], "store");
  EXPECT_THAT(
      paused["message"].get<std::string>(), HasSubstr("let the other program go and resume"));
  holder.execute("ROLLBACK");
  ASSERT_TRUE(eventually([&] {
    const Json status = client.call("collect.status")["result"];
    if (status["state"] == "paused") client.call("collect.resume");
    return status["state"] == "done";
  }));
  EXPECT_EQ(client.call("session.show", {{"session", "live"}})["result"]["samples"], kPoints)
      << "the sample in hand was dropped";
}

/// A plan of so many points takes a minute.
const std::string kLongRequest = R"({"jsonrpc": "2.0", "id": 1, "method": "plan.grid", )"
                                 R"("params": {"session": "live", "nx": 1000, "ny": 1000}})"
                                 "\n";

TEST_F(HungFiles, WhatTakesLongHoldsUpNobodyElse) {
  Daemon daemon(directory_.path(), rig_.now());
  LineClient other = daemon.client();
  ASSERT_EQ(error_code_of(create(other, rig_)), "");
  std::vector<LineClient> waiting;
  for (int i = 0; i < 4; ++i) {  // more than there are workers for such
    waiting.push_back(daemon.client());
    ASSERT_TRUE(waiting.back().send(kLongRequest));
  }
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(error_code_of(other.call("session.list")), "");
    EXPECT_EQ(error_code_of(other.call("job.list")), "");
  }
  for (const LineClient& each : waiting) {
    EXPECT_FALSE(each.has_answer()) << "a list waited for it, or it takes too little time";
  }
  EXPECT_EQ(daemon.end(SIGTERM), 0);
}

TEST_F(HungFiles, WhatTakesLongEndsWithItsClient) {
  Daemon daemon(directory_.path(), rig_.now());
  LineClient other = daemon.client();
  ASSERT_EQ(error_code_of(create(other, rig_)), "");
  for (int i = 0; i < 60; ++i) {
    LineClient gone = daemon.client();
    gone.send(kLongRequest);
  }
  const Json plan = other.call("plan.random", {{"session", "live"}, {"count", 3}});
  EXPECT_EQ(error_code_of(plan), "") << "60 plans that nobody waits for would take minutes";
}

}  // namespace
}  // namespace sixdial::service
