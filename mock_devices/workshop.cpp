#include "mock_devices/workshop.h"

#include <string>
#include <utility>
#include <vector>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

/// The next number of each call, from one seed.
class Drawing {
 public:
  explicit Drawing(std::uint64_t seed) : random_(seed, Stream::kWorkshop) {}
  [[nodiscard]] double normal(double sd) { return sd * random_.normal(counter_++); }
  [[nodiscard]] double between(double low, double high) {
    return random_.uniform(counter_++, low, high);
  }

 private:
  Random random_;
  std::uint64_t counter_ = 0;
};

void misplace(World& world, const Misplaced& by, Drawing& draw, std::uint64_t seed) {
  for (geometry::Dial& dial : world.rig.dials) {
    geometry::DialGeometry& there = dial.geometry;
    const Eigen::Vector2d across(-there.axis.y(), there.axis.x());
    there.position_mm +=
        draw.normal(by.along_mm) * there.axis + draw.normal(by.across_mm) * across;
    there.axis = turned(there.axis, draw.normal(by.axis_rad));
    there.tip_radius_mm += draw.normal(by.tip_radius_mm);
  }
  world.rig.cuboid.side_mm += draw.normal(by.side_mm);
  const auto hide = [&](const char* cause, double sd) {
    if (sd <= 0.0) return;
    world.effects.push_back(make_effect(world.rig, cause, "cuboid", draw.normal(sd), seed));
  };
  hide("cuboid_squareness", by.squareness_rad);
  if (by.offset_mm <= 0.0) return;
  // Each axis by itself: the distance that one effect is given would be a single draw.
  HiddenEffect offset = make_effect(world.rig, "cuboid_offset", "cuboid", by.offset_mm, seed);
  offset.parameters.at("x_mm") = draw.normal(by.offset_mm);
  offset.parameters.at("y_mm") = draw.normal(by.offset_mm);
  world.effects.push_back(std::move(offset));
}

void wear(World& world, Drawing& draw, std::uint64_t seed, int samples) {
  const geometry::Rig& rig = world.rig;
  const auto hide = [&](const char* cause, const std::string& where, double amplitude) {
    world.effects.push_back(make_effect(rig, cause, where, amplitude, seed++, samples));
  };
  hide("joint_eccentricity", "joint1", draw.between(5e-5, 4e-4));
  hide("joint_eccentricity", "joint2", draw.between(5e-5, 4e-4));
  hide("link_thermal_growth", "links", draw.between(1.1e-5, 2.4e-5));  // steel to aluminium
  hide("base_drift", "base", draw.between(2e-3, 2e-2));                // [mm/h]
}

}  // namespace

Workshop drawn_workshop(
    const geometry::Rig& file, std::uint64_t seed, const Misplaced& misplaced, int samples) {
  Drawing draw(seed);
  Workshop result{file, {}};
  World& world = result.world;
  world.rig = file;
  world.seed = seed;
  world.robot = drawn_robot(file, seed);
  world.dials = DialHabits{};
  world.dials.curve_mm = draw.between(0.002, 0.006);
  world.warm_up.rise_c = draw.between(1.0, 5.0);
  world.warm_up.tau_s = draw.between(600, 3000);
  misplace(world, misplaced, draw, seed * 16 + 1);
  wear(world, draw, seed * 16 + 4, samples);
  return result;
}

}  // namespace sixdial::mock_devices
