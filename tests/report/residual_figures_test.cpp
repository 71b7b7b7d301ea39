// What is left, by everything it may depend on: a built-in dependence is found, where it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "report/figures.h"
#include "report/html_report.h"
#include "sample_session.h"

namespace sixdial::report {
namespace {

using testing::HasSubstr;

/// 120 points whose residual is noise of 2 um and `error` on top.
ReportData session_with(const std::function<Eigen::Vector2d(const PointRow&)>& error) {
  ReportData data;
  data.joints = {{"theta1", "rad"}, {"theta2", "rad"}};
  data.methods = {
      {.id = "before", .name = "before"},
      {.id = "ekf_dqpso", .name = "EKF-DQPSO"},
      {.id = "lm", .name = "LM"},
      {.id = "ekf_dqpso+anfis", .name = "both", .has_residual_model = true}};
  std::mt19937_64 engine(11);
  std::normal_distribution<double> noise_mm(0.0, 0.002);
  std::uniform_real_distribution<double> angle_rad(1.0, 3.0);
  for (int i = 0; i < 120; ++i) {
    PointRow p{.set = "G1", .point = i};
    p.q = Eigen::Vector2d(angle_rad(engine), angle_rad(engine));
    p.measured_mm = Eigen::Vector2d(20.0, 30.0);
    p.time_s = 8.0 * i;
    p.temperature_c = 20.0 + std::abs(noise_mm(engine)) * 100.0;
    p.approach = {i % 2 == 0 ? 1 : -1, i % 3 == 0 ? 1 : -1};
    const Eigen::Vector2d noise(noise_mm(engine), noise_mm(engine));
    p.residual_mm = {
        Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(noise + error(p)), Eigen::Vector2d(5.0, 5.0),
        noise};
    data.points.push_back(p);
  }
  return data;
}

TEST(ResidualBy, NoiseAloneHasNoOrder) {
  const auto figure =
      residual_by(session_with([](const PointRow&) { return Eigen::Vector2d(0, 0); }));
  ASSERT_TRUE(figure);
  EXPECT_EQ(figure->chart.panels.size(), 6U);
  EXPECT_THAT(figure->here, HasSubstr("no clear dependence"));
  // The delivered parameters, without the network and not a rival's.
  EXPECT_THAT(figure->shows, HasSubstr("with the parameters of EKF-DQPSO alone"));
}

TEST(ResidualBy, FindsWhatTheErrorDependsOn) {
  struct Case {
    const char* words;
    std::function<Eigen::Vector2d(const PointRow&)> error;
  };
  constexpr double kSize_mm = 0.006;
  const std::vector<Case> cases{
      {"encoder angle 1",
       [](const PointRow& p) { return Eigen::Vector2d(kSize_mm * std::sin(4 * p.q->x()), 0); }},
      {"encoder angle 2",
       [](const PointRow& p) { return Eigen::Vector2d(0, kSize_mm * (p.q->y() - 2.0)); }},
      {"time",
       [](const PointRow& p) { return Eigen::Vector2d(kSize_mm * *p.time_s / 960.0, 0); }},
      {"side from which joint 2 arrives",
       [](const PointRow& p) { return Eigen::Vector2d(0.5 * kSize_mm * p.approach[1], 0); }}};
  for (const Case& each : cases) {
    const auto figure = residual_by(session_with(each.error));
    ASSERT_TRUE(figure);
    EXPECT_THAT(figure->here, HasSubstr(std::string("Clearest by ") + each.words));
    EXPECT_THAT(figure->here, HasSubstr("an error that the parameters do not contain"));
  }
}

TEST(ResidualBy, ItsTableHasTheMeansOfTheClasses) {
  const auto figure = residual_by(session_with(
      [](const PointRow& p) { return Eigen::Vector2d(p.approach[0] > 0 ? 0.1 : -0.1, 0); }));
  ASSERT_TRUE(figure);
  int found = 0;
  constexpr double kNoise_mm = 0.001;  // of a mean of 60, four standard deviations
  for (const auto& row : figure->table.rows) {
    if (std::get<std::string>(row[0]) != "side from which joint 1 arrives") continue;
    const double side = std::get<Number>(row[2]).value;
    EXPECT_EQ(std::get<Number>(row[4]).value, 60);
    EXPECT_NEAR(std::get<Number>(row[5]).value, 0.1 * side, kNoise_mm);
    ++found;
  }
  EXPECT_EQ(found, 2);
}

TEST(ResidualBy, LeavesOutWhatWasNotRecorded) {
  ReportData data = session_with([](const PointRow&) { return Eigen::Vector2d(0, 0); });
  for (PointRow& p : data.points) {
    p.temperature_c.reset();
    p.approach = {0, 0};
  }
  const auto figure = residual_by(data);
  ASSERT_TRUE(figure);
  EXPECT_EQ(figure->chart.panels.size(), 3U);
  data.methods.resize(1);
  EXPECT_FALSE(residual_by(data));
}

TEST(Head, NamesInstrumentsSoftwareSeedAndHashes) {
  const ReportData data = sample_session();
  const std::string page = html_report(data, {.charts = false});
  const std::string head = page.substr(0, page.find("</header>"));
  EXPECT_THAT(head, HasSubstr("6 "));
  EXPECT_THAT(head, HasSubstr("resolution 0.001 mm"));
  EXPECT_THAT(head, HasSubstr("Sixdial " + data.head.software_version));
  EXPECT_THAT(head, HasSubstr("seed " + std::to_string(*data.head.seed)));
  EXPECT_THAT(head, HasSubstr(data.head.data_hash.substr(0, 19)));
  EXPECT_THAT(head, HasSubstr(data.head.rig_hash.substr(0, 19)));
}

}  // namespace
}  // namespace sixdial::report
