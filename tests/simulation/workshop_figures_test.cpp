// doc/manual/mounting.md says how well a workshop knows its rig; what is taken where a rig file
// says nothing (simulation/rig_quantities.cpp) are the same figures.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "geometry/rig.h"
#include "geometry/units.h"
#include "simulation/rig_quantities.h"
#include "tests/support/paths.h"

namespace sixdial::simulation {
namespace {

/// The numbers in a text such as "`[0.03, 0.1]`".
std::vector<double> numbers_in(std::string text) {
  for (char& letter : text) {
    if (std::string("0123456789.").find(letter) == std::string::npos) letter = ' ';
  }
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double each = 0.0; in >> each;) numbers.push_back(each);
  return numbers;
}

/// By key: the last column of the page's table, and the example file below it.
std::map<std::string, std::vector<std::vector<double>>> documented() {
  std::map<std::string, std::vector<std::vector<double>>> result;
  std::ifstream page(test_paths::source_dir() + "/doc/manual/mounting.md");
  for (std::string line; std::getline(page, line);) {
    const std::size_t name = line.find("_sd_");
    if (name == std::string::npos) continue;
    if (line.starts_with("| `")) {
      const std::string key = line.substr(3, line.find_first_of(" `", 3) - 3);
      const std::size_t end = line.rfind('|');
      const std::size_t begin = line.rfind('|', end - 1);
      result[key].push_back(numbers_in(line.substr(begin, end - begin)));
    } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
      const std::size_t comment = line.find('#');
      result[line.substr(0, equals)].push_back(
          numbers_in(line.substr(equals, comment - equals)));
    }
  }
  return result;
}

TEST(WorkshopFigures, AreThoseOfTheManual) {
  const auto known = claimed_quantities(geometry::default_rig());
  const auto figure = [&](const std::string& name) {
    for (const RigQuantity& each : known) {
      if (!each.name.starts_with(name)) continue;
      return each.unit == "rad" ? each.sd * geometry::kDegPerRad : each.sd;
    }
    ADD_FAILURE() << name;
    return 0.0;
  };
  const std::map<std::string, std::vector<double>> used{
      {"position_sd_mm",
       {figure("place of dial A along its axis"), figure("place of dial A across its axis")}},
      {"axis_sd_deg", {figure("axis of dial A")}},
      {"tip_radius_sd_mm", {figure("tip radius of dial A")}},
      {"side_sd_mm", {figure("side of the cuboid")}},
      {"squareness_sd_deg", {figure("squareness of the cuboid")}},
      {"offset_sd_mm", {figure("centre of the cuboid along x")}}};
  const auto told = documented();
  for (const auto& [key, values] : used) {
    ASSERT_TRUE(told.contains(key)) << key;
    EXPECT_EQ(told.at(key).size(), 2U) << key << ": in the table and in the example";
    for (const std::vector<double>& each : told.at(key)) {
      ASSERT_EQ(each.size(), values.size()) << key;
      for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_NEAR(each[i] / values[i], 1.0, 0.005) << key;  // three digits
      }
    }
  }
}

}  // namespace
}  // namespace sixdial::simulation
