// Plans: what a session should measure, what of it is done.
#include <fmt/format.h>

#include <utility>

#include "db/store_steps.h"
#include "session/csv.h"

namespace sixdial::db {
namespace {

constexpr const char* kPointColumns =
    "p.position, p.set_name, p.point, p.repeat, p.target_x_mm, p.target_y_mm, p.target_z_mm";

session::PlanPoint point_of(const Statement& row) {
  session::PlanPoint point;
  point.set = row.text(1);
  point.point = row.integer(2);
  point.repeat = row.integer(3);
  point.target_mm = point_from(row, 4).value_or(session::Position());
  return point;
}

/// The points that `points` selects of a plan in order, with their joint values. Its first
/// column is the position in the plan.
std::vector<session::PlanPoint> points_from(
    Database& database, std::int64_t plan_id, Statement& points) {
  std::vector<session::PlanPoint> all;
  std::vector<int> positions;
  while (points.step()) {
    positions.push_back(points.integer(0));
    all.push_back(point_of(points));
  }
  Statement joints(
      database,
      "SELECT position, value, approach FROM plan_joints WHERE plan_id = ? ORDER BY position, "
      "joint_index");
  joints.bind(plan_id);
  std::size_t at = 0;
  while (joints.step()) {
    while (at < all.size() && positions[at] < joints.integer(0)) ++at;
    if (at == all.size() || positions[at] != joints.integer(0)) continue;
    session::PlanPoint& point = all[at];
    point.q.conservativeResize(point.q.size() + 1);
    point.q[point.q.size() - 1] = joints.real(1);
    point.approach.push_back(joints.integer(2));
  }
  return all;
}

}  // namespace

PlanId Store::save_plan(SessionId id, const session::Plan& plan) {
  return writing([&] {
    const session::SampleLayout& layout = layout_of(id);
    Statement(*database_, "INSERT INTO plans (session_id, created_utc) VALUES (?, ?)")
        .bind(id.value, now_utc())
        .run();
    const PlanId plan_id{database_->last_row_id()};
    Statement insert(
        *database_,
        "INSERT INTO plan_points (plan_id, position, set_name, point, repeat, target_x_mm, "
        "target_y_mm, target_z_mm) VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
    Statement joint(
        *database_,
        "INSERT INTO plan_joints (plan_id, position, joint_index, joint, unit, value, "
        "approach) "
        "VALUES (?, ?, ?, ?, ?, ?, ?)");
    int position = 0;
    for (const session::PlanPoint& point : plan.points) {
      const std::optional<session::Position> target = point.target_mm;
      if (!point.target_mm.allFinite() || !point.q.allFinite()) {
        throw StoreError(
            StoreTrouble::kRefused, path_, "a point of the plan is not finite",
            "make the plan again");
      }
      if (static_cast<std::size_t>(point.q.size()) != layout.joints.size() ||
          static_cast<std::size_t>(point.target_mm.size()) != layout.axes.size()) {
        throw StoreError(
            StoreTrouble::kRefused, path_,
            fmt::format(
                "a point of the plan has {} joint values and {} coordinates, the rig has {} "
                "and "
                "{}",
                point.q.size(), point.target_mm.size(), layout.joints.size(),
                layout.axes.size()),
            "make the plan for this rig");
      }
      if (point.target_turn_rad) {
        throw StoreError(
            StoreTrouble::kRefused, path_,
            "a point of the plan asks for a turn of the tool, which the store does not keep",
            "take target_rx_deg, target_ry_deg and target_rz_deg out of the plan, or command "
            "it "
            "from the session's folder");
      }
      insert
          .bind(
              plan_id.value, position, session::as_utf8(point.set), point.point, point.repeat,
              coordinate(target, 0), coordinate(target, 1), coordinate(target, 2))
          .run();
      for (std::size_t i = 0; i < layout.joints.size(); ++i) {
        joint
            .bind(
                plan_id.value, position, static_cast<int>(i), layout.joints[i].name,
                layout.joints[i].unit, point.q[static_cast<Eigen::Index>(i)],
                session::approach_of(point, i))
            .run();
      }
      ++position;
    }
    return plan_id;
  });
}

std::optional<session::Plan> Store::load_plan(SessionId id) {
  return reading([&]() -> std::optional<session::Plan> {
    (void)rig_of(id);
    Statement newest(*database_, "SELECT max(id) FROM plans WHERE session_id = ?");
    newest.bind(id.value);
    newest.step();
    if (newest.is_null(0)) return std::nullopt;
    session::Plan plan;
    Statement points(
        *database_, std::string("SELECT ") + kPointColumns +
                        " FROM plan_points AS p WHERE p.plan_id = ? ORDER BY p.position");
    points.bind(newest.number(0));
    plan.points = points_from(*database_, newest.number(0), points);
    return plan;
  });
}

std::vector<PointKey> Store::done_points(SessionId id) {
  return reading([&] {
    (void)rig_of(id);
    std::vector<PointKey> keys;
    Statement query(
        *database_,
        "SELECT set_name, point, repeat FROM live_samples WHERE session_id = ? ORDER BY id");
    query.bind(id.value);
    while (query.step()) keys.push_back({query.text(0), query.integer(1), query.integer(2)});
    return keys;
  });
}

std::vector<session::PlanPoint> Store::open_points(SessionId id) {
  return reading([&] {
    (void)rig_of(id);
    Statement newest(*database_, "SELECT max(id) FROM plans WHERE session_id = ?");
    newest.bind(id.value);
    newest.step();
    if (newest.is_null(0)) return std::vector<session::PlanPoint>();
    Statement query(
        *database_,
        std::string("SELECT ") + kPointColumns +
            " FROM plan_points AS p WHERE p.plan_id = ?1 AND NOT EXISTS (SELECT 1 FROM "
            "live_samples AS s WHERE s.session_id = ?2 AND s.set_name = p.set_name AND s.point "
            "= p.point AND s.repeat = p.repeat) ORDER BY p.position");
    query.bind(newest.number(0), id.value);
    return points_from(*database_, newest.number(0), query);
  });
}

}  // namespace sixdial::db
