// Never a silent blank: each trouble on the way to the service, and each state with nothing to
// show, is a sentence with what to do. And whatever another client does is seen at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "tests/live/shown_session.h"

namespace sixdial::service {
namespace {

using testing::BrowserPage;
using ::testing::HasSubstr;
using testing::RunningService;
using testing::ShownSession;

std::string text_of(BrowserPage& browser, const std::string& id) {
  return browser.run("document.getElementById('" + id + "').innerText").get<std::string>();
}

void wait_for_words(BrowserPage& browser, const std::string& id, const std::string& words) {
  browser.until(
      "document.getElementById('" + id + "').innerText.includes(" + Json(words).dump() + ")");
}

TEST(LivePageTrouble, AKilledServiceIsSaidAndOneStartedAnewIsTakenUpAgain) {
  testing::TempDirectory directory;
  const auto database = directory.path() / "sixdial.db";
  auto running =
      std::make_unique<RunningService>(ServerOptions{}, ServiceOptions{.database = database});
  const std::string token(32, 'b');
  auto page = std::make_unique<LivePage>(
      LivePageOptions{.socket_path = running->socket_path(), .port = 0, .token = token});
  const std::uint16_t port = page->port();
  BrowserPage browser;
  browser.open(page->url());
  wait_for_words(browser, "notice", "There is no session yet. Make one");
  page.reset();  // as one process that ends
  running.reset();
  wait_for_words(browser, "lost", "Connection to the service lost");
  wait_for_words(browser, "lost", "Look whether sixdiald runs: sixdial doctor");
  EXPECT_EQ(text_of(browser, "link"), "✕ not connected");
  EXPECT_EQ(
      browser.run("document.querySelector('[data-do=start]').title"),
      "Not now: not connected.");

  // Back, but with another token: this address is no longer its own, and the page says so.
  running =
      std::make_unique<RunningService>(ServerOptions{}, ServiceOptions{.database = database});
  page = std::make_unique<LivePage>(LivePageOptions{
      .socket_path = running->socket_path(), .port = port, .token = std::string(32, 'c')});
  wait_for_words(browser, "lost", "Open the new address: sixdiald printed it when it began");
  page.reset();

  // Back with this token: the page goes on by itself.
  page = std::make_unique<LivePage>(
      LivePageOptions{.socket_path = running->socket_path(), .port = port, .token = token});
  browser.until("document.getElementById('lost').hidden");
  wait_for_words(browser, "events", "the service was started anew");
  wait_for_words(browser, "notice", "There is no session yet. Make one");

  // Opened with a wrong token: no page at all, but words.
  browser.open("http://127.0.0.1:" + std::to_string(port) + "/wrong/");
  EXPECT_THAT(
      browser.run("document.body.innerText").get<std::string>(),
      ::testing::AllOf(HasSubstr("Wrong token"), HasSubstr("printed when sixdiald began")));
}

TEST(LivePageTrouble, APageWhoseServiceDoesNotAnswerSaysSo) {
  testing::TempDirectory directory;
  const LivePage page({.socket_path = directory.path() / "none", .port = 0});
  BrowserPage browser;
  browser.open(page.url());
  wait_for_words(browser, "lost", "the service behind it does not take the connection");
}

TEST(LivePageTrouble, AFinishedPlanAndAFailedStoreSayWhatToDo) {
  ShownSession shown;
  shown.open();
  const auto collect = [&](Json more) {
    Json data{{"session", "monday"},     {"done", 32},         {"total", 32},
              {"stage", "finished"},     {"message", ""},      {"eta_s", nullptr},
              {"point", nullptr},        {"move_to", nullptr}, {"error", nullptr},
              {"ended_because", nullptr}};
    data.update(more);
    shown.running().service().events().publish("collect", data);
  };
  collect({{"type", "done"}, {"state", "done"}});
  wait_for_words(shown.browser(), "notice", "The plan is finished");
  wait_for_words(shown.browser(), "notice", "Next: Calibrate (k)");
  collect(
      {{"type", "failed"},
       {"state", "failed"},
       {"error",
        {{"message", "database or disk is full"}, {"data", {{"hint", "make room"}}}}}});
  wait_for_words(
      shown.browser(), "notice",
      "The collection failed: database or disk is full. make room. What was stored is kept.");
  EXPECT_EQ(text_of(shown.browser(), "state"), "✕ FAILED");
}

TEST(LivePageTrouble, ADatabaseThatRefusesASampleStopsTheCollectionInWords) {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.clock_speed = 5.0;
  mock_devices::MockRig mock(options);
  mock.start();
  testing::TempDirectory directory;
  const std::string database = (directory.path() / "sixdial.db").string();
  RunningService running(
      {}, {.database = database,
           .clock_speed = options.clock_speed,
           .clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()))});
  running.service().store().create_session(
      "monday", session::write_rig(mock.connected_rig("modbus-tcp")), {});
  const LivePage page({.socket_path = running.socket_path(), .port = 0});
  BrowserPage browser;
  browser.open(page.url());
  browser.until(
      "document.querySelector('[data-do=start]').getAttribute('aria-disabled') === 'false'");
  browser.keys("g");
  browser.until("document.querySelectorAll('#map [data-mark=done]').length >= 2");
  // As a full disk would: the store takes no further sample.
  const std::string refuse =
      "python3 -c \"import sqlite3; d = sqlite3.connect('" + database +
      "', timeout=30); d.execute('CREATE TRIGGER full BEFORE INSERT ON samples BEGIN SELECT "
      "RAISE(ABORT, \\\"no room\\\"); END'); d.commit()\"";
  ASSERT_EQ(std::system(refuse.c_str()), 0);
  wait_for_words(browser, "notice", "The collection failed");
  EXPECT_THAT(
      text_of(browser, "notice"),
      ::testing::AllOf(HasSubstr("no room"), HasSubstr("What was stored is kept")));
  EXPECT_EQ(text_of(browser, "state"), "✕ FAILED");
}

TEST(LivePageClients, WhatAnotherClientDoesIsSeenAtOnce) {
  ShownSession shown;
  shown.open();
  auto other = shown.running().client();
  const auto done = [](int count) {
    return "document.querySelectorAll('#map [data-mark=done]').length === " +
           std::to_string(count);
  };
  ASSERT_TRUE(other.call("session.undo", {{"session", "monday"}}).contains("result"));
  shown.browser().until(done(ShownSession::kMeasured - 1));
  wait_for_words(shown.browser(), "events", "the last sample of monday was withdrawn");
  wait_for_words(shown.browser(), "progress", "19 of 32 points measured");

  const Json made = other.call(
      "session.create",
      {{"name", "tuesday"}, {"rig_toml", session::write_rig(geometry::default_rig())}});
  ASSERT_TRUE(made.contains("result")) << made;
  shown.browser().until(
      "[...document.getElementById('session').options].some(o => o.value === 'tuesday')");
  EXPECT_EQ(shown.browser().run("document.getElementById('session').value"), "monday");

  const Json job = other.call(
      "calibrate.start", {{"session", "monday"},
                          {"particles", 20},
                          {"qpso1_iterations", 20},
                          {"qpso2_iterations", 20},
                          {"anfis_epochs", 5}});
  ASSERT_TRUE(job.contains("result")) << job;
  shown.browser().until(
      "/calibration done/.test(document.getElementById('job-words').textContent)");
  shown.browser().until(
      "document.querySelector('[data-do=report]').getAttribute('aria-disabled') === 'false'");
  // A sample less, and the report would be of other data: the button says so.
  ASSERT_TRUE(other.call("session.undo", {{"session", "monday"}}).contains("result"));
  shown.browser().until(
      "document.querySelector('[data-do=report]').title === "
      "'Not now: samples have changed since: calibrate or diagnose again.'");
  EXPECT_TRUE(shown.browser().complaints().empty());
}

TEST(LivePageClients, TwoPagesShowTheSame) {
  ShownSession shown;
  shown.open();
  BrowserPage second;
  second.open(shown.page().url());
  second.until("document.querySelectorAll('#map [data-mark=done]').length === 20");
  second.keys("u");
  second.until("!document.getElementById('ask').hidden");
  second.keys("y");
  shown.browser().until("document.querySelectorAll('#map [data-mark=done]').length === 19");
  second.until("document.querySelectorAll('#map [data-mark=done]').length === 19");
  wait_for_words(second, "progress", "19 of 32 points measured");
  wait_for_words(shown.browser(), "progress", "19 of 32 points measured");
}

}  // namespace
}  // namespace sixdial::service
