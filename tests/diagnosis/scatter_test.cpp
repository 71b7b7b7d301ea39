// What readings of an arrival share: its algebra against dense matrices, and that a robot which
// scatters gets that verdict and no other.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <string>

#include "calibration/random.h"
#include "diagnosis/diagnosis.h"
#include "diagnosis/shareable.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kRounding = 1e-11;  // of numbers around one

/// Blocks of three, five and four rows, one row that is not counted.
struct Blocks {
  ScatterColumns shared{ScatterOf::kTool, false, Eigen::MatrixXd(12, 2), {0, 3, 8, 12}};
  Eigen::VectorXd root = Eigen::VectorXd(12);
  double ratio = 2.5;
  Eigen::MatrixXd covariance;  // over s^2, of the rows as root weighs them

  Blocks() {
    calibration::RandomSequence random(3, 1);
    for (double& each : shared.columns.reshaped()) each = random.normal();
    for (double& each : root) each = random.uniform(0.4, 1.6);
    const Eigen::MatrixXd B = root.asDiagonal() * shared.columns;
    covariance.setIdentity(12, 12);
    for (std::size_t b = 0; b + 1 < shared.first_row.size(); ++b) {
      const Eigen::Index first = shared.first_row[b];
      const Eigen::Index rows = shared.first_row[b + 1] - first;
      const auto part = B.middleRows(first, rows);
      covariance.block(first, first, rows, rows) += ratio * part * part.transpose();
    }
  }
};

TEST(Whitening, IsTheRootOfTheInverseCovariance) {
  const Blocks blocks;
  const Whitening whitening(blocks.root, &blocks.shared, blocks.ratio);
  const Eigen::MatrixXd W = whitening(Eigen::MatrixXd::Identity(12, 12));
  const Eigen::MatrixXd expected =
      blocks.root.asDiagonal() * blocks.covariance.inverse() * blocks.root.asDiagonal();
  EXPECT_LT((W.transpose() * W - expected).cwiseAbs().maxCoeff(), kRounding);
  const Eigen::MatrixXd back = whitening.transposed(Eigen::MatrixXd::Identity(12, 12));
  EXPECT_LT((back - W.transpose()).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_LT(
      std::abs(whitening.log_volume() - std::log(blocks.covariance.determinant())), kRounding);
  const std::vector<Eigen::Index> some{1, 4, 6, 9};
  Eigen::MatrixXd C(4, 2);
  C << 1, 2, -1, 0.5, 3, 1, 0.2, -2;
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(12, 2);
  for (Eigen::Index i = 0; i < 4; ++i) whole.row(some[static_cast<std::size_t>(i)]) = C.row(i);
  const Eigen::MatrixXd normal = (W * whole).transpose() * (W * whole);
  EXPECT_LT((whitening.normal(C, some) - normal).cwiseAbs().maxCoeff(), kRounding);
}

TEST(Whitening, TellsTheLikeliestShift) {
  const Blocks blocks;
  const Whitening whitening(blocks.root, &blocks.shared, blocks.ratio);
  calibration::RandomSequence random(4, 1);
  Eigen::VectorXd e(12);
  for (double& each : e) each = random.normal();
  // Conditional mean of the shared part of readings D^-1 (shared + noise).
  const Eigen::VectorXd weighted = blocks.root.cwiseProduct(e);
  const Eigen::VectorXd own = blocks.covariance.inverse() * weighted;
  const Eigen::VectorXd shared = (weighted - own).cwiseQuotient(blocks.root);
  EXPECT_LT((whitening.shifts_of(e).in_readings_mm - shared).cwiseAbs().maxCoeff(), kRounding);
  // With the noise that is left it makes up the whole: e'V^-1 e.
  EXPECT_LT(
      std::abs(own.squaredNorm() + whitening.shifts_of(e).squares - weighted.dot(own)),
      kRounding);
  const Eigen::VectorXd left = blocks.covariance.inverse().diagonal();
  EXPECT_LT(
      (whitening.leverage() - (1 - left.array()).matrix()).cwiseAbs().maxCoeff(), kRounding);
}

DiagnosisSettings quick() {
  DiagnosisSettings settings;
  settings.with_gain = false;
  settings.with_limits = false;
  settings.null_draws = 0;
  return settings;
}

Diagnosis diagnosed(const Session& session) {
  return diagnose(session.model, session.trials, session.held_out, quick());
}

std::string said_by(const Diagnosis& verdict) {
  std::string said;
  for (const Cause& cause : verdict.causes) said += cause.finding.hypothesis.name() + " ";
  for (const std::string& each : verdict.unexplained.depends_on) said += "by " + each + " ";
  return said;
}

constexpr int kSessions = 20;

// Of 20 intervals of 95 % all but four hold the truth in 999 of 1000 runs.
constexpr int kFewestHeld = 16;

TEST(Scatter, OfTheToolIsToldWithItsSizeAndNothingElse) {
  calibration::RandomSequence random(1, 7);
  int held = 0;
  std::string other;
  for (int i = 0; i < kSessions; ++i) {
    const double sd_mm = 0.003 * std::pow(7.0, random.uniform(0, 1));
    const Diagnosis verdict = diagnosed(
        session_of({.seed = 200 + static_cast<std::uint64_t>(i), .scatter_mm = sd_mm}));
    other += said_by(verdict);
    EXPECT_TRUE(verdict.unexplained.scatter) << sd_mm;
    const auto& size = verdict.unexplained.scatter_size;
    ASSERT_TRUE(size.has_value()) << sd_mm;
    EXPECT_EQ(size->in, ScatterIn::kTool) << sd_mm;
    held += size->low_mm < sd_mm && sd_mm < size->high_mm;
    EXPECT_LT(size->high_mm, 1.5 * size->low_mm) << "150 arrivals tell it to some per cent";
  }
  EXPECT_EQ(other, "");
  EXPECT_GE(held, kFewestHeld);
}

TEST(Scatter, OfTheRecordedJointValuesNamesNothing) {
  calibration::RandomSequence random(2, 7);
  std::string other;
  int of_joints = 0;
  for (int i = 0; i < kSessions; ++i) {
    const double sd_rad = 3e-5 * std::pow(10.0 / 3.0, random.uniform(0, 1));
    const Diagnosis verdict = diagnosed(
        session_of({.seed = 300 + static_cast<std::uint64_t>(i), .scatter_rad = sd_rad}));
    other += said_by(verdict);
    ASSERT_TRUE(verdict.unexplained.scatter_size.has_value()) << sd_rad;
    of_joints += verdict.unexplained.scatter_size->in == ScatterIn::kJoints;
  }
  EXPECT_EQ(other, "");
  EXPECT_GE(of_joints, kSessions - 2)
      << "of the joints, not of the tool: the cuboid turns with them";
}

TEST(Scatter, HidesNoBacklash) {
  const geometry::Rig rig = geometry::default_rig();
  const Session session = session_of(
      {.effects = {effect_of(rig, "joint_backlash", "joint2", {4e-4})},
       .seed = 8,
       .scatter_mm = 0.005});
  const Diagnosis verdict = diagnosed(session);
  ASSERT_EQ(said_by(verdict), "joint_backlash@joint2 ");
  EXPECT_TRUE(verdict.causes[0].finding.certain());
  const Estimate& size = verdict.causes[0].estimate.at(0);
  EXPECT_LT(std::abs(size.value - 4e-4), 3 * size.sd);
  EXPECT_TRUE(verdict.unexplained.scatter_size.has_value());
}

TEST(Scatter, IsNoGrossError) {
  Session session = session_of({.seed = 12, .scatter_mm = 0.006});
  constexpr int kGross = 18;
  for (int i = 0; i < kGross; ++i) {
    *session.trials[static_cast<std::size_t>(8 * i)].reading[static_cast<std::size_t>(i % 6)] +=
        i % 2 == 0 ? 0.3 : -0.2;
  }
  const Diagnosis verdict = diagnosed(session);
  EXPECT_EQ(said_by(verdict), "");
  EXPECT_EQ(verdict.named.gross.size(), static_cast<std::size_t>(kGross));
  const auto& size = verdict.unexplained.scatter_size;
  ASSERT_TRUE(size.has_value());
  EXPECT_TRUE(size->low_mm < 0.006 && 0.006 < size->high_mm) << size->sd_mm;
}

TEST(Scatter, IsNotWhatIsSmooth) {
  // An encoder whose error no harmonic of a turn describes; all dials alike by the joint's
  // value, which no cause and no smooth function of the search is.
  for (const bool encoder : {true, false}) {
    Session session = session_of({.seed = 14});
    for (simulation::Trial& trial : session.trials) {
      const double wave = std::sin(25.0 * trial.q[0]);
      if (encoder) {
        trial.q[0] += 1e-4 * wave;
      } else {
        for (auto& reading : trial.reading) *reading += 0.006 * wave;
      }
    }
    const Diagnosis verdict = diagnosed(session);
    EXPECT_FALSE(verdict.unexplained.depends_on.empty());
    EXPECT_FALSE(verdict.unexplained.scatter_size.has_value());
    for (const Cause& cause : verdict.causes) {
      EXPECT_FALSE(cause.finding.certain()) << cause.finding.hypothesis.name();
      EXPECT_FALSE(cause.confirmed) << cause.finding.hypothesis.name();
    }
  }
}

TEST(Scatter, IsSharedByTheReadingsOfAStop) {
  Session session = session_of({.points = 60, .repeats = 3, .seed = 15, .scatter_mm = 0.0});
  calibration::RandomSequence random(16, 2);
  double x = 0.0;
  double y = 0.0;
  for (simulation::Trial& trial : session.trials) {
    if (trial.repeat == 0) {
      x = 0.006 * random.normal();
      y = 0.006 * random.normal();
    }
    for (std::size_t d = 0; d < trial.reading.size(); ++d) {
      const Eigen::Vector2d axis = session.model.rig().dials[d].geometry.axis;
      *trial.reading[d] -= axis.dot(Eigen::Vector2d(x, y));
    }
  }
  const Diagnosis verdict = diagnosed(session);
  EXPECT_EQ(said_by(verdict), "");
  ASSERT_TRUE(verdict.named.extended.shared);
  EXPECT_TRUE(verdict.named.extended.shared->of_stops);
  EXPECT_EQ(verdict.noise.source, NoiseSource::kRepeats);
  EXPECT_LT(std::abs(verdict.noise.sigma_mm - kNoise_mm), 0.2 * kNoise_mm);
}

}  // namespace
}  // namespace sixdial::diagnosis
