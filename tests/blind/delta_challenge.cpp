#include "tests/blind/delta_challenge.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mock_devices/delta_world.h"
#include "mock_devices/random.h"
#include "session/bundle.h"
#include "simulation/forward_model.h"
#include "studies/diagnose.h"

namespace sixdial::blind {
namespace {

using mock_devices::DeltaEffect;
using mock_devices::DeltaRow;
using mock_devices::DeltaWorld;

/// Orthonormal columns of all that parameters of the nominal delta, put where the true one
/// stands, do to the readings of these rows.
Eigen::MatrixXd geometry_of(
    const DeltaWorld& world, const geometry::Rig& rig, const std::vector<DeltaRow>& rows) {
  const simulation::ForwardModel model(rig);
  simulation::ModelVector v = model.nominal();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    v[*model.find(fmt::format("base_{}", name))] = world.base_mm[axis];
    v[*model.find(fmt::format("base_r{}", name))] = world.base_turn_rad[axis];
  }
  const Eigen::Index channels = rows.front().reading.size();
  Eigen::MatrixXd J(channels * std::ssize(rows), model.parameter_count());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto at = model.predict(v, rows[i].q, rig.robot.assembly);
    auto part = J.middleRows(channels * static_cast<Eigen::Index>(i), channels);
    if (at) {
      part = at->reading_J;
    } else {
      part.setZero();
    }
  }
  J.colwise().normalize();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
  qr.setThreshold(1e-9);
  return Eigen::MatrixXd(qr.householderQ() * Eigen::MatrixXd::Identity(J.rows(), qr.rank()));
}

Eigen::VectorXd readings(const std::vector<DeltaRow>& rows) {
  const Eigen::Index channels = rows.front().reading.size();
  Eigen::VectorXd all(channels * std::ssize(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    all.segment(channels * static_cast<Eigen::Index>(i), channels) = rows[i].reading;
  }
  return all;
}

/// What an effect of this size does that geometry cannot imitate, rms over the noise.
double strength_of(
    const DeltaWorld& world, const DeltaEffect& effect, const Eigen::MatrixXd& Q, int g1,
    int g2) {
  DeltaWorld without = world;
  without.effects.clear();
  DeltaWorld with = without;
  with.effects = {effect};
  Eigen::VectorXd d =
      readings(measure_delta(with, g1, g2)) - readings(measure_delta(without, g1, g2));
  d -= Q * (Q.transpose() * d);
  return d.norm() / std::sqrt(static_cast<double>(d.size())) / world.noise_mm;
}

std::string name_of(const DeltaEffect& effect) { return effect.cause + "@" + effect.where; }

}  // namespace

RobotOutcome challenge_delta(const RobotChallenge& of, std::uint64_t seed) {
  const mock_devices::Random random(seed, mock_devices::Stream::kHide, 7);
  DeltaWorld world = mock_devices::drawn_delta(seed);
  const int g1 = 2 * of.samples / 3;
  const int g2 = of.samples - g1;
  const ChallengeFolder folder("delta", seed);
  const std::vector<DeltaRow> clean = measure_delta(world, g1, g2);
  write_delta_bundle(folder.path(), clean, world);
  const geometry::Rig rig = session::read_bundle(folder.path().string()).rig;
  RobotOutcome outcome;
  outcome.robot = fmt::format(
      "{}, {}", world.has_arms ? "arms" : "towers",
      world.anchors_mm.empty() ? "tracker" : "wires");
  outcome.strength = of.causes > 0 ? HUGE_VAL : 0.0;
  const Eigen::MatrixXd Q = geometry_of(world, rig, clean);
  for (std::uint64_t draw = 0; std::ssize(world.effects) < of.causes; ++draw) {
    DeltaEffect effect = draw_delta_effect(world, seed * 1000 + draw);
    const bool there = std::ranges::any_of(world.effects, [&](const DeltaEffect& each) {
      return name_of(each) == name_of(effect);
    });
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
  write_delta_bundle(folder.path(), measure_delta(world, g1, g2), world);
  const studies::DiagnosisRequest quick{
      .seed = 1, .bootstrap = 0, .with_gain = false, .threads = 1};
  const auto result = studies::diagnose(session::read_bundle(folder.path().string()), quick);
  outcome.seconds = result.seconds;
  judge(result, outcome);
  return outcome;
}

}  // namespace sixdial::blind
