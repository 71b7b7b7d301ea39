// The twenty sessions of tests/data/sessions: hidden effects by a generator outside the
// project, with answers. They are examples, not what the diagnosis was tuned to; see
// bench/blind_challenge.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "diagnosis/estimates.h"
#include "diagnosis/naming.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "tests/support/paths.h"

namespace sixdial::diagnosis {
namespace {

namespace fs = std::filesystem;

struct Verdict {
  std::set<std::string> certain;            // "cause@where"
  std::vector<std::set<std::string>> tied;  // sets that cannot be told apart
  std::set<std::string> unknown;            // covariates
  std::size_t gross = 0;
  double noise_mm = 0.0;  // of the extended model
};

Verdict verdict_of(const fs::path& bundle) {
  const auto session = session::read_bundle(bundle);
  const simulation::ForwardModel model(session.rig);
  Readings readings(model, session::trials_of(session, ""));
  const NamedCauses found = name_causes(readings);
  Verdict verdict;
  for (const Finding& finding : found.findings) {
    if (finding.certain()) {
      verdict.certain.insert(finding.hypothesis.name());
      continue;
    }
    std::set<std::string> tie{finding.hypothesis.name()};
    for (const Rival& rival : finding.tied_with) tie.insert(rival.hypothesis.name());
    verdict.tied.push_back(tie);
  }
  if (found.swap) verdict.certain.insert(found.swap->name());
  for (const auto& covariate : found.depends_on()) verdict.unknown.insert(covariate);
  verdict.gross = found.gross.size();
  verdict.noise_mm = found.extended.s_mm;
  return verdict;
}

struct MeasuredSession : testing::TestWithParam<std::string> {};

TEST_P(MeasuredSession, IsNamedAsItsAnswerSaysOrInATie) {
  const fs::path folder = fs::path(test_paths::test_data()) / "sessions" / GetParam();
  const auto answer = nlohmann::json::parse(std::ifstream(folder / "answer.json"));
  const Verdict verdict = verdict_of(folder);
  std::set<std::string> truth;
  bool gross = answer["effects"].contains("outliers");
  for (const auto& cause : answer["causes"]) {
    const std::string name =
        fmt::format("{}@{}", cause[0].get<std::string>(), cause[1].get<std::string>());
    if (name != "outliers@samples") truth.insert(name);
  }
  if (answer["unknown"].get<bool>()) {
    EXPECT_FALSE(verdict.unknown.empty());
    EXPECT_TRUE(verdict.certain.empty());
    return;
  }
  for (const std::string& name : truth) {
    const bool in_tie = std::any_of(
        verdict.tied.begin(), verdict.tied.end(),
        [&](const auto& tie) { return tie.contains(name); });
    EXPECT_TRUE(verdict.certain.contains(name) || in_tie) << name << " was not found";
  }
  for (const std::string& name : verdict.certain) {
    EXPECT_TRUE(truth.contains(name)) << name << " is not there";
  }
  EXPECT_TRUE(verdict.unknown.empty());
  EXPECT_EQ(verdict.gross > 0, gross);
  // What is left is the dials' noise: 0.002 mm and rounding, known to 2.5 % from 850 readings.
  EXPECT_LT(std::abs(verdict.noise_mm - 0.00202), 0.1 * 0.00202);
}

// The torque of the plungers by somebody else's virtual work: stiffnesses come out as they
// were.
TEST(MeasuredCompliance, IsThatOfTheAnswer) {
  const fs::path folder = fs::path(test_paths::test_data()) / "sessions" / "09";
  const auto answer = nlohmann::json::parse(std::ifstream(folder / "answer.json"));
  const auto session = session::read_bundle(folder);
  const simulation::ForwardModel model(session.rig);
  Readings readings(model, session::trials_of(session, ""));
  const NamedCauses found = name_causes(readings);
  ASSERT_EQ(found.findings.size(), 1U);
  ASSERT_EQ(found.findings[0].hypothesis.name(), "joint_compliance@joints");
  EXPECT_TRUE(found.findings[0].certain());
  const auto estimates = estimates_of(found.extended, 0);
  ASSERT_EQ(estimates.size(), 2U);
  for (std::size_t joint = 0; joint < 2; ++joint) {
    const double truth = 1 / answer["effects"]["compliance"][joint].get<double>();
    EXPECT_LT(std::abs(estimates[joint].value - truth), 3 * estimates[joint].sd) << joint;
  }
}

std::vector<std::string> all_sessions() {
  std::vector<std::string> names;
  for (int i = 0; i < 20; ++i) names.push_back(fmt::format("{:02}", i));
  return names;
}
INSTANTIATE_TEST_SUITE_P(
    , MeasuredSession, testing::ValuesIn(all_sessions()),
    [](const auto& each) { return fmt::format("Session{}", each.param); });

}  // namespace
}  // namespace sixdial::diagnosis
