#include "report/documents/plan_json.h"

#include "report/documents/fields.h"
#include "session/rig_file.h"

namespace sixdial::report {
namespace {

template <class Fields, class Mode>
void mode_key(Fields& at, Mode& mode) {
  at.named(
      "mode", mode, [](geometry::WorkingMode each) { return geometry::to_string(each); },
      geometry::working_mode_from);
}

Json with_plan(Json figures, const session::Plan& plan, const geometry::Rig& rig) {
  figures["plan_csv"] = session::plan_csv(plan, rig);
  figures["notes"] = session::operator_notes(rig, plan);
  return figures;
}

}  // namespace

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PositionSd>& sd) {
  at("mean_mm", sd.mean_mm);
  at("max_mm", sd.max_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::NextStep>& step) {
  at("target_mm", step.target_mm);
  mode_key(at, step.mode);
  describe_keys(at, step.after);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::NextPlanFigures>& figures) {
  at("samples", figures.samples);
  at("points", figures.points);
  at.named(
      "criterion", figures.criterion,
      [](calibration::Criterion each) { return calibration::to_string(each); },
      calibration::criterion_from);
  at("now", figures.now);
  at("after", figures.after);
  at("steps", figures.steps);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PlacedCause>& placed) {
  at("cause", placed.cause);
  at("where", placed.where);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::SeparationPoint>& point) {
  at("target_mm", point.target_mm);
  mode_key(at, point.mode);
  at("log_odds", point.log_odds);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::SeparationFigures>& figures) {
  at("separates", figures.separates);
  at("rival", figures.rival);
  at("size_assumed", figures.size_assumed);
  at("unit", figures.unit);
  at("points", figures.points);
  at("log_odds_now", figures.log_odds_now);
  at("log_odds_after", figures.log_odds_after);
  at("by_point", figures.by_point);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::RigCheckQuantity>& quantity) {
  at("name", quantity.name);
  at("unit", quantity.unit);
  at("stated", quantity.stated);
  at("sd", quantity.sd);
  at("left", quantity.left);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::RigCheckStage>& stage) {
  at("points", stage.points);
  at("left", stage.left);
  at("position_mm", stage.position_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::RigCheckFigures>& figures) {
  at("points", figures.points);
  at("quantities", figures.quantities);
  at("stages", figures.stages);
  at("exact_rig_mm", figures.exact_rig_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PlannedSocket>& socket) {
  at("name", socket.name);
  at("at_mm", socket.at_mm);
  at("poses", socket.poses);
  at("least_lean_rad", socket.least_lean_rad);
  at("most_lean_rad", socket.most_lean_rad);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PlannedDistance>& distance) {
  at("first", distance.first);
  at("second", distance.second);
  at("mm", distance.mm);
  at("sd_mm", distance.sd_mm);
  at("places_mm", distance.places_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::PlannedParameter>& parameter) {
  at("name", parameter.name);
  at("unit", parameter.unit);
  at("sd", parameter.sd);
  at("open", parameter.open);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::SocketStage>& stage) {
  at("poses", stage.poses);
  at("position", stage.position);
  at("open_mm", stage.open_mm);
  at("open", stage.open);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::SocketPlanFigures>& figures) {
  at("points", figures.points);
  at("sockets", figures.sockets);
  at("distances", figures.distances);
  at("seat_sd_mm", figures.seat_sd_mm);
  at("seat_sd_assumed", figures.seat_sd_assumed);
  at("cone_rad", figures.cone_rad);
  at.named(
      "criterion", figures.criterion,
      [](calibration::Criterion each) { return calibration::to_string(each); },
      calibration::criterion_from);
  at("scale_is_open", figures.scale_is_open);
  at("socket_stages", figures.stages);
  at("parameters", figures.parameters);
}

Json to_json(const studies::NextPlanFigures& figures) { return write(figures); }
Json to_json(const studies::SeparationFigures& figures) { return write(figures); }
Json to_json(const studies::RigCheckFigures& figures) { return write(figures); }
Json to_json(const studies::SocketPlanFigures& figures) { return write(figures); }

Json plan_answer(const studies::NextPlan& made, const geometry::Rig& rig) {
  return with_plan(to_json(made.figures), made.plan, rig);
}
Json plan_answer(const studies::SeparationPlan& made, const geometry::Rig& rig) {
  return with_plan(to_json(made.figures), made.plan, rig);
}
Json plan_answer(const studies::RigCheck& made, const geometry::Rig& rig) {
  return with_plan(to_json(made.figures), made.plan, rig);
}

Json plan_answer(const studies::SocketPlan& made) {
  Json answer = with_plan(to_json(made.figures), made.plan, made.rig);
  answer["rig_toml"] = session::instrument_text(made.rig);
  return answer;
}

studies::NextPlanFigures next_plan_from_json(const Json& json) {
  return read<studies::NextPlanFigures>(json, "plan.next");
}
studies::SeparationFigures separation_from_json(const Json& json) {
  return read<studies::SeparationFigures>(json, "plan.separate");
}
studies::RigCheckFigures rig_check_from_json(const Json& json) {
  return read<studies::RigCheckFigures>(json, "plan rig-check");
}

studies::SocketPlanFigures socket_plan_from_json(const Json& json) {
  return read<studies::SocketPlanFigures>(json, "plan sockets");
}

}  // namespace sixdial::report
