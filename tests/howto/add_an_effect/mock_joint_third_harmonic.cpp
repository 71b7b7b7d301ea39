// The twin of CONTRIBUTING.md's "Add an effect": the same error of the true joint, worked out
// here from a phase instead of sine and cosine.
#include <cmath>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

constexpr NumberName kWave[] = {
    {.name = "amplitude_rad", .scaling = Scaling::kAlike}, {.name = "phase_rad"}};

}  // namespace

extern constinit const CauseRow joint_third_harmonic{
    .id = "joint_third_harmonic",
    .places = each_joint,
    .least = 5e-5,
    .most = 8e-4,
    .amplitude = "amplitude [rad]",
    .numbers = kWave,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{draw.amplitude, draw.phase_rad};
        },
    .turn_joints =
        [](const ReadyEffect& e, const Moment&, const Eigen::Vector2d& q_rad,
           Eigen::Vector2d& theta_rad) {
          theta_rad[e.joint] += e.p[0] * std::sin(3 * q_rad[e.joint] + e.p[1]);
        }};

}  // namespace sixdial::mock_devices
