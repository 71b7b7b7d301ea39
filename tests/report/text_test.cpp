// Numbers as people read them, escapes for what people typed.
#include "report/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

namespace sixdial::report {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Text, EscapesEveryCharacterThatMarkupKnows) {
  EXPECT_EQ(
      escape_html(R"(<a href="x" id='y'>&</a>)"),
      "&lt;a href=&quot;x&quot; id=&#39;y&#39;&gt;&amp;&lt;/a&gt;");
}

TEST(Text, ReplacesBytesThatAreNoUtf8AndControls) {
  EXPECT_EQ(valid_utf8("\xFF"), "\uFFFD");
  EXPECT_EQ(
      valid_utf8("a\xC0\xAF"
                 "b"),
      "a\uFFFD\uFFFDb");                                        // overlong '/'
  EXPECT_EQ(valid_utf8("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(valid_utf8(std::string("a\0b\x1B", 4)), "a\uFFFDb\uFFFD");
  EXPECT_EQ(valid_utf8("\xE2\x82"), "\uFFFD\uFFFD");  // cut off
  EXPECT_EQ(valid_utf8("Łódź 北京 🤖\ttab"), "Łódź 北京 🤖\ttab");
}

TEST(Text, AnyBytesBecomeValidJson) {
  std::mt19937 random{7};
  std::uniform_int_distribution<int> byte{0, 255};
  int tried = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text;
    for (int k = 0; k < 12; ++k) text += static_cast<char>(byte(random));
    const std::string clean = valid_utf8(text);
    ASSERT_EQ(valid_utf8(clean), clean);
    ASSERT_NO_THROW((void)nlohmann::json(clean).dump());  // throws on invalid UTF-8
    ++tried;
  }
  EXPECT_EQ(tried, 5000);
}

TEST(Text, ScriptsCannotBeClosedFromInside) {
  const std::string json = escape_script(nlohmann::json("</script><!-- &").dump());
  EXPECT_EQ(json.find_first_of("<>&"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(json).get<std::string>(), "</script><!-- &");
}

TEST(Text, CsvFieldsAreQuotedWhereTheyMust) {
  EXPECT_EQ(csv_field("plain"), "plain");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"so\"\n"), "\"say \"\"so\"\"\n\"");
}

TEST(Text, FixedNeverShowsANegativeZero) {
  EXPECT_EQ(fixed(-0.00004, 3), "0.000");
  EXPECT_EQ(fixed(-0.0006, 3), "-0.001");
  EXPECT_EQ(fixed(59.742, 3), "59.742");
  EXPECT_EQ(fixed(kNan, 3), "\u2013");
}

TEST(Text, ExactReadsBackAsTheSameNumber) {
  std::mt19937_64 random{11};
  std::uniform_real_distribution<double> value{-100.0, 100.0};
  for (int i = 0; i < 1000; ++i) {
    const double v = value(random);
    ASSERT_EQ(std::stod(exact(v)), v);
  }
  EXPECT_EQ(exact(kNan), "");
  EXPECT_EQ(exact(-0.0), exact(0.0));
}

TEST(Text, StandardDeviationsGetTwoDigits) {
  EXPECT_EQ(decimals_for(0.0082), 4);
  EXPECT_EQ(decimals_for(0.054), 3);
  EXPECT_EQ(decimals_for(0.0996), 2);  // is 0.10 with two digits
  EXPECT_EQ(decimals_for(0.0), 4);
  EXPECT_EQ(decimals_for(kNan), 4);
}

TEST(Text, LengthsChooseTheirUnit) {
  EXPECT_EQ(length(2.995), "3.00\u00A0mm");
  EXPECT_EQ(length(0.022), "22.0\u00A0\u00B5m");
  EXPECT_EQ(length(0.0031), "3.1\u00A0\u00B5m");
  EXPECT_EQ(length(0.0999), "0.10\u00A0mm");
  EXPECT_EQ(length(0.0), "0 mm");
  EXPECT_EQ(length(kNan), "\u2013");
}

TEST(Text, TimesAreReadable) {
  EXPECT_EQ(readable_time("2026-03-02T08:30:06.976Z"), "2026-03-02 08:30 UTC");
  EXPECT_EQ(readable_time("yesterday"), "yesterday");
}

}  // namespace
}  // namespace sixdial::report
