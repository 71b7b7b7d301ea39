// The live page as eyes and fingers meet it: sizes of screens, contrast, keyboard, words for
// what cannot be done. In Chromium, with a rig that is played.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "tests/live/shown_session.h"

namespace sixdial::service {
namespace {

using ::testing::HasSubstr;
using testing::ShownSession;

struct Size {
  int wide, high;
  bool touch;
};
constexpr Size kSizes[]{
    {1280, 860, false}, {1024, 768, true}, {768, 1024, true}, {390, 844, true}};
constexpr double kLeastTarget_px = 44.0;  // of a finger, as WCAG 2.5.5
constexpr double kLeastContrast = 4.5;    // of text, as WCAG 1.4.3
// Two metres off a letter wants 8 mm (4 mrad); a ten inch tablet has 0.207 mm a CSS pixel at
// 1024 of them, and digits are 0.73 of the font's size.
constexpr double kReadableOnATablet_px = 8.0 / 0.207 / 0.73;

std::string dump(const Json& list) {
  return list.is_array() && list.empty() ? "" : list.dump(1);
}

TEST(LivePageLayout, FitsEveryScreenWithTargetsForFingersAndNothingCut) {
  ShownSession shown;
  shown.open();
  for (const Size& size : kSizes) {
    shown.browser().tell({{"size", {size.wide, size.high}}, {"touch", size.touch}});
    shown.play_middle();
    shown.browser().until("document.querySelector('[data-dial=C]').dataset.state === 'lost'");
    EXPECT_EQ(dump(shown.browser().run("look.overflow()")), "") << size.wide;
    EXPECT_EQ(dump(shown.browser().run("look.cut()")), "") << size.wide;
    EXPECT_EQ(
        dump(shown.browser().run("look.targets(" + std::to_string(kLeastTarget_px) + ")")), "")
        << size.wide;
    EXPECT_EQ(dump(shown.browser().run("look.unexplained()")), "") << size.wide;
    const double font_px = shown.browser()
                               .run(
                                   "parseFloat(getComputedStyle(document.querySelector('.dial "
                                   ".value')).fontSize)")
                               .get<double>();
    const bool tablet = size.touch && size.wide >= 1024;
    EXPECT_GE(font_px, tablet ? kReadableOnATablet_px : 30.0) << size.wide;
    // The buttons come before the map where one stands below the other.
    EXPECT_TRUE(
        shown.browser().run("document.getElementById('control').getBoundingClientRect().top <= "
                            "document.getElementById('plan').getBoundingClientRect().top + 700 "
                            "* (innerWidth > 1200)"))
        << size.wide;
    // SIXDIAL_SHOTS=FOLDER keeps what was looked at.
    if (const char* folder = std::getenv("SIXDIAL_SHOTS")) {
      shown.browser().tell(
          {{"shot", std::string(folder) + "/" + std::to_string(size.wide) + ".png"}});
    }
  }
}

TEST(LivePageLayout, TextStandsOutInLightAndDarkConnectedAndNot) {
  ShownSession shown;
  shown.open();
  for (const bool dark : {false, true}) {
    shown.browser().tell({{"size", {1024, 768}}, {"dark", dark}});
    shown.play_middle();
    shown.browser().until("document.querySelector('[data-dial=C]').dataset.state === 'lost'");
    EXPECT_EQ(
        dump(shown.browser().run("look.contrast(" + std::to_string(kLeastContrast) + ")")), "")
        << "dark: " << dark;
  }
  shown.close_page();
  shown.browser().until("!document.getElementById('lost').hidden");
  EXPECT_EQ(
      dump(shown.browser().run("look.contrast(" + std::to_string(kLeastContrast) + ")")), "");
}

TEST(LivePageLayout, StatesAreToldBySymbolAndWordBesidesColour) {
  ShownSession shown;
  shown.open();
  shown.play_middle();
  shown.browser().until("document.querySelector('[data-dial=C]').dataset.state === 'lost'");
  const auto words = shown.browser()
                         .run(
                             "[...document.querySelectorAll('.dial .top span')].map(s => "
                             "s.textContent)")
                         .get<std::vector<std::string>>();
  ASSERT_EQ(words.size(), 6U);
  EXPECT_EQ(
      words, (std::vector<std::string>{
                 "✓ ok", "≈ settling", "✕ LOST", "✓ ok", "◷ STALE", "○ no contact"}));
  // Marks of the map differ in shape: the path or circle that draws each is another one.
  const auto shapes = shown.browser()
                          .run(
                              "[...document.querySelectorAll('#legend svg g')].map(g => "
                              "[...g.children].map(c => c.tagName + (c.getAttribute('d') || "
                              "c.getAttribute('r')) + getComputedStyle(c).fill).join())")
                          .get<std::vector<std::string>>();
  EXPECT_EQ(std::set<std::string>(shapes.begin(), shapes.end()).size(), shapes.size());
  EXPECT_EQ(shapes.size(), 5U);
}

TEST(LivePageLayout, EveryControlIsReachedByTabWithAFocusThatIsSeen) {
  ShownSession shown;
  shown.open();
  shown.play_middle();
  shown.browser().until("document.querySelector('[data-do=accept]').hidden === false");
  const auto wanted = shown.browser()
                          .run(
                              "[...document.querySelectorAll('button,select')].filter(e => "
                              "e.getBoundingClientRect().width > 0).map(e => e.dataset.do || "
                              "e.id)")
                          .get<std::vector<std::string>>();
  std::set<std::string> reached;
  for (std::size_t i = 0; i < wanted.size() + 3; ++i) {
    shown.browser().tell({{"press", "Tab"}});
    const Json at = shown.browser().run(
        "(() => { const e = document.activeElement, s = getComputedStyle(e); return "
        "[e.dataset.do "
        "|| e.id, s.outlineStyle, parseFloat(s.outlineWidth)]; })()");
    reached.insert(at[0].get<std::string>());
    if (at[0] == "") continue;  // round the page's end
    EXPECT_EQ(at[1], "solid") << at[0];
    EXPECT_GE(at[2].get<double>(), 3.0) << at[0];
  }
  for (const std::string& each : wanted) EXPECT_TRUE(reached.contains(each)) << each;
}

TEST(LivePageLayout, WhatCannotBeDoneSaysWhyAndKeysAreListed) {
  ShownSession shown;
  shown.open();
  shown.browser().until(
      "document.querySelector('[data-do=report]').title === 'Not now: calibrate or diagnose "
      "first.'");
  shown.browser().keys("o");
  shown.browser().until(
      "document.getElementById('notice').textContent.includes('calibrate or diagnose first')");
  shown.browser().keys("p");
  shown.browser().until(
      "document.getElementById('notice').textContent.includes('nothing is being collected')");
  // Every key of a command stands in the list and on its button.
  EXPECT_EQ(
      shown.browser().run(
          "[...document.querySelectorAll('button[data-do]')].filter(b => "
          "![...document.querySelectorAll('#keys kbd')].some(k => k.textContent === "
          "b.querySelector('kbd').textContent)).length"),
      0);
  EXPECT_EQ(
      shown.browser().run(
          "[...document.querySelectorAll('#keys li')].map(l => l.textContent.trim()).join()"),
      "g Start,p Pause,c Continue,r Retake,s Skip,a Accept,m Moved,u Undo last,q Stop "
      "collecting,h Stop robot,k Calibrate,d Diagnose,x Cancel,o Open report");
  // What changes is read out: state, notice, lost connection.
  for (const char* id : {"state", "notice"}) {
    EXPECT_EQ(
        shown.browser().run(
            std::string("document.getElementById('") + id + "').getAttribute('role')"),
        "status");
  }
  EXPECT_EQ(
      shown.browser().run("document.getElementById('lost').getAttribute('role')"), "alert");
}

TEST(LivePageLayout, TheSettleBarShowsTheServicesValueAgainstItsLimit) {
  ShownSession shown;
  shown.open();
  shown.play_middle();
  shown.browser().until("!document.getElementById('settle-bar').hidden");
  EXPECT_THAT(
      shown.browser()
          .run("document.getElementById('settle-words').textContent")
          .get<std::string>(),
      HasSubstr("✓ settled: dial B moves within 0.009 mm, 0.012 allowed"));
  EXPECT_EQ(
      shown.browser().run(
          "document.getElementById('settle-bar').firstElementChild.style.width"),
      "37.5%");  // half of the bar is the limit
  EXPECT_EQ(
      shown.browser().run("document.getElementById('progress').textContent"),
      "20 of 32 points · 65 s left · paused at G1 point 20");
}

}  // namespace
}  // namespace sixdial::service
