#include "tests/blind/arm_challenge.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mock_devices/arm_world.h"
#include "mock_devices/random.h"
#include "session/bundle.h"
#include "simulation/forward_model.h"
#include "studies/diagnose.h"

namespace sixdial::blind {
namespace {

using mock_devices::ArmEffect;
using mock_devices::ArmRow;
using mock_devices::ArmWorld;

/// Orthonormal columns of all that parameters of the nominal arm, put where the true one
/// stands, do to the positions of these rows.
Eigen::MatrixXd geometry_of(
    const ArmWorld& world, const geometry::Rig& rig, const std::vector<ArmRow>& rows) {
  const simulation::ForwardModel model(rig);
  Eigen::MatrixXd J(3 * std::ssize(rows), model.parameter_count());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto at = model.predict(model.nominal(), rows[i].q_rad, geometry::Assembly::kLeft);
    auto part = J.middleRows(3 * static_cast<Eigen::Index>(i), 3);
    if (at) {
      part = at->position_J;
    } else {
      part.setZero();
    }
  }
  // All stands where the file has the arm: the true one is turned against it.
  const double angle = world.base_turn_rad.norm();
  const Eigen::AngleAxisd turn(angle, world.base_turn_rad / angle);
  for (Eigen::Index i = 0; i < J.rows(); i += 3) {
    J.middleRows(i, 3) = (turn.toRotationMatrix() * J.middleRows(i, 3)).eval();
  }
  J.colwise().normalize();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
  qr.setThreshold(1e-9);
  return Eigen::MatrixXd(qr.householderQ() * Eigen::MatrixXd::Identity(J.rows(), qr.rank()));
}

Eigen::VectorXd positions(const std::vector<ArmRow>& rows) {
  Eigen::VectorXd all(3 * std::ssize(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = rows[i].p_mm;
  }
  return all;
}

/// What an effect of this size does that geometry cannot imitate, rms over the noise.
double strength_of(
    const ArmWorld& world, const ArmEffect& effect, const Eigen::MatrixXd& Q, int g1, int g2) {
  ArmWorld without = world;
  without.effects.clear();
  ArmWorld with = without;
  with.effects = {effect};
  Eigen::VectorXd d =
      positions(measure_arm(with, g1, g2)) - positions(measure_arm(without, g1, g2));
  d -= Q * (Q.transpose() * d);
  return d.norm() / std::sqrt(static_cast<double>(d.size())) / world.noise_mm;
}

std::string name_of(const ArmEffect& effect) { return effect.cause + "@" + effect.where; }

}  // namespace

RobotOutcome challenge_arm(const RobotChallenge& of, std::uint64_t seed) {
  const mock_devices::Random random(seed, mock_devices::Stream::kHide, 7);
  ArmWorld world = mock_devices::drawn_arm(seed);
  const int g1 = 2 * of.samples / 3;
  const int g2 = of.samples - g1;
  const ChallengeFolder folder("arm", seed);
  write_arm_bundle(folder.path(), measure_arm(world, g1, g2), world);
  const geometry::Rig rig = session::read_bundle(folder.path().string()).rig;
  RobotOutcome outcome;
  outcome.robot = fmt::format("{} joints", world.nominal.size());
  outcome.strength = of.causes > 0 ? HUGE_VAL : 0.0;
  const Eigen::MatrixXd Q = geometry_of(world, rig, measure_arm(world, g1, g2));
  for (std::uint64_t draw = 0; std::ssize(world.effects) < of.causes; ++draw) {
    ArmEffect effect = draw_arm_effect(world, seed * 1000 + draw);
    const bool there = std::ranges::any_of(
        world.effects, [&](const ArmEffect& each) { return name_of(each) == name_of(effect); });
    const double strength = strength_of(world, effect, Q, g1, g2);
    const double wanted = std::exp(random.uniform(draw, std::log(of.low), std::log(of.high)));
    const double times = wanted / strength;
    constexpr double kAbsurd = 20.0;  // times what is drawn: geometry takes it over
    if (there || !(strength > 0.0) || times > kAbsurd) continue;
    effect.amplitude *= times;
    outcome.strength = std::min(outcome.strength, wanted);
    outcome.truth.push_back(name_of(effect));
    world.effects.push_back(std::move(effect));
  }
  write_arm_bundle(folder.path(), measure_arm(world, g1, g2), world);
  const studies::DiagnosisRequest quick{
      .seed = 1, .bootstrap = 0, .with_gain = false, .threads = 1};
  const auto result = studies::diagnose(session::read_bundle(folder.path().string()), quick);
  outcome.seconds = result.seconds;
  judge(result, outcome);
  return outcome;
}

}  // namespace sixdial::blind
