#include "report/rig_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "report/text.h"

namespace sixdial::report {
namespace {

using Eigen::Vector2d;

constexpr double kRoom_mm = 16.0;        // around everything
constexpr double kAxis_mm = 22.0;        // length of a frame's arrows
constexpr double kBody_mm = 9.0;         // radius of a dial
constexpr double kBehind_mm = 4.0;       // of the body from the innermost place of its plunger
constexpr double kLargestSide_mm = 5e4;  // of a picture: beyond that a rig file is wrong

using Part = geometry::Sketch::Part;

/// Class of a line or a dot in the picture's style sheet.
std::string_view style_of(Part part) {
  switch (part) {
    case Part::kBase:
      return "base";
    case Part::kProximal:
      return "proximal";
    case Part::kDistal:
      return "distal";
    case Part::kMotor:
      return "motor";
    case Part::kJoint:
      return "joint";
    case Part::kTool:
      return "tool";
  }
  return "";
}

double radius_mm(Part part) {
  constexpr double kMotor_mm = 3.6;
  constexpr double kTool_mm = 2.8;
  constexpr double kJoint_mm = 2.4;
  return part == Part::kMotor ? kMotor_mm : part == Part::kTool ? kTool_mm : kJoint_mm;
}

/// The robot with its tool at the reference pose; empty: its kind cannot be drawn.
std::optional<geometry::Sketch> sketch_of(const geometry::Rig& rig) {
  const geometry::RobotModel& robot = *rig.robot.model;
  if (robot.kind->sketch == nullptr) return std::nullopt;
  const Eigen::VectorXd& v = rig.robot.nominal;
  return robot.kind->sketch(
      robot, {v.data(), static_cast<std::size_t>(v.size())}, rig.cuboid.reference_pose_mm,
      rig.robot.working_mode);
}

/// Something to hold against dials: not where an instrument gives the tool's position.
bool has_cuboid(const geometry::Rig& rig) {
  return !rig.dials.empty() || rig.instrument.kind == geometry::Instrument{}.kind;
}

class Drawing {
 public:
  explicit Drawing(const geometry::Rig& rig) : rig_(rig), sketch_(sketch_of(rig)) {}

  std::string text() {
    if (has_cuboid(rig_)) cuboid();
    if (sketch_) links(*sketch_);
    for (const geometry::Dial& dial : rig_.dials) this->dial(dial);
    constexpr double kApart_mm = 12.0;  // nearer than that two names would be on one another
    if (!sketch_) {
      frame("W table", Vector2d(0, 0), 0.0);
    } else if (sketch_->base.norm() < kApart_mm) {
      frame("W table, B robot", Vector2d(0, 0), 0.0);
    } else {
      frame("W table", Vector2d(0, 0), 0.0);
      frame("B robot", sketch_->base, sketch_->base_rad);
    }
    if (sketch_ && sketch_->trouble) {
      label(
          rig_.cuboid.reference_pose_mm, "middle",
          fmt::format(
              "reference pose: {}; no links drawn", geometry::describe(*sketch_->trouble)));
    }
    return head() + body_ + "</svg>\n";
  }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(body_), format, std::forward<Args>(args)...);
  }

  /// Up is -y in SVG.
  void seen(const Vector2d& p) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  void line(const Vector2d& a, const Vector2d& b, std::string_view kind) {
    seen(a);
    seen(b);
    put("<line class=\"{}\" x1=\"{:.3f}\" y1=\"{:.3f}\" x2=\"{:.3f}\" y2=\"{:.3f}\"/>\n", kind,
        a.x(), -a.y(), b.x(), -b.y());
  }
  void dot(const Vector2d& p, double radius_mm, std::string_view kind) {
    seen(p);
    put("<circle class=\"{}\" cx=\"{:.3f}\" cy=\"{:.3f}\" r=\"{:.3f}\"/>\n", kind, p.x(),
        -p.y(), radius_mm);
  }
  void label(
      const Vector2d& p, std::string_view anchor, std::string_view words,
      std::string_view kind = "") {
    constexpr double kLetter_mm = 3.4;  // of a font of 7 mm; the room around takes the rest
    const double width_mm = kLetter_mm * static_cast<double>(words.size());
    const double left_mm = anchor == "end" ? width_mm : anchor == "middle" ? width_mm / 2 : 0.0;
    seen(p - Vector2d(left_mm, 0.0));
    seen(p + Vector2d(width_mm - left_mm, 0.0));
    put("<text class=\"{}\" x=\"{:.3f}\" y=\"{:.3f}\" text-anchor=\"{}\">{}</text>\n", kind,
        p.x(), -p.y(), anchor, escape_html(words));
  }

  void cuboid() {
    const double side = rig_.cuboid.side_mm;
    const Vector2d c = rig_.cuboid.reference_pose_mm;
    seen(c - Vector2d(side, side) / 2);
    seen(c + Vector2d(side, side) / 2);
    put("<rect class=\"cuboid\" x=\"{:.3f}\" y=\"{:.3f}\" width=\"{:.3f}\" "
        "height=\"{:.3f}\"/>\n",
        c.x() - side / 2, -c.y() - side / 2, side, side);
    label(
        c + Vector2d(side / 2 + 3, -side / 2 + 2), "start",
        fmt::format("cuboid, {} mm", shortest(side)), "soft");
  }

  void links(const geometry::Sketch& sketch) {
    for (const auto& each : sketch.lines) line(each.from, each.to, style_of(each.part));
    for (const auto& each : sketch.dots)
      dot(each.at, radius_mm(each.part), style_of(each.part));
    for (const auto& each : sketch.dots) label(each.at + each.name_off, each.anchor, each.name);
  }

  /// As it stands at the reference pose: the tip on the face, the free tip as a faint ring.
  void dial(const geometry::Dial& each) {
    const geometry::DialGeometry& g = each.geometry;
    const geometry::CuboidPose held{rig_.cuboid.reference_pose_mm, 0.0};
    const auto contact = geometry::touch(g, held, rig_.cuboid.side_mm);
    const Vector2d tip = g.position_mm - (contact ? contact->displacement_mm : 0.0) * g.axis;
    const Vector2d body = g.position_mm - (g.travel_mm + kBehind_mm) * g.axis;
    line(g.position_mm, tip, "free");
    dot(g.position_mm - g.tip_radius_mm * g.axis, std::max(g.tip_radius_mm, 1.2), "free");
    line(tip, body, "stem");
    dot(tip - g.tip_radius_mm * g.axis, std::max(g.tip_radius_mm, 1.2), "tip");
    dot(body - kBody_mm * g.axis, kBody_mm, "dial");
    label(body - kBody_mm * g.axis - Vector2d(0, 3.2), "middle", each.id, "id");
  }

  void frame(std::string_view name, const Vector2d& origin, double angle) {
    const Vector2d x(std::cos(angle), std::sin(angle));
    const Vector2d y(-x.y(), x.x());
    arrow(origin, origin + kAxis_mm * x);
    arrow(origin, origin + kAxis_mm * y);
    label(origin + (kAxis_mm + 4.0) * x - 2.0 * y, "middle", "x", "axis-name");
    label(origin + (kAxis_mm + 2.0) * y - 4.0 * x, "middle", "y", "axis-name");
    label(origin - 11.0 * y, "middle", name, "axis-name");
  }
  void arrow(const Vector2d& from, const Vector2d& to) {
    line(from, to, "axis");
    const Vector2d x = (to - from).normalized();
    const Vector2d y(-x.y(), x.x());
    line(to, to - 4.0 * x + 2.2 * y, "axis");
    line(to, to - 4.0 * x - 2.2 * y, "axis");
  }

  static std::string shortest(double value) { return fmt::format("{:g}", value); }

  [[nodiscard]] std::string head() const {
    const Vector2d low = low_ - Vector2d(kRoom_mm + 8, kRoom_mm);
    const Vector2d size =
        (high_ - low_ + 2 * Vector2d(kRoom_mm + 8, kRoom_mm)).cwiseMin(kLargestSide_mm);
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"rig\" role=\"img\" viewBox=\"{:.2f} "
        "{:.2f} {:.2f} {:.2f}\" width=\"{:.0f}\" height=\"{:.0f}\">\n<title>{}: robot {}; "
        "table "
        "frame, mm</title>\n<style>\n"
        ".rig text{{font:7px system-ui,sans-serif;fill:#16202a;paint-order:stroke;stroke:#fff;"
        "stroke-width:2px}}\n"
        ".rig .soft{{fill:#4b5a68}}\n.rig .id{{font-weight:700;font-size:9px}}\n"
        ".rig .axis-name{{font-style:italic;fill:#0b4f82}}\n"
        ".rig line{{stroke:#16202a;stroke-width:1;stroke-linecap:round}}\n"
        ".rig .axis{{stroke:#0b4f82;stroke-width:1.1}}\n"
        ".rig .base{{stroke:#8a959f;stroke-width:1.2;stroke-dasharray:4 3}}\n"
        ".rig .proximal{{stroke-width:5;stroke:#4b5a68}}\n"
        ".rig .distal{{stroke-width:3.4;stroke:#8a5300}}\n"
        ".rig .cuboid{{fill:#dbe6ef;fill-opacity:.75;stroke:#16202a;stroke-width:1}}\n"
        ".rig .motor{{fill:#16202a}}\n.rig .joint,.rig .tip,.rig "
        ".name{{fill:#fff;stroke:#16202a;"
        "stroke-width:1}}\n.rig .tool{{fill:#a11d1d}}\n"
        ".rig .dial{{fill:#fff;stroke:#16202a}}\n.rig .free{{stroke:#8a959f;stroke-dasharray:2 "
        "2;fill:none;stroke-width:.8}}\n</style>\n",
        low.x(), -high_.y() - kRoom_mm, size.x(), size.y(), 3 * size.x(), 3 * size.y(),
        escape_html(rig_.name),
        has_cuboid(rig_)
            ? fmt::format("at its reference pose, cuboid, {} dials", rig_.dials.size())
            : std::string("in one pose"));
  }

  const geometry::Rig& rig_;
  const std::optional<geometry::Sketch> sketch_;
  std::string body_;
  Vector2d low_{0, 0}, high_{0, 0};
};

}  // namespace

std::string rig_svg(const geometry::Rig& rig) { return Drawing(rig).text(); }

Section rig_section(const geometry::Rig& rig) {
  Section out{.id = "rig", .heading = "The rig", .in_annex = true};
  Picture picture{.id = "rig", .title = "The rig as its file describes it"};
  picture.svg = rig_svg(rig);
  if (!has_cuboid(rig)) {
    picture.shows =
        "The robot with its nominal parameters in one pose. W is the frame of the measured "
        "positions, B the frame of the robot's base.";
    out.blocks.emplace_back(std::move(picture));
    return out;
  }
  picture.shows =
      "The robot with its nominal parameters at the reference pose, where the cuboid is not "
      "turned, and the dials as they touch it there; a faint ring is the tip of a dial that "
      "touches nothing. W is the frame of the table, B the frame of the robot's base. A dial "
      "reads positive when its plunger is pushed in.";
  Table t{.id = "rig_dials", .caption = "Dials on the table, at zero displacement"};
  t.columns = {
      column("dial", "dial"), column("x_mm", "tip x", "mm"), column("y_mm", "tip y", "mm"),
      column("axis_x", "axis x"), column("axis_y", "axis y")};
  for (const geometry::Dial& dial : rig.dials) {
    const geometry::DialGeometry& g = dial.geometry;
    t.rows.push_back(
        {dial.id, number(g.position_mm.x(), 3), number(g.position_mm.y(), 3),
         number(g.axis.x(), 4), number(g.axis.y(), 4)});
  }
  out.blocks.emplace_back(std::move(picture));
  out.blocks.emplace_back(std::move(t));
  return out;
}

}  // namespace sixdial::report
