// An arm calibrated by every instrument that is no position: pose, distances, touches, sockets.
#include "calibration/reading_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/space_fit.h"
#include "geometry/instrument_kind.h"
#include "geometry/robots/serial.h"
#include "geometry/tool.h"

namespace sixdial::calibration {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNoise_mm = 0.01;

class ReadingSpace : public ::testing::TestWithParam<const char*> {
 protected:
  ReadingSpace() {
    const auto example = geometry::find_robot_kind("serial")->example();
    geometry::SerialRobot arm = geometry::serial_robot(*example, example->nominal);
    arm.tool_is_frame = std::string(GetParam()) == "pose";
    rig_.robot.model = geometry::serial_model(arm);
    rig_.robot.nominal = rig_.robot.model->nominal;
    rig_.instrument.kind = GetParam();
    rig_.instrument.dimensions = 3;
    rig_.instrument.sd_mm = kNoise_mm;
    rig_.instrument.sd_rad = kNoise_mm / 500;
    rig_.instrument.anchors = {
        {"K1", Vector3d(1500, 0, 0), 0.5}, {.name = "K2"}, {.name = "K3"}, {.name = "K4"}};
    rig_.instrument.surfaces = {
        {.place = {"bed", Vector3d(0, 0, -300)}},
        {.place = {"wall", Vector3d(900, 0, 0)}, .normal = Vector3d(-1, 0, 0)},
        {.place = {"ball", Vector3d(400, 400, 400), 0.3}, .radius_mm = 20.0}};
    rig_.instrument.sockets = {{.name = "S0"}, {.name = "S1"}, {.name = "S2"}, {.name = "S3"}};
    rig_.instrument.socket_distances = {{"S0", "S1", 0.0, 0.02}, {"S2", "S3", 0.0, 0.02}};
    places_ = {{500, 300, 100}, {800, -200, 300}, {-600, 200, 500}, {300, 700, 250}};
    for (auto& known : rig_.instrument.socket_distances) {
      const bool first = known.first == "S0";
      known.mm = (places_[first ? 0 : 2] - places_[first ? 1 : 3]).norm();
    }
    truth_ = rig_.robot.nominal;
    for (Eigen::Index i = 0; i < truth_.size(); ++i) {
      const auto& info = rig_.robot.model->parameters[static_cast<std::size_t>(i)];
      // The base: an instrument that sees distances of places alone knows no frame.
      if (info.name.starts_with("base")) continue;
      truth_[i] += 0.5 * draw_(random_) * info.change;
    }
  }

  /// Joint values that put the true tool at a place, turned anyhow.
  std::optional<VectorXd> at(const Vector3d& p_WE) {
    const geometry::Tool tool(rig_.robot.model, 3);
    geometry::Pose<double> X;
    X.p = p_WE;
    VectorXd q(6);
    for (double& each : q) each = 2.0 * draw_(random_);
    const auto turned = tool.position(truth_, q, geometry::Assembly::kLeft);
    if (!turned) return std::nullopt;
    std::vector<geometry::Pose<double>> frames(7);
    static_cast<void>(rig_.robot.model->forward(truth_, q, geometry::Assembly::kLeft, frames));
    X.R = frames[0].R;
    const auto found = rig_.robot.model->kind->inverse(
        *rig_.robot.model, {truth_.data(), static_cast<std::size_t>(truth_.size())}, X, {}, {});
    if (!found) return std::nullopt;
    return *found;
  }

  std::vector<simulation::Trial> measured(int count) {
    const auto instrument = geometry::instrument_of(rig_);
    VectorXd x = instrument->nominal;
    const std::string kind = GetParam();
    if (kind == "distance") x << 1500.2, 0.1, -0.3, 0, 1500, 0, 0, -1500, 200, 100, 100, 1800;
    if (kind == "probe") x << 400.1, 399.8, 400.2;
    for (std::size_t k = 0; kind == "socket" && k < 4; ++k) {
      x.segment<3>(static_cast<Eigen::Index>(3 * k)) = places_[k];
    }
    std::vector<simulation::Trial> trials;
    std::normal_distribution<double> noise(0.0, 1.0);
    while (std::ssize(trials) < count) {
      const int i = static_cast<int>(trials.size());
      simulation::Trial trial;
      trial.sample = trial.point = i;
      Vector3d p(draw_(random_) * 600, draw_(random_) * 600, 300 + draw_(random_) * 300);
      if (kind == "socket") p = places_[static_cast<std::size_t>(i % 4)];
      if (kind == "probe" && i % 3 == 0) p.z() = -300;
      if (kind == "probe" && i % 3 == 1) p.x() = 900;
      if (kind == "probe" && i % 3 == 2) {
        p = x + 20 * Vector3d(draw_(random_), draw_(random_), draw_(random_)).normalized();
      }
      const auto q = at(p);
      if (!q) continue;
      trial.q = *q;
      std::vector<geometry::Pose<double>> frames(7);
      EXPECT_TRUE(
          rig_.robot.model->forward(truth_, trial.q, geometry::Assembly::kLeft, frames));
      geometry::Observation seen;
      instrument->kind->observe(
          *instrument, {x.data(), static_cast<std::size_t>(x.size())}, {}, frames, false, seen);
      for (Eigen::Index k = 0; k < seen.reading.size(); ++k) {
        const auto& channel = instrument->channels[static_cast<std::size_t>(k)];
        const bool used = kind == "socket"  ? k / 3 == i % 4
                          : kind == "probe" ? k == i % 3
                                            : true;
        if (used) {
          trial.reading.emplace_back(seen.reading[k] + channel.sd * noise(random_));
        } else {
          trial.reading.emplace_back();
        }
      }
      trials.push_back(std::move(trial));
    }
    return trials;
  }

  geometry::Rig rig_;
  VectorXd truth_;
  std::vector<Vector3d> places_;
  std::mt19937_64 random_{31};
  std::uniform_real_distribution<double> draw_{-1.0, 1.0};
};

TEST_P(ReadingSpace, NominalRecoversWhatTheReadingsTell) {
  const auto trials = measured(160);
  const ObservationSpace space = reading_space(trials, rig_);
  EXPECT_EQ(measured_samples(space), 160);
  SpaceFitSettings settings;
  settings.weighting = Weighting::kBySigma;
  settings.noise_mm = kNoise_mm;
  const SpaceFit fit = fit_space(space, settings);
  ASSERT_EQ(fit.fit.status, FitStatus::kConverged);
  // The weighted residuals are as large as the noise: nothing is left that the model lacks.
  double sum = 0.0;
  int rows = 0;
  for (int i = 0; i < space.samples(); ++i) {
    VectorXd e(space.rows(i));
    ASSERT_TRUE(space.evaluate(i, fit.v, e, nullptr));
    const auto sigma =
        space.sigma_mm.segment(space.first_row[static_cast<std::size_t>(i)], e.size());
    sum += e.cwiseQuotient(sigma).squaredNorm();
    rows += static_cast<int>(e.size());
  }
  const int told = fit.fit.free - fit.fit.held;
  EXPECT_LT(std::abs(sum / (rows - told) - 1.0), 0.35) << rows << " rows, " << told << " told";
}

TEST_P(ReadingSpace, TheJacobianIsTheDerivative) {
  const auto trials = measured(8);
  const ObservationSpace space = reading_space(trials, rig_);
  for (int i = 0; i < space.samples(); ++i) {
    const int n = space.rows(i);
    VectorXd e(n), high(n), low(n);
    Eigen::MatrixXd J(n, space.parameters());
    const VectorXd x = space.nominal;
    ASSERT_TRUE(space.evaluate(i, x, e, &J));
    for (int k = 0; k < space.parameters(); ++k) {
      const double step = 1e-4 * space.scale()[k];
      VectorXd moved = x;
      moved[k] += step;
      ASSERT_TRUE(space.evaluate(i, moved, high, nullptr));
      moved[k] -= 2 * step;
      ASSERT_TRUE(space.evaluate(i, moved, low, nullptr));
      EXPECT_LT((J.col(k) * step * 2 + high - low).norm(), 1e-8)
          << space.parameter_info[static_cast<std::size_t>(k)].name;
    }
  }
}

class PoseSpace : public ReadingSpace {};

TEST_P(PoseSpace, WeighsPlaceAndTurnAlikeAndTakesWholeTurns) {
  std::vector<simulation::Trial> trials = measured(4);
  trials[1].reading[4].reset();              // half a turn is none
  trials[2].reading[0].reset();              // no position: no pose
  rig_.instrument.sd_rad = 0.0;              // what nobody says of angles
  for (simulation::Trial& trial : trials) {  // rows say it of their coordinates
    trial.position_covariance = Vector3d(1e-4, 4e-4, 1e-4).asDiagonal();
  }
  const ObservationSpace space = reading_space(trials, rig_);
  EXPECT_EQ(space.name, "poses");
  ASSERT_EQ(space.first_row, (std::vector<int>{0, 6, 9, 15}));
  EXPECT_TRUE(space.rows_belong_together);
  EXPECT_EQ(space.block(), 3);
  EXPECT_FALSE(space.sigma_is_assumed);
  EXPECT_NEAR(space.sigma_mm[1], 0.02, 1e-12);
  EXPECT_NEAR(space.sigma_mm[4], std::sqrt(2e-4), 1e-12);  // as well as the place, at the lever
  EXPECT_NEAR(space.measured_mm[4], 500.0 * *trials[0].reading[4], 1e-9);
}

INSTANTIATE_TEST_SUITE_P(, PoseSpace, ::testing::Values("pose"), [](const auto& each) {
  return std::string(each.param);
});

INSTANTIATE_TEST_SUITE_P(
    , ReadingSpace, ::testing::Values("pose", "distance", "probe", "socket"),
    [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace sixdial::calibration
