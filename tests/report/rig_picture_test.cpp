// The rig's picture: every dial where the file puts it, hostile names harmless.
#include "report/rig_picture.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sixdial::report {
namespace {

using testing::HasSubstr;
using testing::Not;

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size())
    ++n;
  return n;
}

TEST(RigPicture, DrawsEveryDialWithItsNameAtItsTip) {
  const geometry::Rig rig = geometry::default_rig();
  const std::string svg = rig_svg(rig);
  for (const geometry::Dial& dial : rig.dials) {
    EXPECT_THAT(svg, HasSubstr(">" + dial.id + "</text>"));
    const auto& g = dial.geometry;
    EXPECT_THAT(
        svg, HasSubstr(fmt::format(
                 "class=\"free\" x1=\"{:.3f}\" y1=\"{:.3f}\"", g.position_mm.x(),
                 -g.position_mm.y())));  // y goes down in SVG
  }
  EXPECT_EQ(count(svg, "class=\"proximal\""), 2);
  EXPECT_EQ(count(svg, "class=\"distal\""), 2);
  for (const char* words :
       {"W table, B robot", "cuboid, 80 mm", ">x<", ">y<", "O1", "O2", "O3", "O4", "E tool"}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
}

TEST(RigPicture, LinksHaveTheirLengthInMillimetres) {
  geometry::Rig rig = geometry::default_rig();
  const std::string svg = rig_svg(rig);
  rig.dials[0].geometry.position_mm.x() += 3.0;
  const std::string moved = rig_svg(rig);
  EXPECT_NE(svg, moved);
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  const std::string mark = "class=\"proximal\" ";
  const std::size_t at = svg.find(mark);
  ASSERT_NE(at, std::string::npos);
  ASSERT_EQ(
      std::sscanf(
          svg.c_str() + at + mark.size(), "x1=\"%lf\" y1=\"%lf\" x2=\"%lf\" y2=\"%lf\"", &x1,
          &y1, &x2, &y2),
      4);
  constexpr double kPrinted_mm = 0.002;  // three decimals of four numbers
  EXPECT_NEAR(std::hypot(x2 - x1, y2 - y1), rig.robot.nominal[geometry::kL11], kPrinted_mm);
}

TEST(RigPicture, HasRoomForEveryWord) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.resize(1);  // dial A alone: nothing stands left of the robot but a name
  const std::string svg = rig_svg(rig);
  double left = 0, top = 0, width = 0, height = 0;
  const std::size_t box = svg.find("viewBox=");
  ASSERT_NE(box, std::string::npos);
  ASSERT_EQ(
      std::sscanf(
          svg.c_str() + box, "viewBox=\"%lf %lf %lf %lf\"", &left, &top, &width, &height),
      4);
  const std::size_t word = svg.find(">O1, motor 1<");
  ASSERT_NE(word, std::string::npos);
  const std::size_t at = svg.rfind("x=\"", word);
  double end = 0;
  ASSERT_EQ(std::sscanf(svg.c_str() + at, "x=\"%lf\"", &end), 1);
  constexpr double kWords_mm = 12 * 3.9;  // twelve letters as a browser sets them
  EXPECT_GE(end - kWords_mm, left);
}

TEST(RigPicture, SaysWhyNoLinksAreDrawn) {
  geometry::Rig rig = geometry::default_rig();
  rig.cuboid.reference_pose_mm = {900, 900};
  const std::string svg = rig_svg(rig);
  EXPECT_THAT(svg, HasSubstr("reference pose: "));
  EXPECT_THAT(svg, HasSubstr("no links drawn"));
  EXPECT_THAT(svg, Not(HasSubstr("class=\"distal\"")));
}

TEST(RigPicture, HostileNamesRunNothing) {
  geometry::Rig rig = geometry::default_rig();
  rig.name = "</title><script>alert(1)</script>";
  rig.dials[0].id = "<script>alert(2)</script>";
  EXPECT_THAT(rig_svg(rig), Not(HasSubstr("<script")));
}

}  // namespace
}  // namespace sixdial::report
