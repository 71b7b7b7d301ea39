// The unit and the frame in which positions were measured, against the nominal robot. A frame
// that stands elsewhere is no fault: the robot's base is put where it was measured, in closed
// form, and every fit starts from there. Another unit, exchanged columns or a left-handed frame
// would only bend the links until they fit: nothing is calibrated before that is settled.
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "geometry/rotation.h"
#include "geometry/units.h"
#include "session/measured_turn.h"
#include "studies/plausibility/check.h"
#include "studies/plausibility/tool_seen.h"

namespace sixdial::studies::plausibility {
namespace {

using geometry::Registration;
using geometry::Similarity;

/// By so much better must another reading of the columns fit before it is believed.
constexpr double kClearly = 3.0;
/// Links are built to a few percent: beyond that a size is a unit.
constexpr double kSizeSlack = 0.15;  // of the logarithm
/// A base that stands further away than so many plausible changes of its parameters is put
/// there before the search; within, the search starts at the rig file's.
constexpr double kFarChanges = 5.0;
constexpr double kSameAxes_rad = 0.2;  // exchanged columns leave the axes where they are
constexpr double kSamePlace = 0.5;     // and the place, in extents of the points
constexpr double kMostLeft = 0.2;      // of the same, after a turn and a shift
constexpr std::size_t kFewest = 4;
constexpr std::size_t kPoses = 40;
/// A robot may stand so far turned from where the rig file has it; beyond, or further away than
/// its work is wide, it is the instrument that has a frame of its own.
constexpr double kMountedTurn_rad = 10.0 * geometry::kRadPerDeg;
/// Targets that lie with the measured positions, not with the joint values, within this.
constexpr double kTargetsThere_mm = 10.0;

struct Unit {
  double per_mm;  // figures in this unit of one millimetre
  std::string_view name;
};
constexpr std::array kUnits{
    Unit{1.0 / 25.4, "inches"},
    Unit{0.1, "centimetres"},
    Unit{1e-3, "metres"},
    Unit{1000.0, "micrometres"},
    Unit{1000.0 / 25.4, "thousandths of an inch"},
    Unit{1.0 / 304.8, "feet"}};

struct Best {
  ToolSeen seen;
  bool by_dials = false;
  double as_is_mm = 0.0;  // median distance from the nominal robot
  Registration rigid, any;
};

double extent_of(const Eigen::MatrixXd& points) {
  return (points.colwise() - points.rowwise().mean()).colwise().norm().maxCoeff();
}

double size_of(const Registration& found) { return found.median / found.X.scale; }

/// Of the robot's assemblies the one that fits best.
std::optional<Best> best_of(const session::Session& session) {
  std::optional<Best> best;
  const MeasuredTool measured = measured_tool(session);
  for (ToolSeen& seen : tools_seen(session, measured)) {
    if (seen.row.size() < kFewest) continue;
    auto rigid = geometry::register_points(seen.nominal_mm, seen.measured_mm);
    auto any = geometry::register_points(
        seen.nominal_mm, seen.measured_mm, {.may_scale = true, .may_mirror = true});
    if (!rigid || !any || !(any->X.scale > 0.0)) continue;
    // A mirrored frame must say so clearly: an assembly of a closed robot is almost a mirror.
    auto handed =
        geometry::register_points(seen.nominal_mm, seen.measured_mm, {.may_scale = true});
    if (any->X.mirrored() && handed && handed->X.scale > 0.0 &&
        size_of(*handed) < kClearly * size_of(*any)) {
      any = handed;
    }
    if (best && size_of(*any) >= size_of(best->any)) continue;
    const Eigen::VectorXd d = geometry::distances(
        Similarity::identity(seen.nominal_mm.rows()), seen.nominal_mm, seen.measured_mm);
    const double as_is_mm = geometry::median_of({d.begin(), d.end()});
    best = Best{std::move(seen), measured.by_dials, as_is_mm, *rigid, *any};
  }
  return best;
}

std::string columns_of(const Look& look) {
  std::string names;
  for (const std::string& axis : session::layout_of(look.used.rig).axes) {
    names += (names.empty() ? "" : ", ") + axis + "_mm";
  }
  return names;
}

WarningPlace column_place(std::string columns) {
  return {.file = "session.csv", .field = std::move(columns)};
}

/// Links of another length do not explain it: the size of everything is another.
bool other_size(const Best& best) {
  return std::abs(std::log(best.any.X.scale)) > kSizeSlack &&
         kClearly * size_of(best.any) < best.rigid.median;
}

/// Every measured position p becomes M p. What follows is computed from what the columns most
/// likely hold, so that it can be read at all; nothing is called calibrated by it.
void change_positions(session::Session& session, const Eigen::MatrixXd& M) {
  const std::size_t dials = session.rig.dials.size();
  for (session::Sample& sample : session.samples) {
    const auto at = session::position_of(sample, dials);
    if (at && at->size() == M.cols()) session::set_position(sample, dials, M * *at);
  }
}

/// Robust width of values around their middle.
double width_of(const Eigen::VectorXd& values) {
  const double middle = geometry::median_of({values.begin(), values.end()});
  const Eigen::VectorXd apart = (values.array() - middle).abs();
  return geometry::median_of({apart.begin(), apart.end()});
}

/// One coordinate in another unit than the others: only told of a frame that is not turned.
bool tell_unit_of_one(Look& look, const Best& best) {
  const auto& axes = session::layout_of(look.used.rig).axes;
  const Eigen::Index n = best.seen.nominal_mm.rows();
  Eigen::MatrixXd to_mm = Eigen::MatrixXd::Identity(n, n);
  std::string names;
  const Unit* common = nullptr;
  for (Eigen::Index axis = 0; axis < n; ++axis) {
    const double scale =
        width_of(best.seen.measured_mm.row(axis)) / width_of(best.seen.nominal_mm.row(axis));
    const auto* const unit = std::ranges::find_if(kUnits, [&](const Unit& each) {
      return std::abs(std::log(scale / each.per_mm)) < kSizeSlack;
    });
    if (unit == kUnits.end() || (common != nullptr && common != unit)) continue;
    common = unit;
    to_mm(axis, axis) = 1.0 / unit->per_mm;
    names += (names.empty() ? "" : ", ") + axes[static_cast<std::size_t>(axis)];
  }
  if (common == nullptr) return false;
  const auto put_right =
      geometry::register_points(best.seen.nominal_mm, to_mm * best.seen.measured_mm);
  if (!put_right || kClearly * put_right->median >= best.rigid.median ||
      kClearly * put_right->median >= size_of(best.any)) {
    return false;
  }
  look.tell(
      "position_unit", Severity::kWrong, column_place(columns_of(look)),
      {{"columns", names},
       {"unit", std::string(common->name)},
       {"factor", 1.0 / common->per_mm},
       {"scale", common->per_mm},
       {"miss", put_right->median}});
  change_positions(look.used, to_mm);
  return true;
}

void tell_unit(Look& look, const Best& best) {
  const double scale = best.any.X.scale;
  const auto unit = std::ranges::find_if(kUnits, [&](const Unit& each) {
    return std::abs(std::log(scale / each.per_mm)) < kSizeSlack;
  });
  WarningParts parts{
      {"miss", size_of(best.any)}, {"scale", scale}, {"columns", columns_of(look)}};
  if (unit == kUnits.end()) {
    look.tell("position_scale", Severity::kWrong, column_place(columns_of(look)), parts);
    return;
  }
  parts["unit"] = std::string(unit->name);
  parts["factor"] = 1.0 / unit->per_mm;
  look.tell("position_unit", Severity::kWrong, column_place(columns_of(look)), parts);
  const Eigen::Index axes = best.any.X.R.rows();
  change_positions(look.used, Eigen::MatrixXd::Identity(axes, axes) / unit->per_mm);
}

/// The signed exchange of axes that is nearest to a turn; empty: none is near.
std::optional<Eigen::MatrixXd> exchange_of(const Eigen::MatrixXd& R) {
  Eigen::MatrixXd exchange = Eigen::MatrixXd::Zero(R.rows(), R.cols());
  for (Eigen::Index row = 0; row < R.rows(); ++row) {
    Eigen::Index column = 0;
    R.row(row).cwiseAbs().maxCoeff(&column);
    exchange(row, column) = R(row, column) > 0.0 ? 1.0 : -1.0;
  }
  if ((exchange.transpose() * R - Eigen::MatrixXd::Identity(R.rows(), R.cols())).norm() >
      kSameAxes_rad * std::sqrt(2.0)) {
    return std::nullopt;
  }
  return exchange;
}

/// What a mirrored frame most likely is: two columns exchanged, one axis the other way round,
/// or, turned as well, a left-handed frame.
void tell_mirrored(Look& look, const Best& best) {
  const auto& axes = session::layout_of(look.used.rig).axes;
  const Similarity& X = best.any.X;
  WarningParts parts{
      {"miss", best.any.median},
      {"now", best.rigid.median},
      {"turn", X.turn_rad() * geometry::kDegPerRad}};
  const auto exchange = exchange_of(X.R);
  std::string exchanged, reversed;
  for (Eigen::Index i = 0; exchange && i < X.R.rows(); ++i) {
    const std::string& axis = axes[static_cast<std::size_t>(i)];
    const bool stays = (*exchange)(i, i) != 0.0;
    const bool turned_round = exchange->row(i).sum() < 0.0;
    if (!stays && !turned_round) exchanged += (exchanged.empty() ? "" : " and ") + axis;
    if (turned_round) reversed += (reversed.empty() ? "" : " and ") + axis;
  }
  const double place =
      (best.seen.measured_mm.rowwise().mean() - X.R * best.seen.nominal_mm.rowwise().mean())
          .norm();
  const bool stays_there = place < kSamePlace * extent_of(best.seen.nominal_mm);
  if (exchange && reversed.empty() && stays_there) {
    parts["columns"] = exchanged;
    look.tell("columns_exchanged", Severity::kWrong, column_place(columns_of(look)), parts);
  } else if (exchange && exchanged.empty()) {
    parts["axis"] = reversed;
    look.tell("axis_reversed", Severity::kWrong, column_place(columns_of(look)), parts);
  } else {
    look.tell("frame_mirrored", Severity::kWrong, column_place(columns_of(look)), parts);
  }
  change_positions(look.used, exchange ? exchange->transpose() : X.R.transpose());
}

/// Targets lie in the rig file's frame, unless they lie where the tool was measured.
bool targets_lie_there(
    const session::Session& session, const ToolSeen& seen, const Similarity& X) {
  std::vector<double> here, there;
  for (std::size_t i = 0; i < seen.row.size(); ++i) {
    const auto& target = session.samples[seen.row[i]].target_mm;
    if (!target || target->size() != seen.nominal_mm.rows()) continue;
    const Eigen::VectorXd nominal = seen.nominal_mm.col(static_cast<Eigen::Index>(i));
    here.push_back((*target - nominal).norm());
    there.push_back((*target - X(nominal)).norm());
  }
  const double apart = geometry::median_of(there);
  return apart < kTargetsThere_mm && apart < geometry::median_of(here);
}

/// A frame of the instrument's own, and not a robot that was mounted beside its place: then
/// targets are meant in the rig file's frame, and go along.
bool is_own_frame(const Best& best) {
  if (best.by_dials) return false;
  const Similarity& X = best.rigid.X;
  const Eigen::VectorXd middle = best.seen.nominal_mm.rowwise().mean();
  return std::abs(X.turn_rad()) > kMountedTurn_rad ||
         (X(middle) - middle).norm() > extent_of(best.seen.nominal_mm);
}

std::vector<geometry::JointPose> few_of(const std::vector<geometry::JointPose>& poses) {
  std::vector<geometry::JointPose> few;
  const std::size_t every = std::max<std::size_t>(1, poses.size() / kPoses);
  for (std::size_t i = 0; i < poses.size(); i += every) few.push_back(poses[i]);
  return few;
}

bool is_far(const geometry::Rig& rig, const Eigen::VectorXd& moved) {
  double furthest = 0.0;
  for (Eigen::Index i = 0; i < moved.size(); ++i) {
    const double change = rig.robot.model->parameters[static_cast<std::size_t>(i)].change;
    furthest = std::max(furthest, std::abs(moved[i] - rig.robot.nominal[i]) / change);
  }
  return furthest > kFarChanges;
}

/// Brings what a sample measured, place and turn, by X.
void move_measured(
    session::Sample& sample, const session::SampleLayout& layout, const Similarity& X) {
  const auto at = session::position_of(sample, layout.dials);
  if (at && at->size() == X.t.size()) session::set_position(sample, layout.dials, X(*at));
  if (const auto turn = session::turn_of(sample, layout)) {
    const Eigen::Matrix3d turned = X.R * geometry::turned_by<double>(*turn);
    session::set_turn(sample, layout, geometry::rotation_vector(turned));
  }
}

/// What the instrument's frame X takes along: targets, the cuboid's reference, or, of a kind
/// without parameters for its base, what was measured back to the rig file's frame.
void bring_along(session::Session& used, const Similarity& X, bool base_moved, bool targets) {
  const session::SampleLayout layout = session::layout_of(used.rig);
  const Similarity back = X.inverse();
  for (session::Sample& sample : used.samples) {
    auto& target = sample.target_mm;
    if (target && target->size() == X.t.size()) {
      if (base_moved && targets) target = X(*target);
      if (!base_moved && !targets) target = back(*target);
    }
    if (!base_moved) move_measured(sample, layout, back);
  }
  if (base_moved && X.t.size() == 2) {
    used.rig.cuboid.reference_pose_mm = X(used.rig.cuboid.reference_pose_mm);
  }
}

/// Names of the parameters that differ.
std::string changed(const geometry::Rig& rig, const Eigen::VectorXd& moved) {
  std::string names;
  for (Eigen::Index i = 0; i < moved.size(); ++i) {
    if (moved[i] == rig.robot.nominal[i]) continue;
    names += (names.empty() ? "" : ", ") +
             rig.robot.model->parameters[static_cast<std::size_t>(i)].name;
  }
  return names;
}

/// The base goes to where it was measured.
void move_base(Look& look, const Best& best) {
  const Similarity& X = best.rigid.X;
  session::Session& used = look.used;
  const auto moved = geometry::with_base_moved(
      geometry::Tool(used.rig), used.rig.robot.nominal, X, few_of(best.seen.pose));
  const bool own_frame = is_own_frame(best);
  if (moved ? !is_far(used.rig, *moved) : !own_frame) return;
  const Eigen::VectorXd middle = best.seen.nominal_mm.rowwise().mean();
  WarningParts parts{
      {"turn", X.turn_rad() * geometry::kDegPerRad},
      {"shift", (X(middle) - middle).norm()},
      {"now", best.as_is_mm},
      {"miss", best.rigid.median}};
  if (own_frame) {
    const bool targets_go = !targets_lie_there(used, best.seen, X);
    bring_along(used, X, moved.has_value(), targets_go);
    if (moved && targets_go) look.frame = X;
  }
  if (moved) {
    parts["base"] = changed(used.rig, *moved);
    used.rig.robot.nominal = *moved;
  }
  const bool by_dials = best.by_dials;
  look.tell(
      own_frame ? "frame_registered" : "base_registered", Severity::kNote,
      by_dials ? WarningPlace{} : column_place(columns_of(look)), parts);
}

}  // namespace

void look_at_frame(Look& look) {
  auto best = best_of(look.used);
  if (!best) return;
  if (!best->by_dials && tell_unit_of_one(look, *best)) {
    best = best_of(look.used);
  } else if (!best->by_dials && other_size(*best)) {
    tell_unit(look, *best);
    best = best_of(look.used);
  }
  if (best && !best->by_dials && best->any.X.mirrored() && best->any.mirror_known) {
    tell_mirrored(look, *best);
    best = best_of(look.used);
  }
  if (!best || kClearly * best->rigid.median >= best->as_is_mm) return;
  // What is left after the best turn and shift is no frame: whoever fits it will tell.
  if (best->rigid.median < kMostLeft * extent_of(best->seen.nominal_mm)) move_base(look, *best);
}

}  // namespace sixdial::studies::plausibility

namespace sixdial::studies {

session::Session in_rig_frame(const PlausibleSession& judged, const geometry::Rig& filed) {
  session::Session session = judged.session;
  if (!judged.frame) return session;
  session.rig = filed;
  const session::SampleLayout layout = session::layout_of(filed);
  const geometry::Similarity back = judged.frame->inverse();
  for (session::Sample& sample : session.samples) {
    if (sample.target_mm) sample.target_mm = back(*sample.target_mm);
    plausibility::move_measured(sample, layout, back);
  }
  return session;
}

}  // namespace sixdial::studies
