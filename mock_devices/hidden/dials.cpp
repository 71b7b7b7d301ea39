// What is wrong with a dial: how it stands, its scale, its plunger, its cable.
#include <cmath>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

using geometry::DialGeometry;

constexpr NumberName kGain[] = {{.name = "gain", .scaling = Scaling::kAlike}};
constexpr NumberName kAngle[] = {{.name = "angle_rad", .scaling = Scaling::kAlike}};
constexpr NumberName kChange[] = {{.name = "change_mm", .scaling = Scaling::kAlike}};
constexpr NumberName kWidth[] = {{.name = "width_mm", .scaling = Scaling::kAlike}};
constexpr NumberName kBend[] = {{.name = "bend_mm", .scaling = Scaling::kAlike}};
constexpr NumberName kCyclic[] = {
    {.name = "amplitude_mm", .scaling = Scaling::kAlike},
    {.name = "period_mm"},
    {.name = "phase_rad", .otherwise = 0.0}};
constexpr NumberName kCurve[] = {
    {.name = "rms_mm", .scaling = Scaling::kAlike},
    {.name = "length_mm", .otherwise = 6.0},
    {.name = "seed", .otherwise = 1.0}};

}  // namespace

extern constinit const CauseRow dial_gain{
    .id = "dial_gain",
    .places = each_dial,
    .both_signs = true,
    .least = 1e-4,
    .most = 2e-3,
    .amplitude = "gain [1]",
    .numbers = kGain,
    .draw = as_large,
    .error_mm = [](const ReadyEffect& e, const Moment&, double displacement_mm, int) {
      return e.p[0] * displacement_mm;
    }};

extern constinit const CauseRow dial_lean{
    .id = "dial_lean",
    .places = each_dial,
    .both_signs = true,
    .least = 8e-4,
    .most = 1e-2,
    .amplitude = "angle [rad]",
    .numbers = kAngle,
    .draw = as_large,
    .change_plunger = [](const ReadyEffect& e, const DialGeometry&, Plunger& plunger) {
      plunger.axis = turned(plunger.axis, e.p[0]);
    }};

extern constinit const CauseRow dial_mount{
    .id = "dial_mount",
    .places = each_dial,
    .both_signs = true,
    .least = 2e-3,
    .most = 5e-2,
    .amplitude = "shift along the axis [mm]",
    .numbers = kChange,
    .draw = as_large,
    .change_plunger = [](const ReadyEffect& e, const DialGeometry& dial, Plunger& plunger) {
      plunger.tip_front_mm += e.p[0] * dial.axis;
    }};

extern constinit const CauseRow dial_hysteresis{
    .id = "dial_hysteresis",
    .places = each_dial,
    .least = 1.5e-3,
    .most = 1.2e-2,
    .amplitude = "width [mm]",
    .numbers = kWidth,
    .draw = as_large,
    .error_mm = [](const ReadyEffect& e, const Moment&, double, int direction) {
      return -e.p[0] / 2 * direction;  // friction: the reading lags behind the plunger
    }};

extern constinit const CauseRow dial_cyclic{
    .id = "dial_cyclic",
    .places = each_dial,
    .least = 1e-3,
    .most = 6e-3,
    .amplitude = "amplitude [mm]",
    .numbers = kCyclic,
    .draw =
        [](const Draw& draw) {
          return std::vector<double>{
              draw.amplitude, 1.0 * std::pow(12.0, draw.random.uniform(22)), draw.phase_rad};
        },
    .error_mm =
        [](const ReadyEffect& e, const Moment&, double displacement_mm, int) {
          return e.p[0] * std::sin(kTwoPi * displacement_mm / e.p[1] + e.p[2]);
        }};

extern constinit const CauseRow dial_swap{
    .id = "dial_swap",
    .places =
        [](const geometry::Rig& rig) {
          const std::vector<std::string> dials = each_dial(rig);
          std::vector<std::string> pairs;
          for (std::size_t i = 0; i < dials.size(); ++i) {
            for (std::size_t j = i + 1; j < dials.size(); ++j) {
              pairs.push_back(dials[i] + "," + dials[j]);
            }
          }
          return pairs;
        },
    .least = 1.0,
    .most = 1.0,
    .amplitude = "none",
    .draw = [](const Draw&) { return std::vector<double>{}; },
    .swaps_cables = true};

// A scale that is bent: right in the middle, off by the square of the distance from it.
extern constinit const CauseRow dial_bend{
    .id = "dial_bend",
    .places = each_dial,
    .in_catalogue = false,
    .both_signs = true,
    .least = 1e-3,
    .most = 1e-2,
    .amplitude = "error 10 mm away from the middle [mm]",
    .numbers = kBend,
    .draw = as_large,
    .covariate =
        [](std::string_view where) { return "dial " + std::string(where) + " reading"; },
    .error_mm =
        [](const ReadyEffect& e, const Moment&, double displacement_mm, int) {
          constexpr double kMiddle_mm = 16.0;
          return e.p[0] * std::pow((displacement_mm - kMiddle_mm) / 10.0, 2);
        }};

// A scale that is uneven all along, far beyond what a maker allows: worn, dropped, or dirty.
extern constinit const CauseRow dial_curve{
    .id = "dial_curve",
    .places = each_dial,
    .in_catalogue = false,
    .least = 1e-2,
    .most = 1e-1,
    .amplitude = "rms [mm]",
    .numbers = kCurve,
    .draw =
        [](const Draw& draw) {
          const double length_mm = draw.random.uniform(29, 3.0, 9.0);
          return std::vector<double>{draw.amplitude, length_mm, draw.seed()};
        },
    .covariate =
        [](std::string_view where) { return "dial " + std::string(where) + " reading"; },
    .prepare =
        [](ReadyEffect& e, const Eigen::Vector2d&) {
          e.field = std::make_shared<const SmoothField>(
              SmoothField::of_length(e.p[0], e.p[1], static_cast<std::uint64_t>(e.p[2])));
        },
    .error_mm =
        [](const ReadyEffect& e, const Moment&, double displacement_mm, int) {
          return e.field->at({displacement_mm, 0.0}).x();
        }};

}  // namespace sixdial::mock_devices
