// The collector's screen in a terminal: large digits, states in words, never wider than it is.
#include "cli/collect_screen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <sstream>

namespace sixdial::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(CollectKeys, WhatStopsLeavesOutOrTakesBackIsAskedFirst) {
  for (const auto& [key, method] :
       {std::pair{'q', "collect.stop"}, {'s', "collect.skip"}, {'r', "collect.retake"}}) {
    CollectKeys keys;
    const auto first = keys.press(key);
    EXPECT_EQ(first.method, nullptr) << key;
    EXPECT_THAT(first.question, HasSubstr("y: yes"));
    EXPECT_EQ(keys.press(0).method, nullptr);  // nobody has answered yet
    EXPECT_STREQ(keys.press('y').method, method);
    EXPECT_EQ(keys.press('y').method, nullptr);  // answered once
    EXPECT_FALSE(keys.press(key).question.empty());
    const auto no = keys.press(key);  // the same letter twice is no yes
    EXPECT_TRUE(no.refused);
    EXPECT_EQ(no.method, nullptr);
  }
}

TEST(CollectKeys, WhatCanBeTakenBackIsDoneAtOnce) {
  for (const auto& [key, method] :
       {std::pair{'p', "collect.pause"},
        {'c', "collect.resume"},
        {'a', "collect.accept"},
        {'m', "collect.moved"}}) {
    CollectKeys keys;
    EXPECT_STREQ(keys.press(key).method, method);
  }
  CollectKeys keys;
  EXPECT_EQ(keys.press('?').method, nullptr);
}

Json dial(const Json& value_mm, const char* state, const char* reason = "") {
  return {{"value_mm", value_mm}, {"quality", "good"}, {"reason", reason}, {"state", state}};
}

Json six_dials() {
  return {
      {"dials",
       {{"A", dial(10.490, "ok")},
        {"B", dial(2.345, "settling")},
        {"C", dial(nullptr, "free", "no contact")},
        {"D", dial(nullptr, "lost", "timeout")},
        {"E", dial(nullptr, "stale", "stale")},
        {"F", dial(-1.678, "ok")}}},
      {"settle", {{"spread_mm", 0.002}, {"limit_mm", 0.012}, {"settled", true}}},
      {"pose",
       {{"x_mm", 28.0}, {"y_mm", 48.5}, {"gamma_rad", 0.1}, {"dials", {"A", "B", "F"}}}}};
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(CollectScreen, ShowsEveryDialWithItsStateInWords) {
  for (const std::size_t width : {200U, 79U, 76U}) {
    const std::string text = joined(dial_lines(six_dials(), width));
    for (const char* id : {"A", "B", "C", "D", "E", "F"}) EXPECT_THAT(text, HasSubstr(id));
    for (const char* word : {"ok", "settling", "no contact", "LOST: timeout", "STALE"}) {
      EXPECT_THAT(text, HasSubstr(word)) << width;
    }
    EXPECT_THAT(text, HasSubstr("x 28.000  y 48.500 mm  gamma 5.730 deg")) << width;
    EXPECT_THAT(text, HasSubstr("settled: 0.002 of 0.012 mm")) << width;
  }
}

TEST(CollectScreen, ASampleThatLooksUnusualSaysSoAndWhatToDo) {
  Json sample{
      {"set", "G1"},
      {"point", 18},
      {"repeat", 0},
      {"position_mm", {20.491, 29.754}},
      {"dials", {{"A", {{"value_mm", 5.225}}}}},
      {"remarks", Json::array()},
      {"doubt", ""}};
  EXPECT_EQ(sample_line(sample), "G1 18.0  x 20.491  y 29.754 mm  A 5.225");
  sample["doubt"] = "6 times as far off as usual";
  EXPECT_THAT(
      sample_line(sample), HasSubstr("; 6 times as far off as usual: r measures it again"));
}

TEST(CollectScreen, DrawsLargeDigitsWhereTheyFit) {
  const Json one{
      {"dials", {{"A", dial(10.490, "ok")}}},
      {"settle", {{"spread_mm", nullptr}}},
      {"pose", nullptr}};
  const auto lines = dial_lines(one, 100);
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_THAT(lines[0], testing::StartsWith("       _         _   _  "));
  EXPECT_THAT(lines[1], testing::StartsWith("    | | |   |_| |_| | | "));
  EXPECT_THAT(lines[2], testing::StartsWith("    | |_| .   |  _| |_| "));
  EXPECT_THAT(lines[4], HasSubstr("fewer than three dials"));
}

TEST(CollectScreen, IsNeverWiderThanTheTerminal) {
  for (std::size_t width = 1; width < 120; ++width) {
    for (const std::string& line : dial_lines(six_dials(), width))
      EXPECT_LE(line.size(), width);
  }
}

TEST(CollectScreen, OffATerminalThereAreNoLiveReadingsAndNoEscapes) {
  std::ostringstream out, err;
  const Console plain{.out = out, .err = err};
  EXPECT_THAT(screen_topics(plain), Not(testing::Contains("live")));
  Screen screen(plain);
  screen.show_dials(six_dials());
  screen.end();
  EXPECT_THAT(err.str() + out.str(), Not(HasSubstr("\x1b")));
  std::ostringstream screen_out, screen_err;
  const Console terminal{.out = screen_out, .err = screen_err, .terminal = true};
  EXPECT_THAT(screen_topics(terminal), testing::Contains("live"));
  Screen live(terminal);
  live.show_dials(six_dials());
  live.show_dials(six_dials());
  live.end();
  EXPECT_THAT(screen_err.str(), HasSubstr("\x1b["));  // taken away before it is drawn again
  EXPECT_THAT(screen_err.str(), HasSubstr("LOST"));
}

// What the service tells of one stored sample and of the estimate after it.
Json sample_event(int point, const std::string& doubt) {
  return {
      {"set", "G1"},
      {"point", point},
      {"repeat", 0},
      {"position_mm", {20.491, 29.754}},
      {"dials", {{"A", {{"value_mm", 5.225}}}}},
      {"remarks", Json::array()},
      {"doubt", doubt}};
}

Json estimate_event(int samples, int total) {
  return {
      {"type", "estimate"},
      {"stage", "storing"},
      {"message", ""},
      {"done", samples},
      {"total", total},
      {"eta_s", nullptr},
      {"point", nullptr},
      {"estimate",
       {{"samples", samples},
        {"set_aside", 0},
        {"noise_times", 1.0},
        {"position_sd_mm", {{"mean", 0.01}, {"max", 0.02}, {"worst_mm", {30.0, 40.0}}}},
        {"condition", 40.0},
        {"undetermined", Json::array()},
        {"parameters", Json::array()},
        {"last_times_usual", nullptr},
        {"last_unusual", false}}}};
}

TEST(CollectScreen, OffATerminalALineTellsOfEachTenthAndOfASampleInDoubt) {
  std::ostringstream out, err;
  const Console plain{.out = out, .err = err};
  Screen screen(plain);
  constexpr int kSamples = 150;
  for (int i = 0; i < kSamples; ++i) {
    screen.show_sample(sample_event(i, i == 42 ? "6 times as far off as usual" : ""));
    screen.show_state(estimate_event(i + 1, kSamples));
  }
  screen.end();
  const std::string text = err.str();
  EXPECT_EQ(std::ranges::count(text, '\n'), 12) << text;
  EXPECT_THAT(
      text,
      HasSubstr(
          "collecting 75/150  estimate after 75 samples: positions are known to 0.0200 mm"));
  EXPECT_THAT(text, HasSubstr("collecting 150/150  estimate after 150 samples"));
  EXPECT_THAT(text, HasSubstr("G1 42.0  x 20.491"));
  EXPECT_TRUE(out.str().empty());
}

/// Keeps what is written and counts the calls: on std::cerr each is one write().
class CountingBuffer : public std::streambuf {
 public:
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] int writes() const { return writes_; }

 private:
  std::streamsize xsputn(const char* bytes, std::streamsize size) override {
    ++writes_;
    text_.append(bytes, static_cast<std::size_t>(size));
    return size;
  }
  int_type overflow(int_type letter) override {
    ++writes_;
    text_ += traits_type::to_char_type(letter);
    return letter;
  }
  std::string text_;
  int writes_ = 0;
};

TEST(CollectScreen, EachChangeIsOneWriteOfAWholeScreen) {
  CountingBuffer buffer;
  std::ostream err(&buffer);
  std::ostringstream out;
  const Console terminal{.out = out, .err = err, .terminal = true};
  Screen screen(terminal);
  screen.show_dials(six_dials());
  screen.show_state(estimate_event(1, 100));
  const auto expect_one_write = [&](const char* what, const std::function<void()>& change) {
    const int writes = buffer.writes();
    const std::size_t bytes = buffer.text().size();
    change();
    EXPECT_EQ(buffer.writes() - writes, 1) << what;
    const std::string newest = buffer.text().substr(bytes);
    EXPECT_THAT(newest, testing::StartsWith("\x1b[?2026h")) << what;
    EXPECT_THAT(newest, testing::EndsWith("\x1b[?2026l")) << what;
    for (const char* part : {"10.49", "LOST", "estimate after", "collecting "}) {
      EXPECT_THAT(newest, HasSubstr(part)) << what;
    }
  };
  expect_one_write("dials over dials", [&] { screen.show_dials(six_dials()); });
  expect_one_write("an estimate", [&] { screen.show_state(estimate_event(2, 100)); });
  expect_one_write("a sample", [&] { screen.show_sample(sample_event(1, "")); });
  expect_one_write("a note", [&] { screen.note("collect.pause"); });
}

}  // namespace
}  // namespace sixdial::cli
