// Rigs as they are (spec 8) through `calibrate`: where the file states how well it knows its
// dials, they are fitted along, and the robot that comes out is nearer to the true one than
// where nobody says so; its intervals hold the truth.
#include "studies/seen_rig.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "geometry/tool.h"
#include "mock_devices/workshop.h"
#include "session/trials.h"
#include "simulation/moved_rig.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/conformity.h"
#include "studies/diagnose.h"
#include "studies/measured_positions.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

struct Reached {
  std::vector<double> error_mm;  // mean over G2 by session, after the best rigid alignment
  int inside = 0, of = 0;        // 95 % intervals of parameters

  [[nodiscard]] double median() const {
    std::vector<double> sorted = error_mm;
    std::ranges::nth_element(sorted, sorted.begin() + std::ssize(sorted) / 2);
    return sorted[sorted.size() / 2];
  }
};

/// Distance of what the parameters say from where the true robot stands, once both are laid
/// over each other: where the frame lies no dial knows better than its place.
double off_mm(
    const session::Session& session, const Eigen::VectorXd& v, const Eigen::VectorXd& truth) {
  const geometry::Tool tool(session.rig);
  std::vector<Eigen::Vector2d> said, is;
  for (const simulation::Trial& trial : session::trials_of(session, "G2")) {
    const auto a = tool.position(v, trial.q, trial.assembly);
    const auto b = tool.position(truth, trial.q, trial.assembly);
    if (!a || !b) continue;
    said.emplace_back(*a);
    is.emplace_back(*b);
  }
  const auto n = static_cast<double>(said.size());
  Eigen::Vector2d centre_said = Eigen::Vector2d::Zero(), centre_is = centre_said;
  for (std::size_t i = 0; i < said.size(); ++i) {
    centre_said += said[i] / n;
    centre_is += is[i] / n;
  }
  double dot = 0.0, cross = 0.0;
  for (std::size_t i = 0; i < said.size(); ++i) {
    const Eigen::Vector2d a = said[i] - centre_said, b = is[i] - centre_is;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
  }
  const Eigen::Rotation2Dd turn(std::atan2(cross, dot));
  double sum = 0.0;
  for (std::size_t i = 0; i < said.size(); ++i) {
    sum += (turn * (said[i] - centre_said) - (is[i] - centre_is)).norm();
  }
  return sum / n;
}

void add(
    const mock_devices::Workshop& workshop, const geometry::Rig& file,
    const std::vector<mock_devices::PlannedPose>& plan, const char* method, Reached& reached) {
  session::Session session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(workshop.world, plan), file,
          "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(file), "rig.toml");
  const CalibrationResult result = calibrate(session, {.method = method});
  const Eigen::VectorXd& truth = workshop.world.robot.parameters;
  reached.error_mm.push_back(off_mm(session, result.identified(), truth));
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    const ParameterRow& row = result.parameters[k];
    const double is = truth[static_cast<Eigen::Index>(k)];
    reached.inside += row.low_95 <= is && is <= row.high_95 ? 1 : 0;
    ++reached.of;
  }
}

TEST(SeenRig, CalibratesAWorkshopRigBetterThanAFileThatClaimsExactness) {
  constexpr int kSessions = 24;
  Reached stated, silent;
  const mock_devices::Misplaced by;
  for (std::uint64_t seed = 1; seed <= kSessions; ++seed) {
    const geometry::Rig file = geometry::default_rig();
    const auto workshop = mock_devices::drawn_workshop(file, seed, by);
    const auto plan = mock_devices::random_plan(file, seed, 100, 50);
    geometry::Rig says = file;
    for (geometry::Dial& dial : says.dials) {
      dial.deviations = {
          Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, by.tip_radius_mm};
    }
    says.cuboid.deviations = {by.side_mm, by.squareness_rad, by.offset_mm};
    add(workshop, says, plan, "lm", stated);
    add(workshop, file, plan, "lm", silent);
  }
  std::printf(
      "stated: %.1f um, %.1f %% inside; silent: %.1f um, %.1f %%\n", 1e3 * stated.median(),
      100.0 * stated.inside / stated.of, 1e3 * silent.median(),
      100.0 * silent.inside / silent.of);
  EXPECT_LT(stated.median(), 0.6 * silent.median());
  // 240 intervals of ten parameters that hang together.
  EXPECT_GE(stated.inside, 0.90 * stated.of);
}

/// Of tips, cuboid, its squareness and centre too: what a rig cannot say of itself.
TEST(SeenRig, IntervalsHoldTheTruthOfAllThatIsStated) {
  constexpr int kSessions = 16;
  const mock_devices::Misplaced by{
      .tip_radius_mm = 0.01, .side_mm = 0.01, .squareness_rad = 1e-4, .offset_mm = 0.02};
  const geometry::Rig file = geometry::default_rig();
  Reached stated;
  for (std::uint64_t seed = 101; seed < 101 + kSessions; ++seed) {
    geometry::Rig says = file;
    for (geometry::Dial& dial : says.dials) {
      dial.deviations = {
          Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, by.tip_radius_mm};
    }
    says.cuboid.deviations = {by.side_mm, by.squareness_rad, by.offset_mm};
    add(mock_devices::drawn_workshop(file, seed, by), says,
        mock_devices::random_plan(file, seed, 100, 50), "lm", stated);
  }
  std::printf(
      "%.1f um, %.1f %% inside\n", 1e3 * stated.median(), 100.0 * stated.inside / stated.of);
  EXPECT_GE(stated.inside, 0.88 * stated.of);  // 160 intervals of ten that hang together
}

void expect_same_table(
    const std::optional<std::vector<diagnosis::RigSeen>>& table,
    const std::optional<std::vector<diagnosis::RigSeen>>& other) {
  ASSERT_TRUE(table && other);
  ASSERT_EQ(table->size(), other->size());
  ASSERT_FALSE(table->empty());
  for (std::size_t k = 0; k < table->size(); ++k) {
    const diagnosis::RigSeen& a = table->at(k);
    const diagnosis::RigSeen& b = other->at(k);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.off, b.off) << a.name;
    EXPECT_EQ(a.sd, b.sd) << a.name;
    EXPECT_EQ(a.known_sd, b.known_sd) << a.name;
  }
}

/// The same figures of one rig, whichever command is asked.
TEST(SeenRig, ComparesWithTheRigThatCalibrateSees) {
  const mock_devices::Misplaced by;
  geometry::Rig says = geometry::default_rig();
  for (geometry::Dial& dial : says.dials) {
    dial.deviations = {Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, std::nullopt};
  }
  const auto workshop = mock_devices::drawn_workshop(says, 8, by);
  const auto session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(
              workshop.world, mock_devices::random_plan(says, 8, 60, 20)),
          says, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(says), "rig.toml");
  // Dials that a ruler placed make no robot conform to half of that, however small its errors.
  constexpr double kTolerance_mm = 0.05;
  const CalibrationResult calibrated =
      calibrate(session, {.method = "lm", .tolerance_mm = kTolerance_mm});
  EXPECT_LT(calibrated.method("lm")->g2->max_mm, kTolerance_mm);
  EXPECT_GT(2 * rig_uncertainty(calibrated).mm, 0.02);
  EXPECT_EQ(calibrated.conformity.value().decision, Decision::kUndecided);
  const ComparisonResult compared = compare(session, {.methods = {"lm"}});
  expect_same_table(compared.rig, calibrated.rig);
  const ComparisonResult by_dials = compare(session, {.methods = {"lm"}, .space = "dials"});
  expect_same_table(by_dials.rig, calibrated.rig);
  const auto& found = compared.methods.back().robot.value().parameters;
  ASSERT_EQ(found.size(), calibrated.parameters.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const ParameterRow& row = calibrated.parameters[k];
    EXPECT_NEAR(found[k].second.value, row.identified, 0.01 * row.sd) << row.name;
    // Beside the rig, a comparison counts noise, a calibration what is smooth as well.
    EXPECT_LT(found[k].second.sd, 1.1 * row.sd) << row.name;
    EXPECT_GT(found[k].second.sd, 0.5 * row.sd) << row.name;
  }
}

/// A validation measures the extended model in the frame that it was fitted in, the cuboid's
/// centre included, or every place would be off by what the diagnosis found of the rig.
TEST(SeenRig, PositionsAreMeasuredInTheFrameOfTheFit) {
  const mock_devices::Misplaced by{.side_mm = 0.01, .squareness_rad = 1e-4, .offset_mm = 0.05};
  geometry::Rig says = geometry::default_rig();
  for (geometry::Dial& dial : says.dials) {
    dial.deviations = {Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, std::nullopt};
  }
  says.cuboid.deviations = {by.side_mm, by.squareness_rad, by.offset_mm};
  auto workshop = mock_devices::drawn_workshop(says, 12, by);
  std::erase_if(workshop.world.effects, [](const auto& each) {
    return !each.cause.starts_with("cuboid");  // a robot without faults: its model is the fit
  });
  const auto session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(
              workshop.world, mock_devices::random_plan(says, 12, 100, 40)),
          says, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(says), "rig.toml");
  const DiagnosisResult diagnosed = diagnose(session, {});
  ASSERT_TRUE(diagnosed.extended_fit.rig);
  const PositionOfSample measured = explained_positions(session, session, diagnosed);
  const PositionOfSample by_file = measured_positions(session);
  const geometry::Tool tool(session.rig);
  const std::vector<double>& model = diagnosed.extended_fit.model;
  const Eigen::VectorXd robot =
      Eigen::Map<const Eigen::VectorXd>(model.data(), session.rig.robot.nominal.size());
  double sum_mm = 0.0, by_file_mm = 0.0;
  int count = 0;
  for (const simulation::Trial& trial : session::trials_of(session, "")) {
    const auto i = static_cast<std::size_t>(trial.sample);
    const auto commanded = tool.position(robot, trial.q, trial.assembly);
    if (!commanded || !measured.at(i) || !by_file.at(i)) continue;
    sum_mm += (*measured[i] - *commanded).norm();
    by_file_mm += (*by_file[i] - *commanded).norm();
    ++count;
  }
  ASSERT_GT(count, 100);
  constexpr double kNoise_mm = 0.006;  // of a position: three dials with curves and noise
  EXPECT_LT(sum_mm / count, kNoise_mm);
  EXPECT_GT(by_file_mm / count, 3 * kNoise_mm) << "the dials hardly stand elsewhere";
}

TEST(SeenRig, EveryIdentifierFitsTheRigThatIsSeen) {
  const mock_devices::Misplaced by;
  geometry::Rig says = geometry::default_rig();
  for (geometry::Dial& dial : says.dials) {
    dial.deviations = {Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, std::nullopt};
  }
  const auto workshop = mock_devices::drawn_workshop(says, 5, by);
  const auto plan = mock_devices::random_plan(says, 5, 100, 50);
  for (const char* method : {"ekf", "ekf_dqpso", "tikhonov"}) {
    Reached seen, silent;
    add(workshop, says, plan, method, seen);
    add(workshop, geometry::default_rig(), plan, method, silent);
    EXPECT_LT(seen.median(), silent.median()) << method;
  }
}

TEST(SeenRig, GoesThroughItsTableToTheSameRig) {
  const mock_devices::Misplaced by;
  geometry::Rig says = geometry::default_rig();
  for (geometry::Dial& dial : says.dials) {
    dial.deviations.position_mm = Eigen::Vector2d(by.along_mm, by.across_mm);
  }
  diagnosis::RigFit fit{says, simulation::stated_quantities(says), {}, {}, {}, {}};
  fit.off = Eigen::VectorXd::LinSpaced(std::ssize(fit.quantities), -1.0, 1.0);
  fit.covariance = Eigen::MatrixXd::Identity(fit.off.size(), fit.off.size());
  const geometry::Rig moved = simulation::moved_rig(says, fit.quantities, fit.off);
  const geometry::Rig again = rig_as_seen(says, seen_of(fit));
  for (std::size_t d = 0; d < says.dials.size(); ++d) {
    EXPECT_LT(
        (again.dials[d].geometry.position_mm - moved.dials[d].geometry.position_mm).norm(),
        1e-12);
    EXPECT_GT(
        (again.dials[d].geometry.position_mm - says.dials[d].geometry.position_mm).norm(), 0.0);
  }
  EXPECT_EQ(
      rig_as_seen(says, std::nullopt).dials[0].geometry.position_mm,
      says.dials[0].geometry.position_mm);
}

}  // namespace
}  // namespace sixdial::studies
