// Every cause; draws pick by position in this list, so a new one goes to the end of its half.
#include <cmath>

#include "mock_devices/hidden_effect.h"

namespace sixdial::mock_devices {

extern constinit const CauseRow base_drift, creep, cuboid_offset, cuboid_size,
    cuboid_squareness, dial_bend, dial_curve, dial_cyclic, dial_gain, dial_hysteresis,
    dial_lean, dial_mount, dial_swap, frame_skew, joint_backlash, joint_compliance,
    joint_eccentricity, joint_fifth_harmonic, joint_gain, joint_second_harmonic,
    link_thermal_growth, outliers, passive_clearance, random_walk, stale_reading, step,
    time_sinusoid, tip_radius, xy_field;

namespace {

// Ranges give visible ratios from about 0.1 to 5 on 150 default poses with 0.002 mm noise.
constexpr std::array kCauses{
    &joint_eccentricity, &joint_second_harmonic, &joint_gain, &joint_backlash,
    &joint_compliance, &link_thermal_growth, &passive_clearance, &base_drift, &frame_skew,
    &cuboid_size, &cuboid_squareness, &cuboid_offset, &tip_radius, &dial_gain, &dial_lean,
    &dial_mount, &dial_hysteresis, &dial_cyclic, &dial_swap, &step, &outliers, &stale_reading,
    // outside of the catalogue of diagnosis
    &xy_field, &random_walk, &time_sinusoid, &joint_fifth_harmonic, &creep, &dial_bend,
    &dial_curve};

}  // namespace

std::span<const CauseRow* const> causes() { return kCauses; }

Eigen::Vector2d direction(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

Eigen::Vector2d turned(const Eigen::Vector2d& a, double angle_rad) {
  const Eigen::Vector2d u = direction(angle_rad);
  return {u.x() * a.x() - u.y() * a.y(), u.y() * a.x() + u.x() * a.y()};
}

std::vector<std::string> each_joint(const geometry::Rig&) { return {"joint1", "joint2"}; }

std::vector<std::string> each_dial(const geometry::Rig& rig) {
  std::vector<std::string> result;
  for (const geometry::Dial& dial : rig.dials) result.push_back(dial.id);
  return result;
}

bool turns_at(std::string_view where) {
  return where.starts_with("joint") || where == "cuboid";
}

std::string name_at(const NumberName& number, std::string_view where) {
  std::string name(number.name);
  if (number.unit_by_place) name += turns_at(where) ? "_rad" : "_mm";
  return name;
}

double Draw::across() const { return amplitude * std::cos(phase_rad); }
double Draw::along() const { return amplitude * std::sin(phase_rad); }
double Draw::seed() const { return std::floor(random.uniform(25, 0.0, 1e9)); }

std::vector<double> as_large(const Draw& draw) { return {draw.amplitude}; }
std::vector<double> in_any_direction(const Draw& draw) { return {draw.across(), draw.along()}; }

}  // namespace sixdial::mock_devices
