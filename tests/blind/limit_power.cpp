#include "tests/blind/limit_power.h"

#include <cmath>
#include <map>
#include <random>

#include "diagnosis/limits.h"
#include "mock_devices/session_generator.h"
#include "mock_devices/workshop.h"
#include "tests/blind/challenge.h"
#include "tests/blind/workshop.h"

namespace sixdial::blind {
namespace {

constexpr double kNoise_mm = 0.002;
// An effect that would have to be so many times its plausible size is not tried.
constexpr double kAbsurd = 20.0;

/// What is measured, and what its file says of it. `design` draws the robot, where the dials
/// stand and the points; `noise` all that chance does while they are measured.
class Bench {
 public:
  Bench(RigFile file, std::uint64_t design) : design_(design), file_(geometry::default_rig()) {
    world_.rig = file_;
    world_.robot = mock_devices::drawn_robot(file_, design);
    world_.dials = {kNoise_mm, 0.001, 0.0, 0.0};
    world_.warm_up = {.start_c = 20.0, .rise_c = 4.0, .tau_s = 1200.0};
    if (file == RigFile::kExact) return;
    const mock_devices::Misplaced by;
    const mock_devices::Workshop workshop = mock_devices::drawn_workshop(file_, design, by);
    state_deviations(file_, by);
    world_.rig = workshop.world.rig;
    world_.dials = workshop.world.dials;
  }

  [[nodiscard]] const geometry::Rig& file() const { return file_; }

  [[nodiscard]] std::vector<simulation::Trial> session_with(
      std::vector<mock_devices::HiddenEffect> effects, std::uint64_t noise) const {
    mock_devices::World world = world_;
    world.seed = noise;
    world.effects = std::move(effects);
    return trials_of(
        file_,
        mock_devices::generate_session(world, mock_devices::random_plan(file_, design_)));
  }

 private:
  std::uint64_t design_;
  geometry::Rig file_;
  mock_devices::World world_;
};

constexpr int kSamples = 150;

/// An effect as the limit means it: knocks come at any sample, and where a size is the length
/// of several numbers, the generator's amplitude is not only the first of them.
mock_devices::HiddenEffect effect_at(
    const geometry::Rig& rig, const diagnosis::Hypothesis& of, double size,
    std::uint64_t seed) {
  auto effect = mock_devices::make_effect(rig, of.effect->twin, of.place.name, size, seed);
  if (of.effect->is_step) {
    std::mt19937_64 engine(seed * 7 + 3);
    effect.parameters.at("from_sample") =
        std::uniform_int_distribution<int>(1, kSamples - 1)(engine);
  }
  const auto k1 = effect.parameters.find("k1_nmm_per_rad");
  if (k1 == effect.parameters.end()) return effect;
  const double length = std::hypot(1 / k1->second, 1 / effect.parameters.at("k2_nmm_per_rad"));
  return mock_devices::enlarged(effect, size / length);
}

AtLimit tried(
    const Bench& bench, const simulation::ForwardModel& model, const diagnosis::Limit& limit,
    bool of_name, std::uint64_t seed) {
  const auto& hypothesis = limit.hypothesis;
  AtLimit result{std::string(hypothesis.effect->cause), hypothesis.place.name, of_name};
  const auto effect =
      effect_at(model.rig(), hypothesis, of_name ? limit.name : limit.detect, seed);
  diagnosis::Readings readings(model, bench.session_with({effect}, seed));
  const diagnosis::NamedCauses verdict = diagnosis::name_causes(readings);
  result.detected = !verdict.findings.empty() || !verdict.unknown.empty() ||
                    !verdict.dial_curves.empty() || verdict.swap.has_value() ||
                    verdict.rig_geometry.has_value();
  for (const diagnosis::Finding& finding : verdict.findings) {
    const bool own = finding.hypothesis == hypothesis;
    bool in_set = own;
    for (const diagnosis::Rival& rival : finding.tied_with) {
      in_set = in_set || rival.hypothesis == hypothesis;
    }
    if (own && finding.certain()) {
      result.named = true;
    } else if (in_set) {
      result.tied = true;
    } else {
      result.wrong = result.wrong || finding.certain();
    }
  }
  return result;
}

}  // namespace

std::vector<AtLimit> try_limits(std::uint64_t seed, RigFile file, std::string_view only) {
  const Bench bench(file, seed);
  const simulation::ForwardModel model(bench.file());
  diagnosis::Readings readings(model, bench.session_with({}, seed));
  const diagnosis::NamedCauses blank = diagnosis::name_causes(readings);
  std::vector<diagnosis::NotTestable> ignored;
  const auto limits = diagnosis::limits_of(
      readings, blank.baseline, diagnosis::hypotheses_for(readings, ignored), {});
  std::map<std::string, std::vector<const diagnosis::Limit*>> by_cause;
  for (const diagnosis::Limit& each : limits) {
    if (!only.empty() && each.hypothesis.effect->cause != only) continue;
    by_cause[std::string(each.hypothesis.effect->cause)].push_back(&each);
  }
  constexpr std::uint64_t kAnother = 1'000'000'000;  // seeds of other noise
  std::vector<AtLimit> result;
  for (const auto& [cause, places] : by_cause) {
    const diagnosis::Limit& limit = *places[seed % places.size()];
    for (const bool of_name : {false, true}) {
      const double size = of_name ? limit.name : limit.detect;
      if (!std::isfinite(size) || size > kAbsurd * limit.plausible) continue;
      result.push_back(tried(bench, model, limit, of_name, seed + kAnother));
    }
  }
  return result;
}

}  // namespace sixdial::blind
