// Temperatures that cannot be a workshop's: all in kelvin or in degrees Fahrenheit, or single
// rows (a lost decimal point, a sensor that was not there).
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kWarmest_degC = 45.0;  // no room for a robot; 7 degC as degF
constexpr double kColdest_degC = -10.0;
constexpr double kFewestOfUnit = 0.2;  // of all rows
constexpr double kMostOfUnit = 0.9;    // of the rows that are too warm
constexpr std::size_t kFewestAlike = 6;
constexpr double kLeastJump_K = 5.0;  // from both neighbours, for a slip
constexpr double kUsualTimes = 10.0;
constexpr double kMostWrong = 0.05;
constexpr double kMostOfOneValue = 0.2;  // what a thermometer says when it has nothing to say

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return values[values.size() / 2];
}

struct Warm {
  std::size_t row = 0;
  double degC = 0.0;
};

std::vector<Warm> warm_rows(const session::Session& session) {
  std::vector<Warm> rows;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    if (const auto& degC = session.samples[i].temperature_c) rows.push_back({i, *degC});
  }
  return rows;
}

/// What a thermometer may have meant by a figure that is no room's temperature.
struct TemperatureUnit {
  std::string_view name;
  double factor, offset;  // degC = factor * (value - offset)
};
constexpr std::array kUnits{
    TemperatureUnit{"kelvin", 1.0, 273.15},
    TemperatureUnit{"degrees Fahrenheit", 1.0 / 1.8, 32.0},
    TemperatureUnit{"tenths of a degree", 0.1, 0.0}};

double in_degC(const TemperatureUnit& unit, double value) {
  return unit.factor * (value - unit.offset);
}

bool is_room(double degC) { return degC > kColdest_degC && degC < kWarmest_degC; }

/// Converts the rows of another unit and tells it: all rows, or those from where on somebody
/// changed it.
void look_at_unit(Look& look, const std::vector<Warm>& rows) {
  std::vector<Warm> hot;
  for (const Warm& each : rows) {
    if (each.degC > kWarmest_degC) hot.push_back(each);
  }
  if (static_cast<double>(hot.size()) <
      std::max(3.0, kFewestOfUnit * static_cast<double>(rows.size())))
    return;
  const auto suits = [&](const TemperatureUnit& unit) {
    return std::ranges::count_if(
        hot, [&](const Warm& each) { return is_room(in_degC(unit, each.degC)); });
  };
  const TemperatureUnit& unit = *std::ranges::max_element(kUnits, {}, suits);
  if (static_cast<double>(suits(unit)) < kMostOfUnit * static_cast<double>(hot.size())) return;
  std::vector<double> values;
  std::vector<std::size_t> named;
  for (const Warm& each : hot) {
    values.push_back(each.degC);
    named.push_back(each.row);
    look.used.samples[each.row].temperature_c = in_degC(unit, each.degC);
  }
  const double middle = median(values);
  look.tell(
      "temperature_unit", Severity::kNote, look.rows(named, "temperature_c"),
      {{"value", middle},
       {"unit", std::string(unit.name)},
       {"read_as", in_degC(unit, middle)}});
}

/// One figure in all rows that no workshop has: no thermometer was there. True: told.
bool is_none(Look& look, const std::vector<Warm>& rows) {
  const double value = rows.front().degC;
  const bool alike =
      std::ranges::all_of(rows, [&](const Warm& each) { return each.degC == value; });
  const bool meant = is_room(value) && value != 0.0;
  const bool converted = std::ranges::any_of(
      kUnits, [&](const TemperatureUnit& unit) { return is_room(in_degC(unit, value)); });
  if (!alike || meant || (value > kWarmest_degC && converted) || rows.size() < kFewestAlike) {
    return false;
  }
  look.tell(
      "no_temperature", Severity::kNote, {.file = "session.csv", .field = "temperature_c"},
      {{"value", value}});
  for (const Warm& each : rows) look.used.samples[each.row].temperature_c.reset();
  return true;
}

/// Rows that jump away from both neighbours, which agree.
std::vector<std::size_t> single_slips(const std::vector<Warm>& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    steps.push_back(std::abs(rows[i].degC - rows[i - 1].degC));
  }
  const double jump = std::max(kLeastJump_K, kUsualTimes * median(steps));
  std::vector<std::size_t> slips;
  std::optional<double> before;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double here = rows[i].degC;
    // The first and the last row have two neighbours on one side.
    const double low = before.value_or(rows[std::min(i + 2, rows.size() - 1)].degC);
    const double high = i + 1 < rows.size() ? rows[i + 1].degC : low;
    const double between = std::abs(high - low);
    if (std::abs(here - low) > jump + between && std::abs(here - high) > jump + between) {
      slips.push_back(i);
    } else {
      before = here;
    }
  }
  return slips;
}

}  // namespace

void look_at_temperatures(Look& look) {
  if (warm_rows(look.used).size() < 3) return;
  if (is_none(look, warm_rows(look.used))) return;
  look_at_unit(look, warm_rows(look.used));
  std::vector<Warm> rows = warm_rows(look.used);
  const std::vector<std::size_t> slips = single_slips(rows);
  const bool one_value = std::ranges::all_of(
      slips, [&](std::size_t i) { return rows[i].degC == rows[slips.front()].degC; });
  const double most = std::max(
      1.0, (one_value ? kMostOfOneValue : kMostWrong) * static_cast<double>(rows.size()));
  if (slips.empty() || static_cast<double>(slips.size()) > most) return;
  std::vector<std::size_t> named;
  for (const std::size_t i : slips) named.push_back(rows[i].row);
  for (auto i = slips.rbegin(); i != slips.rend(); ++i) {
    rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  std::vector<double> right;
  for (const Warm& each : rows) right.push_back(each.degC);
  look.tell(
      "wrong_temperature", Severity::kNote, look.rows(named, "temperature_c"),
      {{"value", *look.measured.samples[named.front()].temperature_c},
       {"usual", median(right)}});
  // Between its neighbours: a fit over temperature needs one for each sample.
  for (const std::size_t row : named) {
    const auto after =
        std::ranges::find_if(rows, [&](const Warm& each) { return each.row > row; });
    const double high = after == rows.end() ? rows.back().degC : after->degC;
    const double low = after == rows.begin() ? high : std::prev(after)->degC;
    look.used.samples[row].temperature_c = 0.5 * (low + high);
  }
}

}  // namespace sixdial::studies::plausibility
