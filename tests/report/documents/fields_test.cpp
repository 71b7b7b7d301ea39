// One description writes a result and reads it back, and an error names the key.
#include "report/documents/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sixdial::report {

struct FieldsInner {
  std::string word{};
  std::optional<int> count{};
};
struct FieldsSample {
  double size_mm = 0.0;
  std::vector<FieldsInner> list{};
  std::optional<FieldsInner> one{};
  std::optional<bool> later{};
  Eigen::MatrixXd matrix{};
  Eigen::Vector2d point{};
  std::array<double, 3> three{};
  std::vector<std::pair<std::string, double>> by_name{};
  bool up = false;
};

template <class Fields>
void describe_keys(Fields& at, Of<Fields, FieldsInner>& inner) {
  at("word", inner.word);
  at("count", inner.count);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, FieldsSample>& sample) {
  at.constant("kind", "sample");
  at("size_mm", sample.size_mm);
  at("list", sample.list);
  at("one", sample.one);
  at.maybe("later", sample.later);
  at.inner("numbers", [&](auto& numbers) {
    numbers("matrix", sample.matrix);
    numbers("point", sample.point);
    numbers("three", sample.three);
  });
  at("by_name", sample.by_name);
  at.named(
      "assembly", sample.up, [](bool up) { return up ? "up" : "down"; },
      [](std::string_view text) {
        return text == "up"     ? std::optional(true)
               : text == "down" ? std::optional(false)
                                : std::nullopt;
      });
}

namespace {

FieldsSample a_sample() {
  return {
      .size_mm = 0.1,
      .list = {{"a", 1}, {"b", std::nullopt}},
      .one = std::nullopt,
      .later = true,
      .matrix = Eigen::MatrixXd{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}},
      .point = {0.5, -0.5},
      .three = {1.0, 2.0, 3.0},
      .by_name = {{"x", 1.5}},
      .up = true};
}

std::string refused(const Json& json) {
  try {
    (void)read<FieldsSample>(json, "test");
  } catch (const studies::StudyError& error) {
    EXPECT_EQ(error.code(), studies::StudyErrorCode::kBadData);
    return error.what();
  }
  return "";
}

TEST(Fields, WhatIsWrittenIsReadBack) {
  const Json json = write(a_sample());
  const auto again = read<FieldsSample>(Json::parse(json.dump()), "test");
  EXPECT_EQ(write(again), json);
  EXPECT_EQ(again.matrix, a_sample().matrix);
  EXPECT_EQ(again.list[1].count, std::nullopt);
  EXPECT_EQ(json["numbers"]["matrix"][1], (Json{4.0, 5.0, 6.0}));
}

TEST(Fields, ANumberThatIsNotFiniteIsNullAndNullIsNotANumber) {
  FieldsSample sample = a_sample();
  sample.size_mm = std::numeric_limits<double>::infinity();
  const Json json = write(sample);
  EXPECT_TRUE(json["size_mm"].is_null());
  EXPECT_TRUE(std::isnan(read<FieldsSample>(json, "test").size_mm));
}

TEST(Fields, AKeyOfLaterVersionsMayBeMissing) {
  Json json = write(a_sample());
  json.erase("later");
  const auto again = read<FieldsSample>(json, "test");
  EXPECT_EQ(again.later, std::nullopt);
  EXPECT_EQ(write(again), json);
}

TEST(Fields, AnErrorNamesTheKeyThatIsMissingOrWrong) {
  Json json = write(a_sample());
  json["list"][1].erase("word");
  EXPECT_NE(refused(json).find("list[1].word is missing"), std::string::npos) << refused(json);
  json = write(a_sample());
  json["numbers"]["three"] = {1.0, 2.0};
  EXPECT_NE(refused(json).find("numbers.three has 2 entries instead of 3"), std::string::npos);
  json = write(a_sample());
  json["numbers"]["matrix"] = {{1.0}, {1.0, 2.0}};
  EXPECT_NE(refused(json).find("rows of unequal length"), std::string::npos);
  json = write(a_sample());
  json["size_mm"] = "much";
  EXPECT_NE(refused(json).find("size_mm is not a number"), std::string::npos);
  json = write(a_sample());
  json["assembly"] = "left";
  EXPECT_NE(refused(json).find("assembly is \"left\""), std::string::npos);
  json = write(a_sample());
  json["kind"] = "other";
  EXPECT_NE(refused(json).find("kind is \"other\", not \"sample\""), std::string::npos);
  EXPECT_NE(refused(Json::array()).find("is not an object"), std::string::npos);
}

TEST(Fields, AnotherSchemaOrVersionIsRefusedInWords) {
  EXPECT_NO_THROW(expect_schema({{"schema", "a"}, {"schema_version", 2}}, "a", 1, 2));
  EXPECT_THROW(
      expect_schema({{"schema", "b"}, {"schema_version", 2}}, "a", 1, 2), studies::StudyError);
  EXPECT_THROW(
      expect_schema({{"schema", "a"}, {"schema_version", 3}}, "a", 1, 2), studies::StudyError);
  EXPECT_THROW(expect_schema(Json::array(), "a", 1, 2), studies::StudyError);
}

}  // namespace
}  // namespace sixdial::report
