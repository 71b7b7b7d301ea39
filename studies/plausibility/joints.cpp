// Joint values in another joint's column, in another unit, or turning the other way: the
// nominal robot is then nowhere near the measured tool, and with the values put right it is.
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "geometry/units.h"
#include "session/sample_layout.h"
#include "studies/plausibility/check.h"
#include "studies/plausibility/tool_seen.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kClearly = 4.0;
constexpr double kNear_mm = 6.0;  // a robot misses by no more, half of all poses
constexpr std::size_t kMostRows = 120;
constexpr double kReached = 0.5;  // of the rows, by the nominal robot

struct AngleUnit {
  std::string_view name;
  double rad;
};
/// Degrees come first: they are the usual slip.
constexpr std::array kAngleUnits{
    AngleUnit{"degrees", geometry::kRadPerDeg}, AngleUnit{"gon", std::numbers::pi / 200.0},
    AngleUnit{"turns", 2.0 * std::numbers::pi}};

struct Guess {
  std::string_view code;
  WarningParts parts;
  std::string columns;
  JointMap map;
};

/// Median distance of the tool from where these joint values put it, wherever the frame stands
/// or as it stands; infinite where most poses do not exist.
double miss_of(const session::Session& session, bool any_frame) {
  const MeasuredTool measured = measured_tool(session);
  double least = HUGE_VAL;
  for (const ToolSeen& seen : tools_seen(session, measured)) {
    const auto rows = static_cast<double>(session.samples.size());
    if (static_cast<double>(seen.row.size()) < kReached * rows || seen.row.size() < 4) continue;
    const Eigen::VectorXd as_is = geometry::distances(
        geometry::Similarity::identity(seen.nominal_mm.rows()), seen.nominal_mm,
        seen.measured_mm);
    least = std::min(least, geometry::median_of({as_is.begin(), as_is.end()}));
    if (!any_frame) continue;
    const bool by_itself = !measured.by_dials;  // dials stand where the rig file says
    const auto found = geometry::register_points(
        seen.nominal_mm, seen.measured_mm, {.may_scale = by_itself, .may_mirror = by_itself});
    if (found && found->X.scale > 0.0) {
      least = std::min(least, found->median / std::min(found->X.scale, 1.0));
    }
  }
  return least;
}

session::Session with_joints(session::Session session, const JointMap& map) {
  for (session::Sample& sample : session.samples) sample.q = map(sample.q);
  return session;
}

std::vector<Guess> guesses(const session::SampleLayout& layout) {
  std::vector<Guess> all;
  const auto& joints = layout.joints;
  std::string angles;
  Eigen::Array<bool, Eigen::Dynamic, 1> is_angle(std::ssize(joints));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    is_angle[static_cast<Eigen::Index>(i)] = joints[i].unit == "rad";
    if (joints[i].unit == "rad") angles += (angles.empty() ? "" : ", ") + joints[i].column();
  }
  const auto turning = static_cast<std::size_t>(is_angle.count());
  for (const AngleUnit& unit : kAngleUnits) {
    const Eigen::VectorXd to_rad =
        is_angle.select(unit.rad, Eigen::VectorXd::Ones(is_angle.size()));
    for (std::size_t i = 0; i < joints.size() && turning > 1; ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      if (!is_angle[a]) continue;
      all.push_back(
          {"joint_unit",
           {{"joints", joints[i].name}, {"unit", std::string(unit.name)}},
           joints[i].column(),
           [a, rad = unit.rad](Eigen::VectorXd q) {
             q[a] *= rad;
             return q;
           }});
    }
    if (turning == 0) continue;
    Guess together{
        "joint_unit",
        {{"joints", std::string("all joints")}, {"unit", std::string(unit.name)}},
        angles,
        [to_rad](const Eigen::VectorXd& q) { return q.cwiseProduct(to_rad).eval(); }};
    if (unit.name == kAngleUnits.front().name) {
      together.code = "joints_in_degrees";
      together.parts.clear();
    }
    all.push_back(std::move(together));
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    for (std::size_t j = i + 1; j < joints.size(); ++j) {
      if (joints[i].unit != joints[j].unit) continue;
      const auto b = static_cast<Eigen::Index>(j);
      all.push_back(
          {"joints_exchanged",
           {{"joints", joints[i].name + " and " + joints[j].name}},
           joints[i].column() + ", " + joints[j].column(),
           [a, b](Eigen::VectorXd q) {
             std::swap(q[a], q[b]);
             return q;
           }});
    }
    all.push_back(
        {"joint_reversed",
         {{"joints", joints[i].name}},
         joints[i].column(),
         [a](Eigen::VectorXd q) {
           q[a] = -q[a];
           return q;
         }});
  }
  all.push_back(
      {"joint_reversed",
       {{"joints", std::string("every joint")}},
       "",
       [](const Eigen::VectorXd& q) { return (-q).eval(); }});
  return all;
}

/// Joint values that stand a row too high or too low: `step` rows on they fit.
session::Session with_joints_of(
    const session::Session& session, const std::vector<std::size_t>& rows, int step) {
  session::Session other = session;
  other.samples.clear();
  for (const std::size_t row : rows) {
    const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(row) + step;
    if (from < 0 || from >= std::ssize(session.samples)) continue;
    other.samples.push_back(session.samples[row]);
    other.samples.back().q = session.samples[static_cast<std::size_t>(from)].q;
    other.samples.back().target_mm.reset();
  }
  return other;
}

/// Told and put right, if there is one.
void tell_other_row(
    Look& look, const std::vector<std::size_t>& rows, double now, double least) {
  int best = 0;
  for (const int step : {1, -1}) {
    const double miss = miss_of(with_joints_of(look.used, rows, step), true);
    if (!(miss < least)) continue;
    least = miss;
    best = step;
  }
  if (best == 0) return;
  WarningParts parts{
      {"miss", least}, {"whose", std::string(best > 0 ? "the row above" : "the row below")}};
  if (std::isfinite(now)) parts["now"] = now;
  look.tell(
      "joints_of_other_row", Severity::kWrong, {.file = "session.csv", .field = ""},
      std::move(parts));
  std::vector<Eigen::VectorXd> q;
  for (const session::Sample& each : look.used.samples) q.push_back(each.q);
  for (std::ptrdiff_t i = 0; i < std::ssize(q); ++i) {
    session::Sample& sample = look.used.samples[static_cast<std::size_t>(i)];
    if (i + best < 0 || i + best >= std::ssize(q)) {
      sample.left_out = true;
    } else {
      sample.q = q[static_cast<std::size_t>(i + best)];
    }
  }
}

}  // namespace

void look_at_joints(Look& look) {
  session::Session few = look.used;
  few.samples.clear();
  const std::vector<std::size_t> rows = looked_rows(look.used, kMostRows);
  for (const std::size_t row : rows) {
    few.samples.push_back(look.used.samples[row]);
    few.samples.back().target_mm.reset();
  }
  if (measured_tool(few).row.size() < 4 && few.rig.dials.empty()) return;
  const double now = miss_of(few, true);
  if (now < kNear_mm) return;
  const std::vector<Guess> all = guesses(session::layout_of(few.rig));
  const Guess* best = nullptr;
  double least = std::min(now / kClearly, kNear_mm);
  for (const Guess& each : all) {
    const double miss = miss_of(with_joints(few, each.map), false);
    if (!(miss < least)) continue;
    least = miss;
    best = &each;
  }
  if (best == nullptr) {
    tell_other_row(look, rows, now, least);
    return;
  }
  WarningParts parts = best->parts;
  parts["miss"] = least;
  if (std::isfinite(now)) parts["now"] = now;
  look.tell(
      best->code, Severity::kWrong, {.file = "session.csv", .field = best->columns},
      std::move(parts));
  look.used = with_joints(std::move(look.used), best->map);
}

}  // namespace sixdial::studies::plausibility
