// How well a rig is known whose file claims exactness: each kind of quantity by itself.
#include "diagnosis/rig_known.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "calibration/random.h"
#include "diagnosis/joint_fit.h"
#include "simulation/rig_kinds.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

constexpr const char* kAlong = "places of the dials along their axes";

/// All dials elsewhere along their axes, by so much (one standard deviation).
Session shifted(std::uint64_t seed, double sd_mm) {
  Session session = session_of({.seed = seed});
  calibration::RandomSequence random(seed, 11);
  for (std::size_t d = 0; d < session.model.rig().dials.size(); ++d) {
    const double shift_mm = sd_mm * random.normal();
    for (simulation::Trial& trial : session.trials) {
      if (trial.reading[d]) *trial.reading[d] += shift_mm;
    }
  }
  return session;
}

/// By kind: so many times what a workshop knows.
std::map<std::string, double> by_kind(const Readings& readings, const RigKnown& known) {
  const Readings allowing = readings.allowing_rig_by(known.of_a_workshop);
  std::map<std::string, double> result;
  for (const auto& each : allowing.rig_quantities()) {
    result[std::string(simulation::kind_of(each))] = each.times;
  }
  return result;
}

/// Log density of the readings and the kinds' t together, up to a constant.
double log_posterior(const JointFit& fit, const std::map<std::string, double>& kinds) {
  double result = fit.log_likelihood;
  for (const auto& [name, t] : kinds) result -= 0.5 / (t * t) + std::log(t);
  return result;
}

struct Known {
  std::map<std::string, double> before, after;
  JointFit start;
  RigKnown known;
};

Known known_of(const Session& session, double allowed = 1.0) {
  Readings readings(session.model, session.trials);
  readings.place_tool(session.model.nominal());
  readings = readings.allowing_rig(allowed);
  Known result;
  result.start = fit_jointly(readings, session.model.nominal(), {});
  result.known = rig_known(readings, result.start);
  result.after = by_kind(readings, result.known);
  result.before = result.after;
  for (auto& [name, t] : result.before) t = 1.0;
  return result;
}

TEST(RigKnown, AKindThatIsOffByMoreIsKnownLessAndNoOther) {
  constexpr double kSd_mm = 0.3;  // ten times what a workshop knows
  for (const std::uint64_t seed : {51U, 52U, 53U}) {
    const Known found = known_of(shifted(seed, kSd_mm));
    // Six draws and the workshop's own figure: 3 is far below what they may come to.
    EXPECT_GT(found.after.at(kAlong), 3.0) << seed;
    EXPECT_LT(found.after.at("places of the dials across their axes"), 1.2) << seed;
    EXPECT_LT(found.after.at("axes of the dials"), 1.2) << seed;
  }
}

TEST(RigKnown, OfAnExactRigNoKindIsKnownLess) {
  for (const std::uint64_t seed : {61U, 62U, 63U}) {
    for (const auto& [kind, t] : known_of(shifted(seed, 0.0)).after) {
      // Six dials are not all off by chance; one cuboid may seem to be, by the noise.
      const bool of_dials = kind.find("dials") != std::string::npos;
      EXPECT_LT(t, of_dials ? 1.05 : 3.0) << kind << ", seed " << seed;
      EXPECT_GT(t, 0.2) << kind << ", seed " << seed;  // the workshop's own figure holds it
    }
  }
}

TEST(RigKnown, WhatWasAllowedBeforeDoesNotMatter) {
  constexpr double kSettled = 0.02;  // of a fit from another start
  const Session session = shifted(81, 0.1);
  const Known usual = known_of(session);
  for (const double allowed : {0.3, 3.0}) {
    for (const auto& [kind, t] : known_of(session, allowed).after) {
      EXPECT_NEAR(t, usual.after.at(kind), kSettled * t) << kind << ", allowed " << allowed;
    }
  }
}

TEST(RigKnown, NoStepMakesThePosteriorDensitySmaller) {
  constexpr double kOfAFit = 0.01;  // what a settled fit may leave of its likelihood
  for (const double sd_mm : {0.0, 0.03, 0.3}) {
    const Known found = known_of(shifted(71, sd_mm));
    EXPECT_GT(
        log_posterior(found.known.fit, found.after),
        log_posterior(found.start, found.before) - kOfAFit)
        << sd_mm;
  }
}

}  // namespace
}  // namespace sixdial::diagnosis
