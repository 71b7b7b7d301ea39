// The comparison of all methods as a job with a stored result.
#include <array>

#include "report/documents/comparison_json.h"
#include "service/document_job.h"
#include "service/methods/shared_params.h"
#include "service/service.h"
#include "service/study_params.h"

namespace sixdial::service {
namespace {

Json start_comparison(const Call& call) {
  const studies::CompareRequest request = comparison_request(call.params);
  studies::check_methods(request.methods);
  return start_document_job(
      call, "comparison", request.seed,
      [request](
          const session::Session& session, const studies::ProgressCallback& progress,
          std::stop_token stop) {
        return report::to_json(studies::compare(session, request, progress, std::move(stop)));
      });
}

constexpr std::array<std::string_view, 2> kSpaces{"positions", "dials"};
constexpr std::array<std::string_view, 3> kLosses{"square", "huber", "cauchy"};
constexpr std::array kParams{
    params::kSession,
    Param{
        .name = "methods",
        .type = ParamType::kStringList,
        .doc =
            "\"before\", an identifier, or an identifier, '+' and a residual model; default: "
            "the paper's and its rivals"},
    Param{
        .name = "space",
        .doc = "what is fitted: positions, or raw readings of all dials in contact",
        .one_of = kSpaces},
    params::kFix,
    params::kFree,
    Param{.name = "loss", .doc = "of lm", .one_of = kLosses},
    Param{
        .name = "profile",
        .doc = "paper: its literal filter and search",
        .one_of = params::kProfileWords},
    params::kKeepGrossErrors,
    Param{
        .name = "seed",
        .type = ParamType::kInteger,
        .doc = "of searches and networks; the same gives the same result; default 1",
        .min = 0},
    params::kThreads,
    params::kParticles,
    params::kQpso1,
    params::kQpso2,
    params::kAnfisEpochs,
    params::count("bpnn_epochs", "instead of 40000", 1)};

constexpr std::array kMethods{RpcMethod{
    .name = "compare.start",
    .summary = "Runs all methods on a session's samples as a job: Table 6 for G1 and G2 with "
               "times. Answers at once.",
    .params = kParams,
    .result = "as job.status",
    .example = R"({"session": "demo", "methods": ["before", "lm", "lm+gp"], "seed": 7})",
    .run = start_comparison}};

}  // namespace

std::span<const RpcMethod> compare_methods() { return kMethods; }

}  // namespace sixdial::service
