// Plans for a session's rig: grids and random points.
#include <array>
#include <string>
#include <vector>

#include "service/methods/shared_params.h"
#include "service/service.h"
#include "session/plan.h"
#include "session/usual_approach.h"

namespace sixdial::service {
namespace {

geometry::Rig rig_of(const Call& call) {
  db::Store& reader = call.service.reader();
  return reader.load_rig(reader.find_session(call.params.at("session").get<std::string>()));
}

session::PlanOptions plan_options(const Json& params, const geometry::Rig& rig) {
  session::PlanOptions options;
  options.set = param_or<std::string>(params, "set", options.set);
  options.repeats = param_or(params, "repeats", options.repeats);
  options.seed = param_or<std::uint64_t>(params, "seed", 1);
  options.margin_mm = param_or(params, "margin_mm", options.margin_mm);
  options.first_point = param_or(params, "first_point", 0);
  for (const auto& mode : param_or<std::vector<std::string>>(params, "modes", {})) {
    options.working_modes.push_back(*geometry::working_mode_from(mode));
  }
  options.approach = *session::approach_rule_from(param_or<std::string>(
      params, "approach", std::string(to_string(session::usual_approach(rig)))));
  return options;
}

Json plan_answer(
    const geometry::Rig& rig, const tl::expected<session::Plan, session::PlanRefusal>& plan) {
  if (!plan) {
    throw Error(
        ErrorCode::kBadData, "the plan is refused: " + plan.error().reason,
        {{"point", plan.error().point}}, plan.error().advice);
  }
  return {
      {"points", plan->points.size()},
      {"plan_csv", session::plan_csv(*plan, rig)},
      {"notes", session::operator_notes(rig, *plan)}};
}

Json plan_grid(const Call& call) {
  const geometry::Rig rig = rig_of(call);
  return plan_answer(
      rig, session::plan_grid(
               rig, call.params.at("nx").get<int>(), call.params.at("ny").get<int>(),
               plan_options(call.params, rig)));
}

Json plan_random(const Call& call) {
  const geometry::Rig rig = rig_of(call);
  return plan_answer(
      rig, session::plan_random(
               rig, call.params.at("count").get<int>(), plan_options(call.params, rig)));
}

using params::kSession;
constexpr std::array<std::string_view, 3> kApproaches{"as-it-comes", "alternate", "both-sides"};
constexpr std::array kPlanCommon{
    kSession,
    Param{.name = "set", .doc = "G1, G2 or another name; default G1"},
    Param{
        .name = "repeats",
        .type = ParamType::kInteger,
        .doc = "readings of each point",
        .min = 1,
        .max = 1000},
    Param{
        .name = "seed",
        .type = ParamType::kInteger,
        .doc = "of order and places; default 1",
        .min = 0},
    Param{
        .name = "margin_mm",
        .type = ParamType::kNumber,
        .doc = "kept free inside the edge; default 1",
        .min = 0},
    Param{
        .name = "first_point",
        .type = ParamType::kInteger,
        .doc = "number of the first point",
        .min = 0,
        .max = 1e9},
    Param{
        .name = "modes",
        .type = ParamType::kStringList,
        .doc = "working modes, each with all the points; default: the rig's",
        .one_of = params::kModeWords},
    Param{
        .name = "approach",
        .doc = "from which side points are reached; default as-it-comes, alternate for a robot "
               "moved by hand",
        .one_of = kApproaches}};

template <std::size_t N>
constexpr auto with_common(const std::array<Param, N>& own) {
  std::array<Param, N + kPlanCommon.size()> all{};
  for (std::size_t i = 0; i < kPlanCommon.size(); ++i) all[i] = kPlanCommon[i];
  for (std::size_t i = 0; i < N; ++i) all[kPlanCommon.size() + i] = own[i];
  return all;
}
constexpr auto kGridParams = with_common(std::array{
    Param{
        .name = "nx",
        .type = ParamType::kInteger,
        .required = true,
        .doc = "points along x",
        .min = 1,
        .max = 1000},
    Param{
        .name = "ny",
        .type = ParamType::kInteger,
        .required = true,
        .doc = "points along y",
        .min = 1,
        .max = 1000}});
constexpr auto kRandomParams = with_common(std::array{Param{
    .name = "count",
    .type = ParamType::kInteger,
    .required = true,
    .doc = "points",
    .min = 1,
    .max = 10000}});

constexpr std::array kMethods{
    RpcMethod{
        .name = "plan.grid",
        .summary = "A plan over a grid of targets that the session's rig can measure.",
        .params = kGridParams,
        .result = "points, plan_csv (text of a plan file), notes [for the operator]",
        .example = R"({"session": "demo", "nx": 10, "ny": 10, "set": "G1", "seed": 1})",
        .runs_on = RunsOn::kLong,
        .command = "sixdial plan grid",
        .run = plan_grid},
    RpcMethod{
        .name = "plan.random",
        .summary = "A plan of random targets that the session's rig can measure.",
        .params = kRandomParams,
        .result = "points, plan_csv (text of a plan file), notes [for the operator]",
        .example = R"({"session": "demo", "count": 50, "set": "G2", "seed": 2})",
        .runs_on = RunsOn::kLong,
        .command = "sixdial plan random",
        .run = plan_random},
};

}  // namespace

std::span<const RpcMethod> plan_methods() { return kMethods; }

}  // namespace sixdial::service
