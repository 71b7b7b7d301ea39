// Errors of the tool's position that no catalogue names: a diagnosis should say "unknown", and
// on what they depend.
#include <cmath>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;
using geometry::Rig;

constexpr NumberName kField[] = {
    {.name = "rms_mm", .scaling = Scaling::kAlike},
    {.name = "length_mm"},
    {.name = "seed", .otherwise = 1.0}};
constexpr NumberName kWalk[] = {
    {.name = "mm_per_sqrt_h", .scaling = Scaling::kAlike}, {.name = "seed", .otherwise = 1.0}};
constexpr NumberName kSinusoid[] = {
    {.name = "amplitude_mm", .scaling = Scaling::kAlike},
    {.name = "period_s"},
    {.name = "phase_rad", .otherwise = 0.0},
    {.name = "direction_rad", .otherwise = 0.0}};

std::vector<std::string> at_tool(const Rig&) { return {"tool"}; }
std::string of_time(std::string_view) { return "time"; }

}  // namespace

extern constinit const CauseRow xy_field{
    .id = "xy_field",
    .places = at_tool,
    .in_catalogue = false,
    .least = 1e-3,
    .most = 2e-2,
    .amplitude = "rms [mm]",
    .numbers = kField,
    .draw =
        [](const Draw& draw) {
          const double length_mm = draw.random.uniform(27) < 0.5 ? 60.0 : 25.0;
          return std::vector<double>{draw.amplitude, length_mm, draw.seed()};
        },
    .covariate = [](std::string_view) { return std::string("x"); },
    .prepare =
        [](ReadyEffect& e, const Vector2d&) {
          e.field = std::make_shared<const SmoothField>(
              SmoothField::of_length(e.p[0], e.p[1], static_cast<std::uint64_t>(e.p[2])));
        },
    .shift_tool = [](const ReadyEffect& e, const Moment&, const Rig&, const Vector2d& p_mm,
                     Vector2d& p_WE_mm) { p_WE_mm += e.field->at(p_mm); }};

extern constinit const CauseRow random_walk{
    .id = "random_walk",
    .places = at_tool,
    .in_catalogue = false,
    .least = 5e-3,
    .most = 1e-1,
    .amplitude = "standard deviation after an hour [mm]",
    .numbers = kWalk,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{draw.amplitude, draw.seed()};
        },
    .covariate = of_time,
    .prepare =
        [](ReadyEffect& e, const Vector2d&) {
          e.walk =
              std::make_shared<const RandomWalk>(e.p[0], static_cast<std::uint64_t>(e.p[1]));
        },
    .shift_tool = [](const ReadyEffect& e, const Moment& moment, const Rig&, const Vector2d&,
                     Vector2d& p_WE_mm) { p_WE_mm += e.walk->at(moment.time_s); }};

extern constinit const CauseRow time_sinusoid{
    .id = "time_sinusoid",
    .places = at_tool,
    .in_catalogue = false,
    .least = 1e-3,
    .most = 2e-2,
    .amplitude = "amplitude [mm]",
    .numbers = kSinusoid,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{
              draw.amplitude, 200.0 * std::pow(10.0, draw.random.uniform(22)),
              draw.random.uniform(28, 0.0, kTwoPi), draw.phase_rad};
        },
    .covariate = of_time,
    .shift_tool =
        [](const ReadyEffect& e, const Moment& moment, const Rig&, const Vector2d&,
           Vector2d& p_WE_mm) {
          p_WE_mm +=
              e.p[0] * std::sin(kTwoPi * moment.time_s / e.p[1] + e.p[2]) * direction(e.p[3]);
        }};

}  // namespace sixdial::mock_devices
