// What is wrong with the arm between its joints and its tool, its base and its frame.
#include <cmath>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;
using geometry::Rig;

constexpr double kReference_c = 20.0;  // of the links' lengths, ISO 1

constexpr NumberName kGrowth[] = {
    {.name = "per_k", .scaling = Scaling::kAlike},
    {.name = "reference_c", .otherwise = kReference_c}};
constexpr NumberName kClearance[] = {{.name = "c_mm", .scaling = Scaling::kAlike}};
constexpr NumberName kDrift[] = {
    {.name = "x_mm_per_h", .scaling = Scaling::kAlike},
    {.name = "y_mm_per_h", .scaling = Scaling::kAlike}};
constexpr NumberName kAngle[] = {{.name = "angle_rad", .scaling = Scaling::kAlike}};
constexpr NumberName kCreep[] = {
    {.name = "amount", .scaling = Scaling::kAlike, .unit_by_place = true},
    {.name = "period_s"}};

constexpr std::array<std::string_view, 4> kLinks{"l11", "l12", "l21", "l22"};

std::string of_time(std::string_view) { return "time"; }

/// What has crept by now: fast at first, and levelling off.
double crept(const ReadyEffect& e, double time_s) {
  return e.p[0] * -std::expm1(-time_s / e.p[1]);
}

}  // namespace

extern constinit const CauseRow link_thermal_growth{
    .id = "link_thermal_growth",
    .places = [](const Rig&) { return std::vector<std::string>{"links"}; },
    .least = 5e-6,
    .most = 4e-5,
    .amplitude = "expansion [1/K]",
    .numbers = kGrowth,
    .draw = as_large,
    .change_arm =
        [](const ReadyEffect& e, const Moment& moment, ArmChange& arm) {
          arm.v.head<4>() *= 1.0 + e.p[0] * (moment.temperature_c - e.p[1]);
        }};

extern constinit const CauseRow passive_clearance{
    .id = "passive_clearance",
    .places = [](const Rig&) { return std::vector<std::string>{"elbows"}; },
    .least = 5e-4,
    .most = 1e-2,
    .amplitude = "shift along the direction of travel [mm]",
    .numbers = kClearance,
    .draw = as_large,
    .shift_tool = [](const ReadyEffect& e, const Moment& moment, const Rig&, const Vector2d&,
                     Vector2d& p_WE_mm) { p_WE_mm += e.p[0] * moment.travel; }};

extern constinit const CauseRow base_drift{
    .id = "base_drift",
    .places = [](const Rig&) { return std::vector<std::string>{"base"}; },
    .least = 1e-2,
    .most = 3e-1,
    .amplitude = "speed [mm/h]",
    .numbers = kDrift,
    .draw = in_any_direction,
    .change_arm =
        [](const ReadyEffect& e, const Moment& moment, ArmChange& arm) {
          arm.v.segment<2>(geometry::kX0) +=
              Vector2d(e.p[0], e.p[1]) * (moment.time_s / 3600.0);
        }};

extern constinit const CauseRow frame_skew{
    .id = "frame_skew",
    .places = [](const Rig&) { return std::vector<std::string>{"frame"}; },
    .both_signs = true,
    .least = 5e-5,
    .most = 1e-3,
    .amplitude = "angle [rad]",
    .numbers = kAngle,
    .draw = as_large,
    .shift_tool =
        [](const ReadyEffect& e, const Moment&, const Rig& rig, const Vector2d& p_mm,
           Vector2d& p_WE_mm) {
          p_WE_mm.x() += std::tan(e.p[0]) * (p_mm.y() - rig.cuboid.reference_pose_mm.y());
        }};

// Something in the arm gives way: fast at first, then ever slower.
extern constinit const CauseRow creep{
    .id = "creep",
    .places =
        [](const Rig& rig) {
          std::vector<std::string> all = each_joint(rig);
          all.insert(all.end(), kLinks.begin(), kLinks.end());
          return all;
        },
    .in_catalogue = false,
    .both_signs = true,
    .least = 2e-3,
    .most = 4e-2,
    .amplitude = "change in the end [mm] of a link, turn [rad] of a joint",
    .numbers = kCreep,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{
              draw.amplitude, 300.0 * std::pow(20.0, draw.random.uniform(22))};
        },
    .covariate = of_time,
    .prepare =
        [](ReadyEffect& e, const Vector2d&) {
          for (std::size_t i = 0; i < kLinks.size(); ++i) {
            if (e.where == kLinks[i]) e.link = static_cast<int>(i);
          }
        },
    .turn_joints =
        [](const ReadyEffect& e, const Moment& moment, const Vector2d&, Vector2d& theta_rad) {
          if (e.joint >= 0) theta_rad[e.joint] += crept(e, moment.time_s);
        },
    .change_arm =
        [](const ReadyEffect& e, const Moment& moment, ArmChange& arm) {
          if (e.link >= 0) arm.v[e.link] += crept(e, moment.time_s);
        }};

}  // namespace sixdial::mock_devices
