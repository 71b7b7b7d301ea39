#include "simulation/rig_quantities.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "geometry/units.h"
#include "simulation/rig_kinds.h"

namespace sixdial::simulation {
namespace {

using geometry::DialGeometry;
using Offset = std::span<const double>;

constexpr std::array kLength{EffectParameter{"off", "mm", 1e-2}};
constexpr std::array kAngle{EffectParameter{"off", "rad", 1e-3}};

/// The dial's left as one looks along its axis.
Eigen::Vector2d across(const DialGeometry& dial) { return {-dial.axis.y(), dial.axis.x()}; }

DialGeometry& dial_at(const Place& place, Scene& scene) {
  return scene.dials[static_cast<std::size_t>(place.dial)];
}

// Not of the catalogue: a rig that stands as well as its file says has no fault.
constexpr Effect kAlong{
    .parameters = kLength,
    .before_contact = [](Offset x, const Place& place, const Circumstance&, Scene& scene) {
      DialGeometry& dial = dial_at(place, scene);
      dial.position_mm += x[0] * dial.axis;
    }};
constexpr Effect kAcross{
    .parameters = kLength,
    .before_contact = [](Offset x, const Place& place, const Circumstance&, Scene& scene) {
      DialGeometry& dial = dial_at(place, scene);
      dial.position_mm += x[0] * across(dial);
    }};
constexpr Effect kLean{
    .parameters = kAngle,
    .before_contact = [](Offset x, const Place& place, const Circumstance&, Scene& scene) {
      DialGeometry& dial = dial_at(place, scene);
      dial.axis = (dial.axis + x[0] * across(dial)).normalized();
    }};
constexpr Effect kTip{
    .parameters = kLength,
    .before_contact = [](Offset x, const Place& place, const Circumstance&, Scene& scene) {
      dial_at(place, scene).tip_radius_mm += x[0];
    }};
constexpr Effect kSide{
    .parameters = kLength,
    .before_contact = [](Offset x, const Place&, const Circumstance&, Scene& scene) {
      scene.side_mm += x[0];
    }};
constexpr Effect kSquare{
    .parameters = kAngle,
    .before_contact = [](Offset x, const Place&, const Circumstance&, Scene& scene) {
      scene.squareness_rad += x[0];
    }};
constexpr Effect kOffsetX{
    .parameters = kLength,
    .before_contact = [](Offset x, const Place&, const Circumstance&, Scene& scene) {
      scene.centre_offset_mm.x() += x[0];
    }};
constexpr Effect kOffsetY{
    .parameters = kLength,
    .before_contact = [](Offset x, const Place&, const Circumstance&, Scene& scene) {
      scene.centre_offset_mm.y() += x[0];
    }};

// What a ruler's tenth, a gauge block and a square leave open [mm, rad].
constexpr double kRuler_mm = 0.1;
constexpr double kGaugeBlock_mm = 0.03;
constexpr double kSquare_rad = 0.1 * geometry::kRadPerDeg;
constexpr double kTip_mm = 0.02;
constexpr double kCaliper_mm = 0.01;
constexpr double kCuboidSquare_rad = 2e-4;
constexpr double kCentre_mm = 0.05;

/// One quantity, by what the file says of it, into one of the two lists.
class Lister {
 public:
  explicit Lister(bool stated) : stated_(stated) {}

  void add(
      std::string name, const Effect& effect, const Place& place,
      const std::optional<double>& sd, double of_a_workshop) {
    const bool stated = sd.value_or(0.0) > 0.0;
    if (stated != stated_) return;
    result_.push_back(
        {.name = std::move(name),
         .unit = std::string(effect.parameters[0].unit),
         .sd = stated ? *sd : of_a_workshop,
         .stated = stated,
         .place = place,
         .effect = &effect});
  }
  [[nodiscard]] std::vector<RigQuantity> take() { return std::move(result_); }

 private:
  bool stated_;
  std::vector<RigQuantity> result_;
};

std::vector<RigQuantity> listed(const geometry::Rig& rig, bool stated) {
  Lister list(stated);
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    const geometry::Dial& dial = rig.dials[i];
    const geometry::DialDeviations& known = dial.deviations;
    const Place place{.name = dial.id, .dial = static_cast<int>(i)};
    std::optional<double> along, sideways;
    if (known.position_mm) {
      along = known.position_mm->x();
      sideways = known.position_mm->y();
    }
    list.add(
        fmt::format("place of dial {} along its axis", dial.id), kAlong, place, along,
        kGaugeBlock_mm);
    list.add(
        fmt::format("place of dial {} across its axis", dial.id), kAcross, place, sideways,
        kRuler_mm);
    list.add(
        fmt::format("axis of dial {}", dial.id), kLean, place, known.axis_rad, kSquare_rad);
    list.add(
        fmt::format("tip radius of dial {}", dial.id), kTip, place, known.tip_radius_mm,
        kTip_mm);
  }
  if (rig.dials.empty()) return list.take();
  const geometry::CuboidDeviations& known = rig.cuboid.deviations;
  const Place cuboid{.name = "cuboid"};
  list.add("side of the cuboid", kSide, cuboid, known.side_mm, kCaliper_mm);
  list.add(
      "squareness of the cuboid", kSquare, cuboid, known.squareness_rad, kCuboidSquare_rad);
  list.add("centre of the cuboid along x", kOffsetX, cuboid, known.offset_mm, kCentre_mm);
  list.add("centre of the cuboid along y", kOffsetY, cuboid, known.offset_mm, kCentre_mm);
  return list.take();
}

using Said = std::optional<double> (*)(const geometry::Rig& rig, const Place& place);

const geometry::DialDeviations& of_dial(const geometry::Rig& rig, const Place& place) {
  return rig.dials[static_cast<std::size_t>(place.dial)].deviations;
}

std::optional<double> said_of_place(const geometry::Rig& rig, const Place& place, int axis) {
  const auto& known = of_dial(rig, place).position_mm;
  return known ? std::optional((*known)[axis]) : std::nullopt;
}

struct Kind {
  const Effect* effect;
  std::string_view name;
  Said said;
};
constexpr std::array<Kind, 8> kKinds{{
    {&kAlong, "places of the dials along their axes",
     [](const auto& rig, const auto& place) { return said_of_place(rig, place, 0); }},
    {&kAcross, "places of the dials across their axes",
     [](const auto& rig, const auto& place) { return said_of_place(rig, place, 1); }},
    {&kLean, "axes of the dials",
     [](const auto& rig, const auto& place) { return of_dial(rig, place).axis_rad; }},
    {&kTip, "tip radii of the dials",
     [](const auto& rig, const auto& place) { return of_dial(rig, place).tip_radius_mm; }},
    {&kSide, "side of the cuboid",
     [](const auto& rig, const auto&) { return rig.cuboid.deviations.side_mm; }},
    {&kSquare, "squareness of the cuboid",
     [](const auto& rig, const auto&) { return rig.cuboid.deviations.squareness_rad; }},
    {&kOffsetX, "centre of the cuboid",
     [](const auto& rig, const auto&) { return rig.cuboid.deviations.offset_mm; }},
    {&kOffsetY, "centre of the cuboid",
     [](const auto& rig, const auto&) { return rig.cuboid.deviations.offset_mm; }},
}};

const Kind& row_of(const RigQuantity& quantity) {
  return *std::ranges::find(kKinds, quantity.effect, &Kind::effect);
}

}  // namespace

std::string_view kind_of(const RigQuantity& quantity) { return row_of(quantity).name; }

std::optional<double> said_of(const geometry::Rig& rig, const RigQuantity& quantity) {
  return row_of(quantity).said(rig, quantity.place);
}

std::vector<RigQuantity> stated_quantities(const geometry::Rig& rig) {
  return listed(rig, true);
}

std::vector<RigQuantity> claimed_quantities(const geometry::Rig& rig) {
  return listed(rig, false);
}

}  // namespace sixdial::simulation
