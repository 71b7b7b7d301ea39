// The comparison of all methods as a job with a stored result.
#include <array>

#include "report/documents/comparison_json.h"
#include "service/document_job.h"
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
constexpr std::array<std::string_view, 2> kProfiles{"default", "paper"};
constexpr Param count(std::string_view name, std::string_view doc, double least) {
  return {.name = name, .type = ParamType::kInteger, .doc = doc, .min = least, .max = 1e6};
}
constexpr std::array kParams{
    Param{.name = "session", .required = true, .doc = "name of the session"},
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
    Param{
        .name = "fix",
        .type = ParamType::kStringList,
        .doc = "parameters that keep their nominal value"},
    Param{
        .name = "free",
        .type = ParamType::kStringList,
        .doc = "only these parameters are fitted; default: all"},
    Param{.name = "loss", .doc = "of lm", .one_of = kLosses},
    Param{
        .name = "profile", .doc = "paper: its literal filter and search", .one_of = kProfiles},
    Param{
        .name = "keep_gross_errors",
        .type = ParamType::kBoolean,
        .doc = "list readings that stand out, but fit them too"},
    Param{
        .name = "seed",
        .type = ParamType::kInteger,
        .doc = "of searches and networks; the same gives the same result; default 1",
        .min = 0},
    count("threads", "0: as many as the machine has; the result is the same", 0),
    count("particles", "instead of 50", 4),
    count("qpso1_iterations", "instead of 100", 1),
    count("qpso2_iterations", "instead of 400", 1),
    count("anfis_epochs", "instead of 500", 1),
    count("bpnn_epochs", "instead of 40000", 1)};

constexpr std::array kMethods{Method{
    .name = "compare.start",
    .summary = "Runs all methods on a session's samples as a job: Table 6 for G1 and G2 with "
               "times. Answers at once.",
    .params = kParams,
    .result = "as job.status",
    .example = R"({"session": "demo", "methods": ["before", "lm", "lm+gp"], "seed": 7})",
    .run = start_comparison}};

}  // namespace

std::span<const Method> compare_methods() { return kMethods; }

}  // namespace sixdial::service
