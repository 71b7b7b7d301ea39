// What is wrong with the cuboid and the balls that touch it.
#include "mock_devices/hidden/cause.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {
namespace {

constexpr NumberName kChange[] = {{.name = "change_mm", .scaling = Scaling::kAlike}};
constexpr NumberName kAngle[] = {{.name = "angle_rad", .scaling = Scaling::kAlike}};
constexpr NumberName kOffset[] = {
    {.name = "x_mm", .scaling = Scaling::kAlike}, {.name = "y_mm", .scaling = Scaling::kAlike}};

std::vector<std::string> at_cuboid(const geometry::Rig&) { return {"cuboid"}; }

}  // namespace

extern constinit const CauseRow cuboid_size{
    .id = "cuboid_size",
    .places = at_cuboid,
    .both_signs = true,
    .least = 1e-3,
    .most = 3e-2,
    .amplitude = "change of side [mm]",
    .numbers = kChange,
    .draw = as_large,
    .change_cuboid = [](const ReadyEffect& e, double, CuboidChange& it) {
      it.side_mm += e.p[0];
    }};

extern constinit const CauseRow cuboid_squareness{
    .id = "cuboid_squareness",
    .places = at_cuboid,
    .both_signs = true,
    .least = 5e-5,
    .most = 6e-4,
    .amplitude = "angle [rad]",
    .numbers = kAngle,
    .draw = as_large,
    .change_cuboid = [](const ReadyEffect& e, double, CuboidChange& it) {
      it.shear_rad += e.p[0];
    }};

extern constinit const CauseRow cuboid_offset{
    .id = "cuboid_offset",
    .places = at_cuboid,
    .least = 2e-2,
    .most = 5e-1,
    .amplitude = "distance from E [mm]",
    .numbers = kOffset,
    .draw = in_any_direction,
    .change_cuboid = [](const ReadyEffect& e, double gamma_rad, CuboidChange& it) {
      it.centre_mm += turned(Eigen::Vector2d(e.p[0], e.p[1]), gamma_rad);
    }};

extern constinit const CauseRow tip_radius{
    .id = "tip_radius",
    .places = [](const geometry::Rig&) { return std::vector<std::string>{"dials"}; },
    .both_signs = true,
    .least = 2e-2,
    .most = 2e-1,
    .amplitude = "change of radius [mm]",
    .numbers = kChange,
    .draw = as_large,
    .change_cuboid = [](const ReadyEffect& e, double,
                        CuboidChange& it) { it.tip_radius_mm += e.p[0]; }};

}  // namespace sixdial::mock_devices
