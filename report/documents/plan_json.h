// What plan next, plan separate, plan rig-check and plan sockets tell besides the plan itself:
// the answers of the service's plan.next and plan.separate, and of `sixdial plan ... --json`.
#pragma once

#include "report/documents/json.h"
#include "studies/next_plan.h"
#include "studies/rig_check.h"
#include "studies/separation_plan.h"
#include "studies/socket_plan.h"

namespace sixdial::report {

[[nodiscard]] Json to_json(const studies::NextPlanFigures& figures);
[[nodiscard]] Json to_json(const studies::SeparationFigures& figures);
[[nodiscard]] Json to_json(const studies::RigCheckFigures& figures);
[[nodiscard]] Json to_json(const studies::SocketPlanFigures& figures);

/// The figures with the plan: plan_csv (text of a plan file) and notes (for the operator).
[[nodiscard]] Json plan_answer(const studies::NextPlan& made, const geometry::Rig& rig);
[[nodiscard]] Json plan_answer(const studies::SeparationPlan& made, const geometry::Rig& rig);
[[nodiscard]] Json plan_answer(const studies::RigCheck& made, const geometry::Rig& rig);

/// With the tables of the sockets for rig.toml too: rig_toml.
[[nodiscard]] Json plan_answer(const studies::SocketPlan& made);

/// Throw studies::StudyError bad_data that names the key which is missing or of the wrong kind.
[[nodiscard]] studies::NextPlanFigures next_plan_from_json(const Json& json);
[[nodiscard]] studies::SeparationFigures separation_from_json(const Json& json);
[[nodiscard]] studies::RigCheckFigures rig_check_from_json(const Json& json);
[[nodiscard]] studies::SocketPlanFigures socket_plan_from_json(const Json& json);

}  // namespace sixdial::report
