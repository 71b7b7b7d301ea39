#include "studies/diagnosis_causes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "diagnosis/thresholds.h"

namespace sixdial::studies {
namespace {

using diagnosis::Readings;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Of a finding or of a curve.
template <class Found>
std::vector<Rival> rivals_of(const Found& found) {
  std::vector<Rival> rivals;
  for (const diagnosis::Rival& each : found.tied_with) {
    rivals.push_back({.id = id_of(each.hypothesis), .log_odds = each.log_odds});
  }
  if (!found.tied_with_unknown.empty()) {
    rivals.push_back(
        {.kind = RivalKind::kUnknown,
         .depends_on = found.tied_with_unknown,
         .log_odds = found.unknown_log_odds});
  }
  if (found.tied_with_nothing) {
    rivals.push_back({.kind = RivalKind::kNothing, .log_odds = found.evidence});
  }
  if (!found.settled) rivals.push_back({.kind = RivalKind::kUnsettled});
  if (found.of_a_part()) rivals.push_back({.kind = RivalKind::kLeftOut});
  return rivals;
}

/// RMS of how far the two dials' readings are from each other [mm].
double exchanged_rms(const Readings& readings, const diagnosis::Hypothesis& swap) {
  double squares = 0.0;
  int count = 0;
  for (const simulation::Trial& trial : readings.trials()) {
    const auto& one = trial.reading[static_cast<std::size_t>(swap.place.dial)];
    const auto& other = trial.reading[static_cast<std::size_t>(swap.place.other_dial)];
    if (!one || !other) continue;
    squares += (*one - *other) * (*one - *other);
    ++count;
  }
  return std::sqrt(squares / std::max(1, count));
}

/// Whether so many of the gross readings equal the one before by accident: each does with the
/// chance that an error of its size ends within half a digit of that value.
bool handed_over_twice(
    const Readings& readings, const std::vector<diagnosis::GrossReading>& gross) {
  constexpr double kByAccident = 1e-3;
  double expected = 0.0;
  int stale = 0;
  for (const diagnosis::GrossReading& each : gross) {
    const auto dial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(each.row)].dial);
    const double resolution_mm =
        readings.has_dials() ? readings.model().rig().dials[dial].resolution_mm : 0.0;
    expected += std::min(1.0, resolution_mm / (2.0 * std::abs(each.size_mm)));
    stale += each.stale ? 1 : 0;
  }
  if (stale == 0) return false;
  // P(X >= stale), X of a Poisson law.
  double term = std::exp(-expected);
  double below = term;
  for (int k = 1; k < stale; ++k) {
    term *= expected / k;
    below += term;
  }
  return 1.0 - below < kByAccident;
}

}  // namespace

HypothesisId id_of(const diagnosis::Hypothesis& hypothesis) {
  return {std::string(hypothesis.effect->cause), hypothesis.place.name};
}

std::string dial_name(const Readings& readings, int dial) {
  return readings.channel_name(static_cast<std::size_t>(dial));
}

std::vector<FoundCause> causes_of(const diagnosis::Diagnosis& found, const Readings& readings) {
  std::vector<FoundCause> causes;
  for (const diagnosis::Cause& each : found.causes) {
    FoundCause cause{
        .id = id_of(each.finding.hypothesis),
        .tied_with = rivals_of(each.finding),
        .estimate = each.estimate,
        .delta_bic = each.delta_bic,
        .gain_mm = each.gain_mm,
        .standing = each.confirmed ? Standing::kConfirmed : Standing::kSuspected,
        .on_g1 = each.on_g1,
        .g2_log_odds = each.g2_log_odds,
        .visible_ratio = each.visible_ratio};
    if (found.named.swap && each.finding.hypothesis == *found.named.swap) {
      // Exchanged dials have no size of their own.
      const double rms_mm = exchanged_rms(readings, each.finding.hypothesis);
      cause.estimate = {{"difference_rms", "mm", rms_mm, kNan}};
      cause.visible_ratio = rms_mm / found.noise.sigma_mm;
    }
    causes.push_back(std::move(cause));
  }
  return causes;
}

std::vector<GrossReading> gross_readings_of(
    const diagnosis::Diagnosis& found, const Readings& readings,
    const session::Session& session) {
  const bool twice = handed_over_twice(readings, found.named.gross);
  std::vector<GrossReading> list;
  for (const diagnosis::GrossReading& each : found.named.gross) {
    const diagnosis::Row& row = readings.rows()[static_cast<std::size_t>(each.row)];
    const int index = readings.trials()[static_cast<std::size_t>(row.trial)].sample;
    const session::Sample& sample = session.samples[static_cast<std::size_t>(index)];
    list.push_back(
        {.sample = index,
         .set = sample.set,
         .point = sample.point,
         .repeat = sample.repeat,
         .dial = dial_name(readings, row.dial),
         .size_mm = each.size_mm,
         .stale = twice && each.stale,
         .near_edge = each.near_edge});
  }
  return list;
}

void add_rig_geometry(std::vector<FoundCause>& causes, const diagnosis::Diagnosis& found) {
  if (!found.named.rig_geometry) return;
  // Its sizes: what moved for sure, the most first.
  constexpr double kForSure = 2.0;  // standard deviations
  constexpr std::size_t kMost = 3;
  std::vector<diagnosis::RigSeen> moved;
  for (const diagnosis::RigSeen& each : found.rig) {
    if (!each.stated && std::abs(each.off) > kForSure * each.sd) moved.push_back(each);
  }
  std::ranges::sort(moved, std::greater{}, &diagnosis::RigSeen::ratio);
  FoundCause cause{
      .kind = CauseKind::kRigGeometry,
      .id = {"rig_geometry", "rig"},
      .delta_bic = 2 * *found.named.rig_geometry,
      .gain_mm = kNan,
      .standing = found.rig_confirmed ? Standing::kConfirmed : Standing::kSuspected,
      .on_g1 = found.rig_confirmed,
      .g2_log_odds = kNan,
      .visible_ratio = kNan};
  for (std::size_t i = 0; i < std::min(kMost, moved.size()); ++i) {
    cause.estimate.push_back({moved[i].name, moved[i].unit, moved[i].off, moved[i].sd});
  }
  causes.push_back(std::move(cause));
}

namespace {

/// What a curve does to the readings, over the noise.
double visible(const diagnosis::OwnCurve& curve, const diagnosis::Diagnosis& found) {
  const auto count = static_cast<double>(curve.in_readings_mm.size());
  return std::sqrt(curve.in_readings_mm.squaredNorm() / count) / found.noise.sigma_mm;
}

}  // namespace

namespace {

/// What causes of any curve have in common.
FoundCause cause_of(const diagnosis::OwnCurve& curve, const diagnosis::Diagnosis& found) {
  return {
      .id = id_of({curve.effect, curve.place}),
      .tied_with = rivals_of(curve),
      .delta_bic = 2 * curve.evidence,
      .gain_mm = kNan,
      .standing = curve.confirmed ? Standing::kConfirmed : Standing::kSuspected,
      .on_g1 = curve.on_g1,
      .g2_log_odds = curve.g2_log_odds,
      .visible_ratio = visible(curve, found)};
}

}  // namespace

void add_curve_causes(std::vector<FoundCause>& causes, const diagnosis::Diagnosis& found) {
  for (const diagnosis::DialCurve& each : found.named.dial_curves) {
    FoundCause& cause = causes.emplace_back(cause_of(each, found));
    cause.estimate = {
        {"half_span", "mm", each.half_span, each.half_span_sd},
        {"rms", "mm", each.rms, kNan},
        {"limit", "mm", each.limit_mm, kNan}};
  }
  for (const diagnosis::JointCurve& each : found.named.joint_curves) {
    const char* unit = each.place.slides ? "mm" : "rad";
    FoundCause& cause = causes.emplace_back(cause_of(each, found));
    cause.estimate = {
        {"half_span", unit, each.half_span, each.half_span_sd}, {"rms", unit, each.rms, kNan}};
    if (each.period) cause.estimate.push_back({"period", unit, *each.period, kNan});
  }
}

void add_data_faults(
    std::vector<FoundCause>& causes, const std::vector<GrossReading>& gross,
    std::size_t readings) {
  // Single errors are few. Where they are many, something else may be wrong with all of these.
  std::vector<Rival> rivals;
  if (static_cast<double>(gross.size()) >
      diagnosis::kMostLeftOut * static_cast<double>(readings)) {
    rivals.push_back({.kind = RivalKind::kLeftOut});
  }
  for (const CauseKind kind : {CauseKind::kOutliers, CauseKind::kStaleReadings}) {
    double squares = 0.0;
    double count = 0.0;
    for (const GrossReading& each : gross) {
      if (each.stale != (kind == CauseKind::kStaleReadings)) continue;
      squares += each.size_mm * each.size_mm;
      ++count;
    }
    if (count == 0.0) continue;
    causes.push_back(
        {.kind = kind,
         .id = {kind == CauseKind::kOutliers ? "outliers" : "stale_reading", "samples"},
         .tied_with = rivals,
         .estimate =
             {{"count", "1", count, kNan},
              {"size_rms", "mm", std::sqrt(squares / count), kNan}},
         .delta_bic = kNan,
         .gain_mm = kNan,
         .standing = rivals.empty() ? Standing::kConfirmed : Standing::kSuspected,
         .g2_log_odds = kNan,
         .visible_ratio = kNan});
  }
}

}  // namespace sixdial::studies
