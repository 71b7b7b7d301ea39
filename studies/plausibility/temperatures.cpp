// Temperatures that cannot be a workshop's: all in kelvin or in degrees Fahrenheit, or single
// rows (a lost decimal point, a sensor that was not there).
#include <algorithm>
#include <cmath>
#include <optional>

#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kLeastKelvin = 200.0;     // no robot is measured at 200 degC
constexpr double kLeastFahrenheit = 45.0;  // 7 degC as degF; 45 degC is no room for a robot
constexpr double kZero_K = 273.15;
constexpr double kLeastJump_K = 5.0;  // from both neighbours, for a slip
constexpr double kUsualTimes = 10.0;
constexpr double kMostWrong = 0.05;

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

/// Converts all of another unit and tells it.
void look_at_unit(Look& look, const std::vector<Warm>& rows) {
  std::vector<double> values;
  std::vector<std::size_t> named;
  for (const Warm& each : rows) {
    values.push_back(each.degC);
    named.push_back(each.row);
  }
  const double middle = median(values);
  const bool kelvin = middle > kLeastKelvin;
  if (!kelvin && middle < kLeastFahrenheit) return;
  const auto converted = [&](double value) {
    return kelvin ? value - kZero_K : (value - 32.0) / 1.8;
  };
  look.tell(
      "temperature_unit", Severity::kNote, look.rows(named, "temperature_c"),
      {{"value", middle},
       {"unit", std::string(kelvin ? "kelvin" : "degrees Fahrenheit")},
       {"read_as", converted(middle)}});
  for (const Warm& each : rows) {
    auto& degC = look.used.samples[each.row].temperature_c;
    degC = converted(*degC);
  }
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
  look_at_unit(look, warm_rows(look.used));
  std::vector<Warm> rows = warm_rows(look.used);
  const std::vector<std::size_t> slips = single_slips(rows);
  const double most = std::max(1.0, kMostWrong * static_cast<double>(rows.size()));
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
