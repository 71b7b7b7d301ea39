#include "report/facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "geometry/units.h"
#include "report/text.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

constexpr double kDiffers = 0.1;  // standard deviations from which two fits are shown as two

std::optional<double> known(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

auto place(const StandsOut& each) {
  return std::tie(each.set, each.point, each.repeat, each.dial);
}

Fit fit_of_rows(
    std::string key, std::string name, const std::vector<studies::ParameterRow>& rows) {
  Fit fit{.key = std::move(key), .name = std::move(name)};
  for (const studies::ParameterRow& row : rows) {
    const double per_unit = geometry::shown_unit(row.unit).per_unit;
    fit.value.push_back(known(per_unit * row.identified));
    fit.sd.push_back(row.fixed ? std::nullopt : known(per_unit * row.sd));
  }
  return fit;
}

bool differ(const Fit& a, const Fit& b) {
  for (std::size_t i = 0; i < a.value.size() && i < b.value.size(); ++i) {
    if (!a.value[i] || !b.value[i] || !a.sd[i]) continue;
    if (std::abs(*a.value[i] - *b.value[i]) > kDiffers * *a.sd[i]) return true;
  }
  return false;
}

/// A fit of the diagnosis in the order of the result's parameters.
Fit fit_of_diagnosis(
    const studies::CalibrationResult& result, const studies::DiagnosisResult& diagnosis,
    std::string key, std::string name, double diagnosis::ParameterChange::*value,
    double diagnosis::ParameterChange::*sd) {
  Fit fit{.key = std::move(key), .name = std::move(name)};
  for (const studies::ParameterRow& row : result.parameters) {
    const auto found =
        std::ranges::find(diagnosis.parameters, row.name, &diagnosis::ParameterChange::name);
    const bool has = found != diagnosis.parameters.end();
    const double per_unit = geometry::shown_unit(row.unit).per_unit;
    fit.value.push_back(has ? known(per_unit * (*found).*value) : std::nullopt);
    fit.sd.push_back(has ? known(per_unit * (*found).*sd) : std::nullopt);
  }
  return fit;
}

}  // namespace

std::vector<StandsOut> stand_out_of(
    const std::optional<studies::GrossErrors>& check,
    const studies::DiagnosisResult* diagnosis) {
  std::vector<StandsOut> all;
  if (check) {
    for (const studies::GrossErrors::Found& each : check->found) {
      all.push_back(
          {.set = each.set,
           .point = each.point,
           .repeat = each.repeat,
           .dial = each.dial.value_or(""),
           .off_mm = each.size_mm,
           .times_noise = each.times_sigma,
           .not_fitted = each.treatment == studies::Treatment::kSetAside});
    }
  }
  if (diagnosis != nullptr) {
    for (const studies::GrossReading& each : diagnosis->gross_readings) {
      StandsOut row{
          .set = each.set, .point = each.point, .repeat = each.repeat, .dial = each.dial};
      auto same = std::ranges::find_if(
          all, [&](const StandsOut& other) { return place(other) == place(row); });
      if (same == all.end()) {
        row.times_noise = std::abs(each.size_mm) / diagnosis->noise.sigma_mm;
        all.push_back(std::move(row));
        same = all.end() - 1;
      }
      same->off_mm = each.size_mm;
      same->not_diagnosed = true;
      same->remark = remark_on_gross(each);
    }
  }
  std::ranges::stable_sort(
      all, [](const StandsOut& a, const StandsOut& b) { return place(a) < place(b); });
  return all;
}

std::vector<Fit> fits_of(
    const studies::CalibrationResult& result, const studies::DiagnosisResult* diagnosis) {
  std::vector<Fit> fits{fit_of_rows("calibration", "identified", result.parameters)};
  if (result.assessment && result.assessment->parameters.size() == result.parameters.size()) {
    Fit least_squares = fit_of_rows(
        "least_squares", "least squares, the same data", result.assessment->parameters);
    if (differ(fits.front(), least_squares)) fits.push_back(std::move(least_squares));
  }
  if (diagnosis != nullptr && !diagnosis->parameters.empty()) {
    using diagnosis::ParameterChange;
    fits.push_back(fit_of_diagnosis(
        result, *diagnosis, "robot_alone", "diagnosis, robot alone", &ParameterChange::baseline,
        &ParameterChange::baseline_sd));
    if (std::ranges::any_of(diagnosis->causes, &studies::FoundCause::is_in_fit)) {
      fits.push_back(fit_of_diagnosis(
          result, *diagnosis, "with_causes", "diagnosis, with the causes",
          &ParameterChange::extended, &ParameterChange::extended_sd));
    }
  }
  return fits;
}

std::string stand_out_in_words(const std::vector<StandsOut>& all) {
  if (all.empty()) return "";
  const auto count = [](auto number) { return static_cast<long long>(number); };
  std::string words = fmt::format(
      "{} not agree with the rest",
      counted(count(all.size()), "measured value does", "measured values do"));
  if (const auto left = std::ranges::count_if(all, &StandsOut::not_fitted); left > 0) {
    words += fmt::format("; the calibration left out {}", left);
  }
  if (const auto left = std::ranges::count_if(all, &StandsOut::not_diagnosed); left > 0) {
    words += fmt::format("; the diagnosis left out {}", left);
  }
  return words + ".";
}

}  // namespace sixdial::report
