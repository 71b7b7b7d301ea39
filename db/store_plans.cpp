// Plans: what a session should measure, what of it is done.
#include <utility>

#include "db/store_steps.h"
#include "session/csv.h"

namespace sixdial::db {
namespace {

constexpr const char* kPointColumns =
    "p.set_name, p.point, p.repeat, p.target_x_mm, p.target_y_mm, p.theta1_rad, p.theta2_rad, "
    "p.approach1, p.approach2";

session::PlanPoint point_of(const Statement& row) {
  session::PlanPoint point;
  point.set = row.text(0);
  point.point = row.integer(1);
  point.repeat = row.integer(2);
  point.target_mm = {row.real(3), row.real(4)};
  point.q_rad = {row.real(5), row.real(6)};
  point.approach = {row.integer(7), row.integer(8)};
  return point;
}

}  // namespace

PlanId Store::save_plan(SessionId id, const session::Plan& plan) {
  return writing([&] {
    (void)rig_of(id);
    Statement(*database_, "INSERT INTO plans (session_id, created_utc) VALUES (?, ?)")
        .bind(id.value, now_utc())
        .run();
    const PlanId plan_id{database_->last_row_id()};
    Statement insert(
        *database_,
        "INSERT INTO plan_points (plan_id, position, set_name, point, repeat, target_x_mm, "
        "target_y_mm, theta1_rad, theta2_rad, approach1, approach2) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    int position = 0;
    for (const session::PlanPoint& point : plan.points) {
      if (!point.target_mm.allFinite() || !point.q_rad.allFinite()) {
        throw StoreError(
            StoreTrouble::kRefused, path_, "a point of the plan is not finite",
            "make the plan again");
      }
      insert
          .bind(
              plan_id.value, position++, session::as_utf8(point.set), point.point, point.repeat,
              point.target_mm.x(), point.target_mm.y(), point.q_rad[0], point.q_rad[1],
              point.approach[0], point.approach[1])
          .run();
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
    while (points.step()) plan.points.push_back(point_of(points));
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
    std::vector<session::PlanPoint> points;
    Statement query(
        *database_,
        std::string("SELECT ") + kPointColumns +
            " FROM plan_points AS p WHERE p.plan_id = (SELECT max(id) FROM plans WHERE "
            "session_id = ?1) AND NOT EXISTS (SELECT 1 FROM live_samples AS s WHERE "
            "s.session_id = ?1 AND s.set_name = p.set_name AND s.point = p.point AND "
            "s.repeat = p.repeat) ORDER BY p.position");
    query.bind(id.value);
    while (query.step()) points.push_back(point_of(query));
    return points;
  });
}

}  // namespace sixdial::db
