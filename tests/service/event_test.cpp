// Numbered events: replayed after a reconnection, bounded for a slow client, said when left
// out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/socket/outbox.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::service {
namespace {

using testing::eventually;
using testing::LineClient;
using testing::RunningService;

Json pop_json(Outbox& outbox) {
  const auto line = outbox.pop();
  return line ? Json::parse(*line) : Json(nullptr);
}

EventPtr event(std::uint64_t seq, const std::string& topic) {
  return std::make_shared<const Event>(
      Event{seq, topic, Json{{"params", {{"seq", seq}, {"topic", topic}}}}.dump()});
}

TEST(Outbox, GivesAnswersFirstThenEventsInOrder) {
  Outbox outbox;
  outbox.push_event(event(1, "job"));
  outbox.push_event(event(2, "live"));
  outbox.push_event(event(3, "job"));
  outbox.push_answer("{\"id\":1}");
  EXPECT_EQ(pop_json(outbox)["id"], 1);
  for (int seq = 1; seq <= 3; ++seq) EXPECT_EQ(pop_json(outbox)["params"]["seq"], seq);
  EXPECT_TRUE(outbox.empty());
  EXPECT_FALSE(outbox.pop().has_value());
}

TEST(Outbox, KeepsTheNewestLiveReadingAndSaysHowManyWereLeftOut) {
  Outbox outbox;
  for (std::uint64_t seq = 1; seq <= 10; ++seq) outbox.push_event(event(seq, "live"));
  const Json gap = pop_json(outbox);
  EXPECT_EQ(gap["method"], "events.gap");
  EXPECT_EQ(
      gap["params"], Json({{"from_seq", 1}, {"to_seq", 9}, {"count", 9}, {"live", true}}));
  EXPECT_EQ(pop_json(outbox)["params"]["seq"], 10);
  EXPECT_TRUE(outbox.empty());
}

TEST(Outbox, DropsTheOldestEventsBeyondItsBoundAndSaysWhich) {
  Outbox outbox(4);
  for (std::uint64_t seq = 1; seq <= 10; ++seq) outbox.push_event(event(seq, "job"));
  EXPECT_EQ(
      pop_json(outbox)["params"],
      Json({{"from_seq", 1}, {"to_seq", 6}, {"count", 6}, {"live", false}}));
  for (int seq = 7; seq <= 10; ++seq) EXPECT_EQ(pop_json(outbox)["params"]["seq"], seq);
  EXPECT_TRUE(outbox.empty());
}

TEST(EventHub, ReplaysWhatIsKeptAndSaysWhatIsNot) {
  EventHub hub(5);
  for (int i = 0; i < 8; ++i) hub.publish("job", {{"i", i}});
  hub.publish("live", {{"i", 8}});
  const Replay replay = hub.since(1, {});
  EXPECT_EQ(replay.lost_from, 2U);
  EXPECT_EQ(replay.lost_to, 3U);
  EXPECT_EQ(replay.last_seq, 9U);
  ASSERT_EQ(replay.events.size(), 5U);
  EXPECT_EQ(replay.events.front()->seq, 4U);
  EXPECT_EQ(hub.since(8, {}).events.size(), 0U);
  EXPECT_EQ(hub.since(0, {"sample"}).events.size(), 0U);
}

TEST(EventHub, AnEventTooLargeForALineIsSentWithoutItsData) {
  EventHub hub;
  hub.publish("job", {{"type", "big"}, {"text", std::string(100'000, 'x')}});
  const auto replay = hub.since(0, {});
  ASSERT_EQ(replay.events.size(), 1U);
  EXPECT_LT(replay.events[0]->line.size(), std::size_t{1000});
  EXPECT_EQ(Json::parse(replay.events[0]->line)["params"]["data"]["type"], "big");
}

TEST(Events, AClientThatComesBackGoesOnWhereItWas) {
  RunningService running;
  EventHub& hub = running.service().events();
  std::uint64_t last = 0;
  {
    LineClient client = running.client();
    EXPECT_EQ(client.call("events.subscribe", {{"topics", {"sample"}}})["result"]["lost"], 0);
    for (int i = 0; i < 3; ++i) hub.publish("sample", {{"i", i}});
    hub.publish("job", {{"i", -1}});  // another topic
    for (int i = 0; i < 3; ++i) {
      const Json note = client.read();
      EXPECT_EQ(note["method"], "events.event");
      EXPECT_EQ(note["params"]["data"]["i"], i);
      last = note["params"]["seq"];
    }
  }
  for (int i = 3; i < 6; ++i) hub.publish("sample", {{"i", i}});
  LineClient client = running.client();
  const Json reply =
      client.call("events.subscribe", {{"topics", {"sample"}}, {"since_seq", last}});
  EXPECT_EQ(reply["result"]["replayed"], 3);
  hub.publish("sample", {{"i", 6}});
  for (int i = 3; i < 7; ++i) EXPECT_EQ(client.read()["params"]["data"]["i"], i);
}

TEST(Events, EachSubscriberGetsEachEventOnceInOrder) {
  RunningService running;
  constexpr int kEvents = 500;
  LineClient client = running.client();
  client.call("events.subscribe");
  std::thread publisher([&] {
    for (int i = 0; i < kEvents; ++i) running.service().events().publish("sample", {{"i", i}});
  });
  LineClient late = running.client();
  late.call("events.subscribe", {{"since_seq", 0}});
  for (LineClient* each : {&client, &late}) {
    for (int i = 0; i < kEvents; ++i) {
      const Json note = each->read();
      ASSERT_EQ(note["method"], "events.event") << note;
      ASSERT_EQ(note["params"]["data"]["i"], i);
    }
  }
  publisher.join();
}

TEST(Events, AnUnknownTopicIsRefusedWithTheChoice) {
  RunningService running;
  LineClient client = running.client();
  const Json reply = client.call("events.subscribe", {{"topics", {"samples"}}});
  EXPECT_EQ(testing::error_code_of(reply), "invalid_params");
  EXPECT_THAT(
      reply["error"]["data"]["hint"].get<std::string>(), ::testing::HasSubstr("sample"));
}

TEST(Events, AClientThatDoesNotReadIsDroppedAndHoldsUpNobody) {
  RunningService running(
      {.slow_client = std::chrono::milliseconds(200), .socket_buffer_bytes = 4096});
  LineClient slow = running.client();
  slow.call("events.subscribe");
  LineClient quick = running.client();
  quick.call("hello");
  ASSERT_EQ(running.service().stopping(), false);
  const std::string text(1000, 'x');
  for (int i = 0; i < 3000; ++i) {
    running.service().events().publish("sample", {{"i", i}, {"text", text}});
  }
  // While the slow one is stuck, the other is answered.
  EXPECT_EQ(quick.call("hello")["result"]["service"], "sixdiald");
  // The slow one finds what was sent before, perhaps a gap, and then the end.
  EXPECT_TRUE(eventually([&] { return !slow.send("\n"); }));  // the connection is closed
  int lines = 0;
  while (slow.read_line()) ++lines;
  EXPECT_LT(lines, 3000);
}

TEST(Events, AReaderThatFellBehindIsToldWhatWasLeftOut) {
  // Slow as this client is, it is not sent away: it reads nothing until all is published.
  RunningService running({.slow_client = testing::kPatience, .socket_buffer_bytes = 4096});
  LineClient client = running.client();
  client.call("events.subscribe");
  const std::string text(1000, 'x');
  constexpr int kEvents = 5000;
  for (int i = 0; i < kEvents; ++i) {
    running.service().events().publish("sample", {{"i", i}, {"text", text}});
  }
  running.client().call("hello");  // the loop has been through all of them
  std::uint64_t accounted = 0;
  int gaps = 0;
  while (accounted < kEvents) {
    const Json note = client.read();
    if (note["method"] == "events.gap") {
      ++gaps;
      EXPECT_EQ(note["params"]["from_seq"].get<std::uint64_t>(), accounted + 1);
      accounted += note["params"]["count"].get<std::uint64_t>();
    } else {
      EXPECT_EQ(note["params"]["seq"].get<std::uint64_t>(), ++accounted);
    }
  }
  EXPECT_EQ(accounted, std::uint64_t{kEvents});
  EXPECT_GE(gaps, 1);
}

}  // namespace
}  // namespace sixdial::service
