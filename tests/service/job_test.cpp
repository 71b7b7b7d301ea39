// Jobs: a number at once, one after the other, cancelled, waited for, outliving their clients.
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <tuple>

#include "tests/support/rig_for_tests.h"

namespace sixdial::service {
namespace {

using testing::error_code_of;
using testing::eventually;
using testing::kPatience;
using testing::LineClient;
using testing::RunningService;

/// A job that goes on until it is let go or cancelled.
class Gate {
 public:
  JobBoard::Work work() {
    return [this](const JobControl& control, const Job&) -> std::int64_t {
      std::unique_lock lock(mutex_);
      running_ = true;
      changed_.notify_all();
      while (!open_) {
        changed_.wait_for(lock, std::chrono::milliseconds(5));
        control.check();
        control.report({.stage = "waiting", .done = 1, .total = 2});
      }
      return 42;
    };
  }
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  bool wait_until_running() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return running_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  bool running_ = false;
};

TEST(Jobs, AJobOutlivesTheClientThatWaitsForIt) {
  Gate gate;
  RunningService running;
  const Job job = running.service().jobs().start({.kind = "test"}, gate.work());
  {
    LineClient client = running.client();
    client.send(
        R"({"jsonrpc":"2.0","id":1,"method":"job.wait","params":{"job":)" +
        std::to_string(job.id) + "}}\n");
    EXPECT_EQ(client.call("hello")["result"]["service"], "sixdiald");  // not held up
  }
  gate.open();
  LineClient client = running.client();
  const Json reply = client.call("job.wait", {{"job", job.id}});
  EXPECT_EQ(reply["result"]["state"], "done");
  EXPECT_EQ(reply["result"]["result"], 42);
}

TEST(Jobs, WaitingEndsWithTheTimeout) {
  Gate gate;
  RunningService running;
  const Job job = running.service().jobs().start({.kind = "test"}, gate.work());
  ASSERT_TRUE(gate.wait_until_running());
  LineClient client = running.client();
  EXPECT_EQ(
      client.call("job.wait", {{"job", job.id}, {"timeout_s", 0.02}})["result"]["state"],
      "running");
  gate.open();
}

TEST(Jobs, ARunningJobAndOneInTheQueueAreCancelled) {
  Gate first;
  Gate second;
  RunningService running;
  JobBoard& jobs = running.service().jobs();
  const Job one = jobs.start({.kind = "test"}, first.work());
  ASSERT_TRUE(first.wait_until_running());
  const Job two = jobs.start({.kind = "test"}, second.work());
  LineClient client = running.client();
  Json reply = client.call("job.cancel", {{"job", two.id}});
  EXPECT_EQ(reply["result"]["state"], "cancelled");
  reply = client.call("job.cancel", {{"job", one.id}});
  EXPECT_EQ(reply["result"]["cancelling"], true);
  reply = client.call("job.wait", {{"job", one.id}});
  EXPECT_EQ(reply["result"]["state"], "cancelled");
  EXPECT_EQ(reply["result"]["error"]["data"]["code"], "cancelled");
  EXPECT_EQ(client.call("job.cancel", {{"job", one.id}})["result"]["cancelling"], false);
}

TEST(Jobs, AFailureIsToldWithItsReason) {
  RunningService running;
  const Job job = running.service().jobs().start(
      {.kind = "test"}, [](const JobControl&, const Job&) -> std::int64_t {
        throw Error(
            ErrorCode::kBadData, "dial C disagrees", {{"dial", "C"}}, "Look at dial C.");
      });
  LineClient client = running.client();
  const Json result = client.call("job.wait", {{"job", job.id}})["result"];
  EXPECT_EQ(result["state"], "failed");
  EXPECT_EQ(result["error"]["data"]["code"], "bad_data");
  EXPECT_EQ(result["error"]["data"]["at"]["dial"], "C");
  EXPECT_EQ(result["error"]["message"], "dial C disagrees");
}

TEST(Jobs, ProgressComesAsEventsFromQueuedToDone) {
  RunningService running;
  LineClient client = running.client();
  client.call("events.subscribe", {{"topics", {"job"}}});
  std::ignore = running.service().jobs().start(
      {.kind = "test"}, [](const JobControl& control, const Job&) -> std::int64_t {
        control.report({.stage = "first", .done = 1, .total = 4, .best_mm = 0.5});
        control.report({.stage = "second", .done = 4, .total = 4, .best_mm = 0.25});
        return 7;
      });
  std::vector<std::string> types;
  Json last;
  while (types.empty() || types.back() != "done") {
    last = client.read()["params"]["data"];
    types.push_back(last["type"]);
  }
  EXPECT_EQ(
      types, (std::vector<std::string>{"queued", "started", "progress", "progress", "done"}));
  EXPECT_EQ(last["progress"]["stage"], "second");
  EXPECT_EQ(last["progress"]["best_mm"], 0.25);
  EXPECT_EQ(last["result"], 7);
}

TEST(Jobs, OfEveryJobTheQueueIsToldBeforeItsStart) {
  // The job thread is free or busy with the last one as it happens: many are tried.
  constexpr int kJobs = 1000;
  EventHub events(std::size_t{3} * kJobs);
  std::atomic<std::int64_t> last{0};
  JobBoard board(
      events, {.create = [&](const Job&) { return ++last; }, .update = [](const Job&) {}});
  for (int i = 0; i < kJobs; ++i) {
    std::ignore =
        board.start({.kind = "test"}, [](const JobControl&, const Job& job) { return job.id; });
  }
  EXPECT_TRUE(eventually([&] { return events.last_seq() == std::uint64_t{3} * kJobs; }));
  std::map<std::int64_t, std::vector<std::string>> types;
  for (const EventPtr& event : events.since(0, {}).events) {
    const Json data = Json::parse(event->line)["params"]["data"];
    types[data["job"].get<std::int64_t>()].push_back(data["type"].get<std::string>());
  }
  ASSERT_EQ(types.size(), std::size_t{kJobs});
  for (const auto& [job, told] : types) {
    EXPECT_EQ(told, (std::vector<std::string>{"queued", "started", "done"})) << job;
  }
}

TEST(Jobs, GoingDownCancelsThemAndAnswersThoseWhoWait) {
  Gate gate;
  RunningService running;
  const Job job = running.service().jobs().start({.kind = "test"}, gate.work());
  ASSERT_TRUE(gate.wait_until_running());
  LineClient client = running.client();
  client.send(
      R"({"jsonrpc":"2.0","id":1,"method":"job.wait","params":{"job":)" +
      std::to_string(job.id) + "}}\n");
  client.send(R"({"jsonrpc":"2.0","id":2,"method":"shutdown"})"
              "\n");
  Json waited;
  for (int i = 0; i < 2; ++i) {
    Json reply = client.read();
    if (reply["id"] == 1) waited = std::move(reply);
  }
  EXPECT_EQ(waited["result"]["state"], "cancelled");
  running.stop();
  EXPECT_THROW(
      static_cast<void>(running.service().jobs().start({.kind = "test"}, gate.work())), Error);
}

TEST(Jobs, TooManyWaitingRequestsOfOneConnectionAreRefused) {
  Gate gate;
  RunningService running;
  const Job job = running.service().jobs().start({.kind = "test"}, gate.work());
  LineClient client = running.client();
  std::string lines;
  for (int id = 1; id <= 33; ++id) {
    lines +=
        Json{
            {"jsonrpc", "2.0"},
            {"id", id},
            {"method", "job.wait"},
            {"params", {{"job", job.id}}}}
            .dump() +
        "\n";
  }
  client.send(lines);
  const Json refused = client.read();
  EXPECT_EQ(refused["id"], 33);
  EXPECT_EQ(error_code_of(refused), "too_many_requests");
  gate.open();
  for (int i = 0; i < 32; ++i) EXPECT_EQ(client.read()["result"]["state"], "done");
}

}  // namespace
}  // namespace sixdial::service
