// The laws that every identifier keeps in every observation space.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/identifiability.h"
#include "calibration/identifier.h"
#include "calibration/random.h"
#include "geometry/instruments/contact.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::VectorXd;
using testing::DialSession;
using testing::SessionPlan;
using testing::simulate_dials;

// Readings of 50 mm through a fit that stops when its steps are 1e-14 of the parameters.
constexpr double kRounding_mm = 1e-9;
constexpr double kNoise_mm = 0.002;

IdentifySettings quick() {
  IdentifySettings settings;
  settings.qpso1 = {10, 8};
  settings.qpso2 = {30, 160};
  return settings;
}

/// The same poses measured again.
DialSession with_noise(DialSession session, std::uint64_t seed) {
  RandomSequence random(seed, 77);
  const auto dials = session.rig.dial_geometries();
  for (simulation::Trial& trial : session.g1) {
    std::vector<geometry::DialReading> readings;
    for (std::size_t d = 0; d < dials.size(); ++d) {
      if (!trial.reading[d]) continue;
      *trial.reading[d] += kNoise_mm * random.normal();
      readings.push_back({static_cast<int>(d), *trial.reading[d], kNoise_mm});
    }
    const auto at = geometry::best_active_three(
        dials, readings, session.rig.cuboid.side_mm, *trial.gamma_rad);
    trial.position_mm = at.value().pose.p_WE;
  }
  return session;
}

struct Case {
  const Identifier* identifier;
  bool dials;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const Identifier* each : all_identifiers()) {
    cases.push_back({each, false});
    cases.push_back({each, true});
  }
  return cases;
}

class EveryIdentifierInEverySpace : public ::testing::TestWithParam<Case> {
 protected:
  [[nodiscard]] ObservationSpace space_of(const DialSession& session) const {
    if (GetParam().dials) return dial_space(session.g1, session.rig);
    return position_space(position_observations(session.g1), session.rig.robot.nominal);
  }
  [[nodiscard]] static VectorXd truth(
      const ObservationSpace& space, const DialSession& session) {
    VectorXd x(space.parameters());
    x.head<geometry::kParameterCount>() = session.robot;
    if (x.size() > geometry::kParameterCount) x[geometry::kParameterCount] = session.clamp_rad;
    return x;
  }
  [[nodiscard]] Identified run(
      const ObservationSpace& space, const IdentifySettings& settings = quick()) const {
    return identify(*GetParam().identifier, space, settings);
  }
  /// One step, or one pass: near the minimum, not at it.
  [[nodiscard]] bool one_pass() const {
    const auto name = GetParam().identifier->name;
    return name == "lse" || name == "ekf" || name == "ekf_qpso1";
  }
  [[nodiscard]] bool searches() const {
    return GetParam().identifier->name.find("qpso") != std::string_view::npos;
  }
  static SessionPlan plan(int points = 40, double noise_mm = kNoise_mm) {
    SessionPlan result;
    result.g1_points = points;
    result.g2_points = 20;
    result.noise_mm = noise_mm;
    return result;
  }
};

TEST_P(EveryIdentifierInEverySpace, TruthHasZeroResidual) {
  const auto session = simulate_dials(plan(40, 0.0), 21);
  const auto space = space_of(session);
  EXPECT_GT(space.rmse(space.nominal), 1.0);
  EXPECT_LT(space.rmse(truth(space, session)), kRounding_mm);
}

TEST_P(EveryIdentifierInEverySpace, APerfectStartStays) {
  SessionPlan perfect = plan(40, 0.0);
  perfect.robot = perfect.nominal;
  DialSession session = simulate_dials(perfect, 22);
  auto space = space_of(session);
  if (space.parameters() > geometry::kParameterCount) {
    space.nominal[geometry::kParameterCount] = session.clamp_rad;
  }
  const auto found = run(space);
  EXPECT_LT((found.x - space.nominal).cwiseQuotient(space.scale()).norm(), 1e-8);
}

TEST_P(EveryIdentifierInEverySpace, LockedParametersDoNotMove) {
  const auto session = simulate_dials(plan(), 23);
  const auto space = space_of(session);
  IdentifySettings settings = quick();
  const std::vector<std::string> names{"l21", "x0", "dtheta1"};
  settings.fixed = fixed_by_name(space, names).value();
  const auto found = run(space, settings);
  for (const std::string& name : names) {
    const int i = space.find(name).value();
    EXPECT_EQ(found.x[i], space.nominal[i]) << name;
    EXPECT_EQ(found.covariance(i, i), 0.0) << name;
  }
  EXPECT_EQ(found.fit.free, space.parameters() - 3);
  EXPECT_LT(found.rmse, space.rmse(space.nominal));
}

TEST_P(EveryIdentifierInEverySpace, TwiceAndWithTwoThreadsIsTheSame) {
  const auto session = simulate_dials(plan(), 24);
  const auto space = space_of(session);
  IdentifySettings settings = quick();
  settings.qpso2 = {20, 40};
  const auto one = run(space, settings);
  settings.threads = 2;
  const auto two = run(space, settings);
  EXPECT_EQ(one.x, run(space, settings).x);
  EXPECT_EQ(one.x, two.x);
}

TEST_P(EveryIdentifierInEverySpace, APerturbedStartRecoversAndFreshPosesAgree) {
  int outside = 0;
  int tried = 0;
  const int sessions = searches() && GetParam().dials ? 3 : 10;
  for (int k = 0; k < sessions; ++k) {
    const auto seed = static_cast<std::uint64_t>(30 + k);
    SessionPlan perturbed = plan(60);
    perturbed.robot = testing::random_robot(perturbed.nominal, seed);
    const auto session = simulate_dials(perturbed, seed);
    const auto space = space_of(session);
    const auto found = run(space);
    const auto fresh =
        position_space(position_observations(session.g2), session.rig.robot.nominal);
    const double after = fresh.rmse(found.x.head<geometry::kParameterCount>());
    EXPECT_LT(after, one_pass() ? 0.2 * fresh.rmse(session.rig.robot.nominal) : 0.006);
    const VectorXd missed = found.x - truth(space, session);
    for (int i = 0; i < space.parameters() && !one_pass(); ++i) {
      outside += std::abs(missed[i]) > 3.0 * std::sqrt(found.covariance(i, i)) ? 1 : 0;
      ++tried;
    }
  }
  if (one_pass()) return;
  EXPECT_GE(tried, 30);
  EXPECT_LE(outside, std::max(2, tried / 30));  // 0.3 % by chance, in groups: correlated
}

TEST_P(EveryIdentifierInEverySpace, CovarianceMatchesTheSpreadOfSeededRepeats) {
  const int repeats = searches() && GetParam().dials ? 40 : 200;
  const int points = GetParam().dials ? 30 : 60;
  Eigen::MatrixXd found;
  VectorXd predicted;
  const auto exact = simulate_dials(plan(points, 0.0), 5000);
  for (int k = 0; k < repeats; ++k) {
    const auto noisy = with_noise(exact, static_cast<std::uint64_t>(6000 + k));
    const auto space = space_of(noisy);
    const auto identified = run(space);
    if (k == 0) {
      found.resize(space.parameters(), repeats);
      predicted = VectorXd::Zero(space.parameters());
    }
    found.col(k) = identified.x;
    predicted += identified.covariance.diagonal() / repeats;
  }
  const VectorXd mean = found.rowwise().mean();
  // Spread of a spread from so many repeats, five of them, and ten per cent for what is not
  // linear.
  double tolerance = 5.0 / std::sqrt(2.0 * repeats) + 0.1;
  // The covariance is that of the filter with the noise that was found; that a short search
  // finds another Q and R for other readings comes on top.
  if (GetParam().identifier->name == "ekf_qpso1") tolerance += 0.6;
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    const double spread =
        std::sqrt((found.row(i).array() - mean[i]).square().sum() / (repeats - 1));
    EXPECT_LT(std::abs(std::log(spread / std::sqrt(predicted[i]))), tolerance)
        << "parameter " << i << ": spread " << spread << ", predicted "
        << std::sqrt(predicted[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryIdentifierInEverySpace, ::testing::ValuesIn(all_cases()), [](const auto& each) {
      return std::string(each.param.identifier->name) +
             (each.param.dials ? "_on_dials" : "_on_positions");
    });

}  // namespace
}  // namespace sixdial::calibration
