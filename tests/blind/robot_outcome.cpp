#include "tests/blind/robot_outcome.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace sixdial::blind {

ChallengeFolder::ChallengeFolder(const std::string& name, std::uint64_t seed)
    : path_(
          std::filesystem::temp_directory_path() /
          fmt::format("sixdial_{}_{}_{}", name, ::getpid(), seed)) {}

ChallengeFolder::~ChallengeFolder() { std::filesystem::remove_all(path_); }

void judge(const studies::DiagnosisResult& result, RobotOutcome& outcome) {
  std::size_t exact = 0;
  std::size_t tied = 0;
  std::vector<std::string> found;
  for (const studies::FoundCause& cause : result.causes) {
    if (cause.is_data_fault()) continue;
    const std::string name = cause.id.name();
    found.push_back(name);
    const auto is_true = [&](const std::string& each) {
      return std::ranges::find(outcome.truth, each) != outcome.truth.end();
    };
    const bool certain = cause.tied_with.empty();
    bool touches = is_true(name);
    for (const studies::Rival& rival : cause.tied_with) {
      touches =
          touches || (rival.kind == studies::RivalKind::kEffect && is_true(rival.id.name()));
    }
    exact += certain && is_true(name);
    tied += touches;
    outcome.wrong = outcome.wrong || (certain && !is_true(name));
    outcome.said += fmt::format("{}{} ", name, certain ? "" : "?");
  }
  for (const std::string& each : result.unexplained.depends_on)
    outcome.said += "~" + each + " ";
  if (result.unexplained.scatter) outcome.said += "scatter ";
  outcome.detected = !found.empty() || !result.unexplained.depends_on.empty();
  const std::size_t hidden = outcome.truth.size();
  outcome.named = hidden > 0 && exact == hidden && found.size() == hidden;
  outcome.in_tie = hidden > 0 && tied >= hidden;
}

}  // namespace sixdial::blind
