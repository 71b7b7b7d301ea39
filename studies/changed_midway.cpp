#include "studies/changed_midway.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "calibration/rig_spaces.h"
#include "geometry/registration.h"

namespace sixdial::studies {
namespace {

constexpr int kFewest = 6;          // readings; a few in a row may be accidents
constexpr double kBeyond = 10.0;    // standard deviations of a good reading
constexpr double kLeast_mm = 0.02;  // and at least so much: what is smaller is the diagnosis'
constexpr double kInside = 0.8;     // of the readings from there on that stand out
constexpr double kOutside = 0.1;    // of the others
constexpr double kSameSize = 0.25;  // spread of a shift, in its size

struct ReadingError {
  int sample = 0;
  double mm = 0.0;
  bool stands_out = false;
};
using ErrorsOfColumn = std::vector<ReadingError>;

std::vector<ErrorsOfColumn> errors_of(
    std::span<const simulation::Trial> trials, const session::Session& session,
    const calibration::GrossErrorCheck& fitted) {
  std::vector<ErrorsOfColumn> dials(session.rig.dials.size());
  const calibration::ObservationSpace space = calibration::dial_space(trials, session.rig);
  if (space.parameters() != fitted.x.size()) return {};
  Eigen::VectorXd e;
  for (int i = 0; i < space.samples(); ++i) {
    const auto sample = static_cast<std::size_t>(i);
    e.resize(space.rows(i));
    if (!space.evaluate(i, fitted.x, e, nullptr)) continue;
    for (int row = 0; row < space.rows(i); ++row) {
      const auto at = static_cast<std::size_t>(space.first_row[sample] + row);
      const auto dial = static_cast<std::size_t>(space.channel[at]);
      const double limit = std::max(kLeast_mm, kBeyond * fitted.sigma_by_dial_mm.at(dial));
      dials.at(dial).push_back({space.sample[sample], e[row], std::abs(e[row]) > limit});
    }
  }
  for (ErrorsOfColumn& each : dials) std::ranges::stable_sort(each, {}, &ReadingError::sample);
  return dials;
}

struct ChangedStretch {
  std::size_t begin = 0, end = 0;  // of a dial's errors
};

/// The stretch in which almost all stand out and outside of which almost none do; empty: there
/// is none, or it is everything.
std::optional<ChangedStretch> stretch_of(const ErrorsOfColumn& errors) {
  constexpr double kAgainst = -4.0;  // of one that does not stand out: kInside of them must
  double sum = 0.0;
  double most = 0.0;
  ChangedStretch best;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    sum += errors[i].stands_out ? 1.0 : kAgainst;
    if (sum <= 0.0) {
      sum = 0.0;
      begin = i + 1;
    } else if (sum > most) {
      most = sum;
      best = {begin, i + 1};
    }
  }
  const auto out = [&](std::size_t from, std::size_t to) {
    return static_cast<double>(std::count_if(
        errors.begin() + static_cast<std::ptrdiff_t>(from),
        errors.begin() + static_cast<std::ptrdiff_t>(to),
        [](const ReadingError& each) { return each.stands_out; }));
  };
  const double inside = out(best.begin, best.end);
  const double outside = out(0, best.begin) + out(best.end, errors.size());
  const double length = static_cast<double>(best.end - best.begin);
  const double others = static_cast<double>(errors.size()) - length;
  if (inside < kFewest || others < kFewest) return std::nullopt;
  if (inside < kInside * length || outside > kOutside * others) return std::nullopt;
  return best;
}

/// Dials that changed in the same stretch of rows.
struct DialChange {
  std::vector<std::string> dials;
  std::optional<double> shift_mm;  // all errors are alike; empty: they are not
  int first = 0, last = 0;         // samples that are in it
  int before = -1, after = 0;      // the nearest samples that are not
  int readings = 0;
};

/// Both may have begun and ended at the same rows: not every dial touches at every pose.
bool may_be_one(const DialChange& a, const DialChange& b) {
  return std::max(a.before, b.before) < std::min(a.first, b.first) &&
         std::max(a.last, b.last) < std::min(a.after, b.after);
}

std::optional<double> shift_of(const ErrorsOfColumn& errors, const ChangedStretch& stretch) {
  std::vector<double> sizes, apart;
  for (std::size_t i = stretch.begin; i < stretch.end; ++i) sizes.push_back(errors[i].mm);
  const double middle = geometry::median_of(sizes);
  apart.reserve(sizes.size());
  for (const double each : sizes) apart.push_back(std::abs(each - middle));
  if (geometry::median_of(std::move(apart)) > kSameSize * std::abs(middle)) return std::nullopt;
  return middle;
}

Warning warning_of(const DialChange& change, const session::Session& session) {
  const auto name = [&](int index) {
    const session::Sample& sample = session.samples[static_cast<std::size_t>(index)];
    return RowName{sample.line, sample.set, sample.point, sample.repeat};
  };
  std::string names, fields;
  for (std::size_t i = 0; i < change.dials.size(); ++i) {
    const bool last = i + 1 == change.dials.size();
    names += (i == 0 ? "" : last ? " and " : ", ") + change.dials[i];
    fields += (i == 0 ? "dial_" : ", dial_") + change.dials[i] + "_mm";
  }
  const RowName first = name(change.first);
  const RowName last = name(change.last);
  const bool to_the_end = change.after >= std::ssize(session.samples);
  const auto place = [](const RowName& row) {
    return row.line > 0 ? fmt::format("line {}", row.line)
                        : fmt::format("{} point {}", row.set, row.point);
  };
  Warning warning{
      "dial_changed",
      Severity::kDoubt,
      {.file = "session.csv", .field = fields},
      {{"dials", (change.dials.size() == 1 ? "Dial " : "Dials ") + names},
       {"reads", std::string(change.dials.size() == 1 ? "reads" : "read")},
       {"from", place(first)},
       {"to", to_the_end ? std::string("the end") : place(last)},
       {"readings", static_cast<double>(change.readings)}}};
  if (change.dials.size() == 1 && change.shift_mm) {
    warning.parts["shift"] = fmt::format(
        "{:.3f} mm too {}", std::abs(*change.shift_mm),
        *change.shift_mm > 0 ? "much" : "little");
  }
  return warning;
}

}  // namespace

std::vector<Warning> changed_midway(
    std::span<const simulation::Trial> trials, const session::Session& session,
    const calibration::GrossErrorCheck& fitted) {
  if (fitted.x.size() == 0 || fitted.sigma_by_dial_mm.size() != session.rig.dials.size()) {
    return {};
  }
  const std::vector<ErrorsOfColumn> dials = errors_of(trials, session, fitted);
  std::vector<DialChange> changes;
  for (std::size_t k = 0; k < dials.size(); ++k) {
    const auto stretch = stretch_of(dials[k]);
    if (!stretch) continue;
    const ErrorsOfColumn& errors = dials[k];
    const bool from_the_start = stretch->begin == 0;
    const bool to_the_end = stretch->end == errors.size();
    DialChange change{
        .dials = {session.rig.dials[k].id},
        .shift_mm = shift_of(errors, *stretch),
        .first = errors[stretch->begin].sample,
        .last = errors[stretch->end - 1].sample,
        .before = from_the_start ? -1 : errors[stretch->begin - 1].sample,
        .after = to_the_end ? static_cast<int>(std::ssize(session.samples))
                            : errors[stretch->end].sample,
        .readings = static_cast<int>(stretch->end - stretch->begin)};
    const auto same = std::ranges::find_if(
        changes, [&](const DialChange& each) { return may_be_one(each, change); });
    if (same == changes.end()) {
      changes.push_back(std::move(change));
    } else {
      same->dials.push_back(change.dials.front());
      same->first = std::min(same->first, change.first);
      same->last = std::max(same->last, change.last);
      same->before = std::max(same->before, change.before);
      same->after = std::min(same->after, change.after);
      same->readings += change.readings;
    }
  }
  std::vector<Warning> warnings;
  for (const DialChange& each : changes) warnings.push_back(warning_of(each, session));
  return warnings;
}

}  // namespace sixdial::studies
