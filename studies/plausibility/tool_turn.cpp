// How the tool's frame sits on the last link, from measured turns against the nominal robot's:
// the frame of a probe or a board may be turned there by anything, which is no fault. The
// robot's parameters take that turn over (geometry/tool_turn.h), and every fit starts from
// there. Turns that no such frame explains mean something else than the rig file says, and
// turns that no parameter can follow tell nothing: both are left out, and said.
#include "geometry/tool_turn.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "geometry/rotation.h"
#include "geometry/units.h"
#include "session/measured_turn.h"
#include "studies/plausibility/check.h"
#include "studies/plausibility/tool_seen.h"
#include "studies/slipped_turns.h"

namespace sixdial::studies::plausibility {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A robot like the rig file's is turned by less than this from pose to pose.
constexpr double kFits_rad = 5.0 * geometry::kRadPerDeg;
/// Single turns that are off by more than this, and by so many times what is usual, are slips.
constexpr double kFarTimes = 20.0;
/// Another convention must fit so many times better before it is named.
constexpr double kClearlyBetter = 5.0;
/// A tool that is turned further than this is put there before the search.
constexpr double kTurned_rad = 0.5 * geometry::kRadPerDeg;

/// Where the nominal robot has the tool, and how it was measured.
struct TurnsSeen {
  std::vector<std::size_t> row;
  std::vector<Matrix3d> nominal;
  std::vector<Vector3d> measured;  // rotation vectors, as the file was read
};

TurnsSeen turns_seen(
    const session::Session& session, const session::SampleLayout& layout,
    std::size_t most = kMostLooked) {
  const geometry::Robot& robot = session.rig.robot;
  TurnsSeen seen;
  std::vector<geometry::Pose<double>> X(robot.model->frames.size());
  for (const std::size_t row : looked_rows(session, most)) {
    const session::Sample& sample = session.samples[row];
    const auto turn = session::turn_of(sample, layout);
    if (!turn || !turn->allFinite()) continue;
    const auto assembly = assembly_by_target(session.rig, sample).value_or(robot.assembly);
    if (!robot.model->forward(robot.nominal, sample.q, assembly, X)) continue;
    seen.row.push_back(row);
    seen.nominal.push_back(X[0].R);
    seen.measured.push_back(*turn);
  }
  return seen;
}

/// The turn nearest to a sum of turns.
Matrix3d nearest_turn(const Matrix3d& sum) {
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d keep = Matrix3d::Identity();
  keep(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * keep * svd.matrixV().transpose();
}

struct OnLink {
  Matrix3d R = Matrix3d::Identity();
  double median_rad = 0.0;  // what it leaves
};

/// The turn of the tool's frame that most samples share: the mean, then that of the half that
/// is nearest to it.
OnLink on_link(const TurnsSeen& seen, const std::vector<Matrix3d>& measured) {
  const std::size_t count = measured.size();
  std::vector<Matrix3d> on(count);
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    on[i] = seen.nominal[i].transpose() * measured[i];
    sum += on[i];
  }
  OnLink found{nearest_turn(sum)};
  for (int round = 0; round < 3; ++round) {
    std::vector<double> away(count);
    for (std::size_t i = 0; i < count; ++i) away[i] = geometry::turn_between(found.R, on[i]);
    found.median_rad = geometry::median_of(away);
    sum.setZero();
    for (std::size_t i = 0; i < count; ++i) {
      if (away[i] <= found.median_rad) sum += on[i];
    }
    found.R = nearest_turn(sum);
  }
  return found;
}

std::vector<Matrix3d> frames_of(const TurnsSeen& seen, std::string_view convention) {
  std::vector<Matrix3d> frames;
  frames.reserve(seen.measured.size());
  for (const Vector3d& each : seen.measured) {
    frames.push_back(session::frame_of_angles(convention, each));
  }
  return frames;
}

/// What the three angles mean if they are no rotation vector: the convention that fits best.
std::string better_convention(const TurnsSeen& seen, double median_rad) {
  static constexpr std::array<std::string_view, 12> kOrders{
      "xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "zxz", "zyz", "xyx", "xzx", "yxy", "yzy"};
  std::string best;
  double least = median_rad / kClearlyBetter;
  for (const std::string frame : {"intrinsic ", "extrinsic "}) {
    for (const std::string_view order : kOrders) {
      const std::string convention = frame + std::string(order);
      const double left = on_link(seen, frames_of(seen, convention)).median_rad;
      if (!(left < std::min(least, kFits_rad))) continue;
      least = left;
      best = convention;
    }
  }
  return best;
}

void leave_out_turns(Look& look, const session::SampleLayout& layout) {
  for (session::Sample& sample : look.used.samples) {
    session::set_turn(sample, layout, std::nullopt);
  }
}

/// Single turns that are far from all others: of another row, or a target that was lost. Where
/// they are too many for that, the probe was moved: they stay.
void leave_out_far_turns(Look& look, const session::SampleLayout& layout, const OnLink& all) {
  const TurnsSeen seen = turns_seen(look.used, layout, look.used.samples.size());
  const double most_rad = std::max(kFits_rad, kFarTimes * all.median_rad);
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < seen.row.size(); ++i) {
    const Matrix3d on =
        seen.nominal[i].transpose() * geometry::turned_by<double>(seen.measured[i]);
    if (geometry::turn_between(all.R, on) > most_rad) far.push_back(seen.row[i]);
  }
  if (far.empty()) return;
  const bool accidents = may_be_accidents(std::ssize(far), std::ssize(seen.row));
  look.tell(
      accidents ? "far_turn" : "far_turns", accidents ? Severity::kNote : Severity::kDoubt,
      look.rows(far, "rx, ry, rz"), {{"most", most_rad * geometry::kDegPerRad}});
  if (!accidents) return;
  for (const std::size_t row : far) {
    session::set_turn(look.used.samples[row], layout, std::nullopt);
  }
}

}  // namespace

void look_at_tool_turn(Look& look) {
  const session::SampleLayout layout = session::layout_of(look.used.rig);
  if (!session::first_turn(layout)) return;
  TurnsSeen seen = turns_seen(look.used, layout);
  if (std::ssize(seen.row) < kFewestTurns) {
    seen = turns_seen(look.used, layout, look.used.samples.size());
  }
  if (seen.row.empty()) return;
  if (std::ssize(seen.row) < kFewestTurns) {
    leave_out_turns(look, layout);
    look.tell("few_turns", Severity::kNote, look.rows(seen.row, "rx, ry, rz"));
    return;
  }
  const WarningPlace columns{.file = "session.csv", .field = "rx, ry, rz"};
  const OnLink found = on_link(seen, frames_of(seen, session::kRotationVector));
  const double left_deg = found.median_rad * geometry::kDegPerRad;
  geometry::Robot& robot = look.used.rig.robot;
  if (!geometry::turns_its_tool(*robot.model, robot.nominal)) {
    leave_out_turns(look, layout);
    look.tell("turns_not_explained", Severity::kNote, Look::rig_key("[robot] tool"));
    return;
  }
  if (found.median_rad > kFits_rad) {
    leave_out_turns(look, layout);
    WarningParts parts{{"left", left_deg}, {"orientation", layout.orientation}};
    const bool as_read = layout.orientation == session::kRotationVector;
    if (const auto better = as_read ? better_convention(seen, found.median_rad) : "";
        !better.empty()) {
      parts["better"] = better;
    }
    look.tell("turns_fit_nowhere", Severity::kDoubt, columns, std::move(parts));
    return;
  }
  leave_out_far_turns(look, layout, found);
  const double turn_rad = geometry::rotation_vector(found.R).norm();
  if (!(turn_rad > kTurned_rad)) return;
  // Over all of the joints' ranges: where the measured poses leave a joint at rest, a turn of
  // the link before it would pass for one of the tool.
  const auto turned = geometry::with_tool_turned(*robot.model, robot.nominal, found.R);
  const WarningParts parts{{"turn", turn_rad * geometry::kDegPerRad}, {"left", left_deg}};
  if (!turned) {
    look.tell("tool_turn_not_set", Severity::kDoubt, columns, parts);
    return;
  }
  robot.nominal = *turned;
  look.tell("tool_turn_registered", Severity::kNote, columns, parts);
}

}  // namespace sixdial::studies::plausibility
