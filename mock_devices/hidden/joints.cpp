// What is wrong with a joint: its gear, its encoder, its stiffness.
#include <cmath>
#include <stdexcept>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr NumberName kWave[] = {
    {.name = "a_rad", .scaling = Scaling::kAlike},
    {.name = "b_rad", .scaling = Scaling::kAlike}};

template <int waves>
void wave(const ReadyEffect& e, const Moment&, const Vector2d& q_rad, Vector2d& theta_rad) {
  const double turn = waves * q_rad[e.joint];
  theta_rad[e.joint] += e.p[0] * std::sin(turn) + e.p[1] * std::cos(turn);
}

constexpr NumberName kGain[] = {
    {.name = "gain", .scaling = Scaling::kAlike}, {.name = "mid_rad", .otherwise = NAN}};
constexpr NumberName kBacklash[] = {{.name = "b_rad", .scaling = Scaling::kAlike}};
constexpr NumberName kStiffness[] = {
    {.name = "k1_nmm_per_rad", .scaling = Scaling::kInversely},
    {.name = "k2_nmm_per_rad", .scaling = Scaling::kInversely}};

}  // namespace

extern constinit const CauseRow joint_eccentricity{
    .id = "joint_eccentricity",
    .places = each_joint,
    .least = 8e-4,
    .most = 8e-3,
    .amplitude = "amplitude [rad]",
    .numbers = kWave,
    .draw = in_any_direction,
    .turn_joints = wave<1>};

extern constinit const CauseRow joint_second_harmonic{
    .id = "joint_second_harmonic",
    .places = each_joint,
    .least = 6e-5,
    .most = 1e-3,
    .amplitude = "amplitude [rad]",
    .numbers = kWave,
    .draw = in_any_direction,
    .turn_joints = wave<2>};

extern constinit const CauseRow joint_fifth_harmonic{
    .id = "joint_fifth_harmonic",
    .places = each_joint,
    .in_catalogue = false,
    .least = 2e-5,
    .most = 3e-4,
    .amplitude = "amplitude [rad]",
    .numbers = kWave,
    .draw = in_any_direction,
    .covariate = [](std::string_view where) { return "theta" + std::string(where.substr(5)); },
    .turn_joints = wave<5>};

extern constinit const CauseRow joint_gain{
    .id = "joint_gain",
    .places = each_joint,
    .both_signs = true,
    .least = 2e-4,
    .most = 4e-3,
    .amplitude = "gain [1]",
    .numbers = kGain,
    .draw = as_large,
    .prepare =
        [](ReadyEffect& e, const Vector2d& q_reference) {
          if (std::isnan(e.p[1])) e.p[1] = q_reference[e.joint];
        },
    .turn_joints =
        [](const ReadyEffect& e, const Moment&, const Vector2d& q_rad, Vector2d& theta_rad) {
          theta_rad[e.joint] += e.p[0] * (q_rad[e.joint] - e.p[1]);
        }};

extern constinit const CauseRow joint_backlash{
    .id = "joint_backlash",
    .places = each_joint,
    .least = 2e-5,
    .most = 4e-4,
    .amplitude = "width [rad]",
    .numbers = kBacklash,
    .draw = as_large,
    .turn_joints = [](const ReadyEffect& e, const Moment& moment, const Vector2d&,
                      Vector2d& theta_rad) {
      theta_rad[e.joint] -= e.p[0] / 2 * moment.approach[static_cast<std::size_t>(e.joint)];
    }};

// The springs of the plungers turn the joints: world.cpp balances torque and stiffness.
extern constinit const CauseRow joint_compliance{
    .id = "joint_compliance",
    .places = [](const geometry::Rig&) { return std::vector<std::string>{"joints"}; },
    .least = 3e-7,
    .most = 3e-6,
    .amplitude = "compliance [rad/(N mm)]",
    .numbers = kStiffness,
    .draw =
        [](const Draw& draw) {
          if (draw.amplitude <= 0.0) {
            throw std::invalid_argument("joint_compliance must be positive");
          }
          return std::vector<double>{
              1.0 / draw.amplitude, draw.random.uniform(21, 0.5, 2.0) / draw.amplitude};
        },
    .compliance = [](const ReadyEffect& e) { return Vector2d(1.0 / e.p[0], 1.0 / e.p[1]); }};

}  // namespace sixdial::mock_devices
