// Maps of places: one panel in the plane; in space three views, each with every point.
#include "report/views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "arm_report.h"
#include "page_parts.h"
#include "report/figures.h"
#include "report/html_report.h"
#include "report/sections/diagnosis_figures.h"
#include "report/tables.h"
#include "report/text.h"
#include "sample_session.h"

namespace sixdial::report {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

struct Sides {
  const char *across, *up, *from;
};
constexpr std::array kSides{
    Sides{"x", "y", ", from above"}, Sides{"x", "z", ", from the front"},
    Sides{"y", "z", ", from the side"}};
constexpr std::array<std::pair<Eigen::Index, Eigen::Index>, 3> kCoordinates{
    std::pair{0, 1}, {0, 2}, {1, 2}};

class ArmReport : public testing::Test {
 protected:
  static const ReportData& data() {
    static const ReportData made = arm_report();
    return made;
  }
};

TEST_F(ArmReport, DrawsEveryPointInThreeViews) {
  ASSERT_EQ(data().axes, 3);
  ASSERT_EQ(data().points.size(), 40U);
  const auto figure = residual_map(data());
  ASSERT_TRUE(figure);
  const std::vector<Panel>& panels = figure->chart.panels;
  ASSERT_EQ(panels.size(), 3 * data().methods.size());
  EXPECT_EQ(figure->chart.panels_in_a_row, 3);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const std::size_t method = i / 3;
    const auto& [across, up, from] = kSides[i % 3];
    const auto [to_the_right, upwards] = kCoordinates[i % 3];
    EXPECT_EQ(panels[i].title, data().methods[method].name + from);
    EXPECT_EQ(panels[i].x.label, across);
    EXPECT_EQ(panels[i].y.label, up);
    EXPECT_EQ(panels[i].x.unit, "mm");
    EXPECT_TRUE(panels[i].equal_scales);
    EXPECT_EQ(panels[i].arrow_scale, panels[3 * method].arrow_scale);
    EXPECT_EQ(panels[i].arrow_key, panels[3 * method].arrow_key);
    ASSERT_EQ(panels[i].series.size(), 2U);
    for (const Series& series : panels[i].series) {
      const std::string set = series.name.substr(0, 2);
      std::vector<double> x, y, dx, dy;
      for (const PointRow& point : data().points) {
        if (point.set != set) continue;
        x.push_back((*point.measured_mm)[to_the_right]);
        y.push_back((*point.measured_mm)[upwards]);
        dx.push_back((*point.residual_mm[method])[to_the_right]);
        dy.push_back((*point.residual_mm[method])[upwards]);
      }
      EXPECT_EQ(x.size(), set == "G1" ? 26U : 14U);
      EXPECT_EQ(series.x, x);
      EXPECT_EQ(series.y, y);
      EXPECT_EQ(series.dx, dx);
      EXPECT_EQ(series.dy, dy);
      for (std::size_t k = 0; k < x.size(); ++k) {
        EXPECT_TRUE(x[k] > panels[i].x.low && x[k] < panels[i].x.high);
        EXPECT_TRUE(y[k] > panels[i].y.low && y[k] < panels[i].y.high);
      }
    }
  }
  for (const char* words :
       {"from above (x, y), from the front (x, z) and from the side (y, z)",
        "to the right in the view from above, (+0.010, 0, 0) mm"}) {
    EXPECT_THAT(figure->shows, HasSubstr(words));
  }
}

TEST_F(ArmReport, ListsPlacesWithTheirHeight) {
  const std::string page = html_report(data());
  const json tables = tables_of(page)["tables"];  // a row of other width than its head fails
  const Table wanted = residual_table(data());
  std::vector<std::string> keys;
  for (const Column& each : wanted.columns) keys.push_back(each.key);
  EXPECT_THAT(
      keys, ElementsAre(
                "set", "point", "x_mm", "y_mm", "z_mm", "before_ex_mm", "before_ey_mm",
                "before_ez_mm", "lm_ex_mm", "lm_ey_mm", "lm_ez_mm"));
  const json& rows = tables["residuals"]["rows"];
  ASSERT_EQ(rows.size(), 40U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(wanted.rows[i].size(), wanted.columns.size());
    EXPECT_EQ(std::get<Number>(wanted.rows[i][4]).value, data().points[i].measured_mm->z());
    for (std::size_t k = 0; k < wanted.columns.size(); ++k) {
      EXPECT_EQ(rows[i][k], shown(wanted.rows[i][k]));
    }
  }
  ASSERT_TRUE(tables.contains("uncertainty_map"));
  const json& map = tables["uncertainty_map"];
  EXPECT_THAT(map["head"].dump(), HasSubstr("z [mm]"));
  EXPECT_THAT(page, HasSubstr("a cut through the measured space at half its height, z = "));
  EXPECT_THAT(without_scripts(page), HasSubstr("from the front (x, z)"));
}

TEST_F(ArmReport, GivesTheBrowserAllPanels) {
  ASSERT_TRUE(has_chart_libraries()) << "built without npm: there are no charts to draw";
  const std::string page = html_report(data());
  const std::string open = "id=\"charts\">";
  const std::size_t at = page.find(open) + open.size();
  const json charts = json::parse(page.substr(at, page.find("</script>", at) - at));
  const json& panels = charts["figure_residual_map"]["panels"];
  ASSERT_EQ(panels.size(), 6U);
  for (const json& panel : panels) {
    EXPECT_EQ(panel["series"][0]["x"].size() + panel["series"][1]["x"].size(), 40U);
    EXPECT_EQ(panel["equal"], true);
  }
}

TEST(PlanarReport, HasOnePanelForEachMap) {
  const ReportData data = sample_session();
  const auto figure = residual_map(data);
  ASSERT_TRUE(figure);
  ASSERT_EQ(figure->chart.panels.size(), data.methods.size());
  for (std::size_t m = 0; m < data.methods.size(); ++m) {
    const Panel& panel = figure->chart.panels[m];
    EXPECT_EQ(panel.title, data.methods[m].name);
    EXPECT_EQ(panel.x.label, "x");
    EXPECT_EQ(panel.y.label, "y");
  }
  EXPECT_THAT(figure->shows, Not(HasSubstr("from above")));
  EXPECT_THAT(figure->shows, HasSubstr("an arrow to the right, (+0.010, 0) mm, is a tool"));
  const auto by = residual_by(data);
  ASSERT_TRUE(by);
  for (const Panel& panel : by->chart.panels) EXPECT_EQ(panel.series.size(), 2U);
  EXPECT_THAT(by->shows, HasSubstr("both components"));
}

/// Shifts of the tool along the last axis alone, at places 1 m apart.
studies::DiagnosisResult shifted(int axes) {
  studies::DiagnosisResult result;
  studies::ToolShifts& shifts = result.tool_shifts;
  if (axes == 3) shifts.z_mm.emplace();
  for (int i = 0; i < 5; ++i) {
    shifts.sample.push_back(i);
    shifts.x_mm.push_back(1000.0 * i);
    shifts.y_mm.push_back(100.0 * i);
    if (shifts.z_mm) shifts.z_mm->push_back(10.0 * i);
    Eigen::VectorXd shift = Eigen::VectorXd::Zero(axes);
    shift[axes - 1] = 0.01 * (i + 1);
    shifts.before_mm.push_back(shift);
    shifts.after_mm.emplace_back(0.1 * shift);
  }
  result.causes.resize(1);
  result.causes[0].kind = studies::CauseKind::kEffect;
  return result;
}

TEST(ToolShift, IsSeenFromThreeSidesInSpace) {
  const auto figure = shift_figure(shifted(3));
  ASSERT_TRUE(figure);
  const auto& panels = figure->chart.panels;
  ASSERT_EQ(panels.size(), 6U);  // without and with the causes
  EXPECT_EQ(figure->chart.panels_in_a_row, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_THAT(panels[i].title, EndsWith(kSides[i].from));
    EXPECT_EQ(panels[i].x.label, kSides[i].across);
    EXPECT_EQ(panels[i].y.label, kSides[i].up);
    ASSERT_EQ(panels[i].series.at(0).x.size(), 5U);
    EXPECT_EQ(panels[i].series[0].dx, std::vector<double>(5, 0.0));
  }
  // Along z alone: nothing from above, all of it from the front and from the side.
  const std::vector<double> along{0.01, 0.02, 0.03, 0.04, 0.05};
  const auto near = testing::Pointwise(testing::DoubleEq(), along);
  EXPECT_EQ(panels[0].series[0].dy, std::vector<double>(5, 0.0));
  EXPECT_THAT(panels[1].series[0].dy, near);
  EXPECT_THAT(panels[2].series[0].dy, near);
  // Long enough to see in a space of 4 m.
  const double drawn_mm = 0.05 * panels[0].arrow_scale;
  EXPECT_GT(drawn_mm, 0.03 * 4000.0);
  EXPECT_LE(drawn_mm, 0.1 * 4000.0);
  std::vector<std::string> keys;
  for (const Column& each : figure->table.columns) keys.push_back(each.key);
  EXPECT_THAT(
      keys, ElementsAre(
                "sample", "x_mm", "y_mm", "z_mm", "before_x_mm", "before_y_mm", "before_z_mm",
                "after_x_mm", "after_y_mm", "after_z_mm"));
  for (const auto& row : figure->table.rows) EXPECT_EQ(row.size(), keys.size());
}

TEST(ToolShift, IsOnePanelInThePlane) {
  const auto figure = shift_figure(shifted(2));
  ASSERT_TRUE(figure);
  ASSERT_EQ(figure->chart.panels.size(), 2U);  // without and with the causes
  EXPECT_EQ(figure->chart.panels_in_a_row, 2);
  for (const Panel& panel : figure->chart.panels) {
    EXPECT_THAT(panel.title, Not(HasSubstr("from")));
    EXPECT_EQ(panel.y.label, "y");
  }
  EXPECT_EQ(figure->table.columns.size(), 7U);
}

// An error of height alone was in no panel and in no mean when only x and y were looked at.
TEST(ResidualBy, FindsAnErrorOfHeight) {
  ReportData data;
  data.axes = 3;
  data.joints = {{"theta1", "rad"}};
  data.methods = {{.id = "before", .name = "before"}, {.id = "lm", .name = "LM"}};
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise_mm(0.0, 0.002);
  for (int i = 0; i < 120; ++i) {
    PointRow p{.set = "G1", .point = i};
    p.q = Eigen::VectorXd::Constant(1, -1.0 + i / 60.0);
    p.measured_mm = Eigen::Vector3d(1, 2, 3);
    const Eigen::Vector3d e(noise_mm(engine), noise_mm(engine), noise_mm(engine));
    p.residual_mm = {e, Eigen::Vector3d(e + Eigen::Vector3d(0, 0, 0.01 * (*p.q)[0]))};
    data.points.push_back(p);
  }
  const auto figure = residual_by(data);
  ASSERT_TRUE(figure);
  EXPECT_THAT(figure->here, HasSubstr("an error that the parameters do not contain"));
  EXPECT_THAT(figure->shows, HasSubstr("all three components"));
  ASSERT_EQ(figure->chart.panels.size(), 1U);
  ASSERT_EQ(figure->chart.panels[0].series.size(), 3U);
  EXPECT_EQ(figure->chart.panels[0].series[2].name, "along z");
  ASSERT_EQ(figure->table.columns.size(), 9U);
  EXPECT_EQ(figure->table.columns[7].key, "mean_z_mm");
  // Six classes of 20 points: the outer ones have their middle 5/6 from zero.
  constexpr double kNoise_mm = 0.002;  // four standard deviations of a mean of 20
  EXPECT_NEAR(std::get<Number>(figure->table.rows.back()[7]).value, 0.01 * 5 / 6, kNoise_mm);
  EXPECT_NEAR(std::get<Number>(figure->table.rows.back()[5]).value, 0.0, kNoise_mm);
}

}  // namespace
}  // namespace sixdial::report
