#include "simulation/moved_rig.h"

namespace sixdial::simulation {
namespace {

Scene scene_of(const geometry::Rig& rig) {
  Scene scene;
  scene.side_mm = rig.cuboid.side_mm;
  scene.dials = rig.dial_geometries();
  return scene;
}

void move_scene(const RigQuantity& quantity, double off, Scene& scene) {
  const double size[] = {off * quantity.sd};
  quantity.effect->before_contact(size, quantity.place, {}, scene);
}

}  // namespace

bool is_said_by_a_rig(const RigQuantity& quantity, const geometry::Rig& rig) {
  Scene scene = scene_of(rig);
  move_scene(quantity, 1.0, scene);
  return scene.squareness_rad == 0.0 && scene.centre_offset_mm.isZero(0.0);
}

geometry::Rig moved_rig(
    const geometry::Rig& rig, std::span<const RigQuantity> quantities,
    const Eigen::VectorXd& off) {
  Scene scene = scene_of(rig);
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    if (is_said_by_a_rig(quantities[k], rig)) {
      move_scene(quantities[k], off[static_cast<Eigen::Index>(k)], scene);
    }
  }
  geometry::Rig result = rig;
  result.cuboid.side_mm = scene.side_mm;
  for (std::size_t d = 0; d < result.dials.size(); ++d) {
    result.dials[d].geometry = scene.dials[d];
  }
  return result;
}

}  // namespace sixdial::simulation
