// Parameters that several methods have: each is described once.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>

#include "service/methods/method.h"

namespace sixdial::service::params {

inline constexpr Param kSession{
    .name = "session", .required = true, .doc = "name of the session"};
inline constexpr Param kFix{
    .name = "fix",
    .type = ParamType::kStringList,
    .doc = "parameters that keep their nominal value"};
inline constexpr Param kFree{
    .name = "free",
    .type = ParamType::kStringList,
    .doc = "only these parameters are fitted; default: all"};
inline constexpr Param kKeepGrossErrors{
    .name = "keep_gross_errors",
    .type = ParamType::kBoolean,
    .doc = "list readings that stand out, but fit them too"};

inline constexpr Param kFromOtherSession{
    .name = "from_other_session",
    .type = ParamType::kBoolean,
    .doc =
        "take a result or diagnosis that belongs to another session than `session`; else it "
        "is refused"};

inline constexpr Param kTolerance{
    .name = "tolerance_mm",
    .type = ParamType::kNumber,
    .doc =
        "largest position error that is accepted; default: what the rig file states, if it "
        "does",
    .min = 1e-6,
    .max = 1e6};

inline constexpr std::array<std::string_view, 2> kProfileWords{"default", "paper"};
inline constexpr std::array<std::string_view, 4> kModeWords{"++", "+-", "-+", "--"};

constexpr Param count(std::string_view name, std::string_view doc, double least) {
  return {.name = name, .type = ParamType::kInteger, .doc = doc, .min = least, .max = 1e6};
}
inline constexpr Param kThreads =
    count("threads", "0: as many as the machine has; the result is the same", 0);
inline constexpr Param kParticles = count("particles", "instead of 50", 4);
inline constexpr Param kQpso1 = count("qpso1_iterations", "instead of 100", 1);
inline constexpr Param kQpso2 = count("qpso2_iterations", "instead of 400", 1);
inline constexpr Param kAnfisEpochs = count("anfis_epochs", "instead of 500", 1);

[[nodiscard]] inline bool from_other_session(const Json& params) {
  return param_or(params, "from_other_session", false);
}

/// params["path"] of a call. Paths go to another process: a relative one would mean that
/// process's directory, not the client's. Throws Error invalid_params for one.
[[nodiscard]] std::filesystem::path absolute_path(const Call& call);

}  // namespace sixdial::service::params
