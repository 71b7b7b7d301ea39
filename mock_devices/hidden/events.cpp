// What happens at a moment or to single readings: a knock, gross errors, stale readings.
#include <cmath>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr NumberName kStep[] = {
    {.name = "from_sample"},
    {.name = "amount", .scaling = Scaling::kAlike, .unit_by_place = true},
    {.name = "direction_rad", .otherwise = 0.0}};
constexpr NumberName kOutliers[] = {
    {.name = "share"}, {.name = "size_mm"}, {.name = "seed", .otherwise = 1.0}};
constexpr NumberName kStale[] = {
    {.name = "share"},
    {.name = "whole_scan", .otherwise = 1.0},
    {.name = "seed", .otherwise = 1.0}};

std::vector<std::string> at_samples(const geometry::Rig&) { return {"samples"}; }

bool is_after(const ReadyEffect& e, const Moment& moment) {
  return static_cast<double>(moment.sample) >= e.p[0];
}

}  // namespace

extern constinit const CauseRow step{
    .id = "step",
    .places =
        [](const geometry::Rig& rig) {
          std::vector<std::string> all{"base"};
          for (const std::string& joint : each_joint(rig)) all.push_back(joint);
          all.emplace_back("cuboid");
          for (const std::string& dial : each_dial(rig)) all.push_back(dial);
          return all;
        },
    .both_signs = true,
    .least = 2e-3,
    .most = 4e-2,
    .amplitude = "shift [mm] of a dial or the base, turn [rad] of a joint or the cuboid",
    .numbers = kStep,
    .draw =
        [](const Draw& draw) {
          std::vector<double> numbers{
              std::floor(draw.samples * draw.random.uniform(23, 0.25, 0.75)), draw.amplitude};
          if (draw.where == "base") numbers.push_back(draw.phase_rad);
          return numbers;
        },
    .turn_joints =
        [](const ReadyEffect& e, const Moment& moment, const Vector2d&, Vector2d& theta_rad) {
          if (e.joint >= 0 && is_after(e, moment)) theta_rad[e.joint] += e.p[1];
        },
    .change_arm =
        [](const ReadyEffect& e, const Moment& moment, ArmChange& arm) {
          if (!is_after(e, moment)) return;
          if (e.where == "base") {
            arm.v.segment<2>(geometry::kX0) += e.p[1] * direction(e.p[2]);
          }
          if (e.where == "cuboid") arm.clamp_rad += e.p[1];
        },
    .error_mm = [](const ReadyEffect& e, const Moment& moment, double,
                   int) { return is_after(e, moment) ? e.p[1] : 0.0; }};

extern constinit const CauseRow outliers{
    .id = "outliers",
    .places = at_samples,
    .least = 5e-2,
    .most = 5e-1,
    .amplitude = "largest error [mm]",
    .numbers = kOutliers,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{
              draw.random.uniform(24, 0.02, 0.05), std::abs(draw.amplitude), draw.seed()};
        },
    .is_data_fault = true,
    .gross_mm =
        [](const ReadyEffect& e, std::size_t dial, std::int64_t sample) {
          const Random random(
              static_cast<std::uint64_t>(e.p[2]), Stream::kOutlier,
              static_cast<std::uint32_t>(dial));
          const auto counter = static_cast<std::uint64_t>(sample) * 4;
          if (random.uniform(counter) >= e.p[0]) return 0.0;
          const double size_mm = random.uniform(counter + 1, 0.25, 1.0) * e.p[1];
          return random.uniform(counter + 2) < 0.5 ? -size_mm : size_mm;
        }};

extern constinit const CauseRow stale_reading{
    .id = "stale_reading",
    .places = at_samples,
    .least = 1e-2,
    .most = 6e-2,
    .amplitude = "share of samples [1]",
    .numbers = kStale,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{
              std::abs(draw.amplitude), draw.random.uniform(26) < 0.5 ? 1.0 : 0.0, draw.seed()};
        },
    .is_data_fault = true,
    .is_stale =
        [](const ReadyEffect& e, std::size_t dial, std::int64_t sample) {
          if (sample <= 0) return false;
          const auto place = static_cast<std::uint32_t>(e.p[1] != 0.0 ? 0 : dial + 1);
          const Random random(static_cast<std::uint64_t>(e.p[2]), Stream::kStale, place);
          return random.uniform(static_cast<std::uint64_t>(sample)) < e.p[0];
        }};

}  // namespace sixdial::mock_devices
