// The verdict as programs get it: the JSON of spec 4 held against the answers of twenty
// bundles, cancelled, refused, with dials renamed and rows shuffled, from positions alone,
// without G2.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "report/documents/diagnosis_json.h"
#include "report/report_run.h"
#include "report/sections/sections_of_studies.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/diagnose.h"
#include "tests/studies/diagnosis_parts.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;

// A size is a normal estimate: five of its standard deviations are never missed by chance.
constexpr double kSigmas = 5.0;
// A fit in another order of readings or from another start stops within this of the same size.
constexpr double kSameSize = 1e-4;

/// The true size where the answer has one number that is the size of its first parameter.
std::optional<double> true_size(const Json& answer, const std::string& cause) {
  static const std::map<std::string, std::pair<std::string, std::size_t>> kWhere{
      {"joint_backlash", {"backlash", 1}}, {"link_thermal_growth", {"thermal", 0}},
      {"dial_gain", {"dial_gain", 1}},     {"dial_lean", {"dial_lean", 1}},
      {"dial_mount", {"dial_mount", 1}},   {"cuboid_squareness", {"squareness", 0}}};
  const auto found = kWhere.find(cause);
  if (found == kWhere.end()) return std::nullopt;
  return answer["effects"][found->second.first][found->second.second].get<double>();
}

struct AnsweredSession : ::testing::TestWithParam<int> {};

TEST_P(AnsweredSession, HasTheVerdictOfItsAnswerAsJson) {
  const std::string number = fmt::format("{:02}", GetParam());
  const Json answer = Json::parse(std::ifstream(kSessions / number / "answer.json"));
  const Json document = Json::parse(quick(session_of(number)).dump());
  EXPECT_EQ(report::to_json(report::diagnosis_from_json(document)), document);
  std::set<std::string> truth;
  for (const Json& cause : answer["causes"]) {
    truth.insert(cause[0].get<std::string>() + "@" + cause[1].get<std::string>());
  }
  if (answer["effects"].contains("outliers")) truth.insert("outliers@samples");
  std::set<std::string> covered;
  for (const Json& cause : document["causes"]) {
    std::set<std::string> names{name_of(cause)};
    for (const Json& rival : cause["tied_with"]) names.insert(name_of(rival));
    EXPECT_EQ(cause["certainty"], names.size() == 1 ? "certain" : "tied");
    if (names.size() == 1) {
      EXPECT_TRUE(truth.contains(*names.begin())) << *names.begin();
    }
    covered.insert(names.begin(), names.end());
    if (!truth.contains(name_of(cause))) continue;
    if (const auto size = true_size(answer, cause["cause"])) {
      const Json& estimate = cause["estimate"][0];
      // Which of two faces is turned, and which way, is the generator's own convention.
      EXPECT_LT(
          std::abs(std::abs(estimate["value"].get<double>()) - std::abs(*size)),
          kSigmas * estimate["sd"].get<double>())
          << name_of(cause);
    }
  }
  for (const std::string& name : truth) EXPECT_TRUE(covered.contains(name)) << name;
  EXPECT_EQ(document["unexplained"]["significant"], answer["unknown"]);
  if (answer["unknown"].get<bool>()) {
    EXPECT_THAT(document["unexplained"]["depends_on"], ::testing::Contains("x"));
    EXPECT_EQ(document["verdict"]["kind"], "unknown");
  }
}
INSTANTIATE_TEST_SUITE_P(, AnsweredSession, ::testing::Range(0, 20));

/// Numbers of a list in which the other entries are null.
int count_numbers(const Json& list, const char* key) {
  return static_cast<int>(
      std::ranges::count_if(list, [&](const Json& each) { return each[key].is_number(); }));
}

TEST(Diagnosis, TheJsonHasWhatTheContractAsksFor) {
  const session::Session session = session_of("17");
  DiagnosisRequest request;
  request.bootstrap = 20;
  const Json document = Json::parse(report::to_json(diagnose(session, request)).dump());
  EXPECT_EQ(document["schema"], "sixdial.diagnosis");
  EXPECT_EQ(document["schema_version"], report::kDiagnosisSchemaVersion);
  EXPECT_EQ(
      names_of(document),
      (std::set<std::string>{"dial_gain@B", "dial_lean@C", "dial_mount@C"}));
  for (const Json& cause : document["causes"]) {
    EXPECT_EQ(cause["certainty"], "certain");
    EXPECT_EQ(cause["standing"], "confirmed");
    EXPECT_TRUE(cause["tied_with"].empty());
    EXPECT_GT(cause["delta_bic"], 10.0);
    EXPECT_GT(cause["gain"], 0.0);
    EXPECT_GT(cause["visible_ratio"], 1.0);
    EXPECT_EQ(count_numbers(cause["estimate"], "sd"), 1);
    for (const char* key : {"signature", "consequence", "advice", "in_words"}) {
      EXPECT_FALSE(cause[key].get<std::string>().empty()) << key;
    }
    EXPECT_TRUE(cause["signature_plot"].is_object());
  }
  const Json& left = document["unexplained"];
  EXPECT_EQ(left["significant"], false);
  EXPECT_TRUE(left["depends_on"].empty());
  // 850 readings know their root mean square to 2.5 %.
  EXPECT_LT(std::abs(left["rms_mm"].get<double>() / left["noise_mm"].get<double>() - 1), 0.1);
  EXPECT_EQ(document["noise"]["source"], "rig_file");

  std::set<std::string> causes;
  for (const Json& limit : document["detection_limits"]) {
    causes.insert(limit["cause"].get<std::string>());
    EXPECT_FALSE(limit["unit"].get<std::string>().empty());
    if (limit["name"].is_number()) {
      EXPECT_GE(limit["name"].get<double>(), limit["detect"].get<double>());
    } else {
      EXPECT_TRUE(limit["reason"].is_string());
    }
  }
  EXPECT_GT(causes.size(), 15U);
  for (const char* fit : {"baseline", "extended"}) {
    EXPECT_EQ(document[fit]["parameters"].size(), 11U);  // the ten, and the clamp
    EXPECT_EQ(count_numbers(document[fit]["parameters"], "sd"), 11);
  }
  std::vector<std::string> rows;
  for (const Json& row : document["gain"]) {
    rows.push_back(row["name"]);
    EXPECT_EQ(row["rms_by_dial_mm"].size(), 6U);
  }
  EXPECT_THAT(
      rows, ::testing::IsSupersetOf(
                {"nominal", "calibrated", "calibrated + ANFIS", "extended", "extended + ANFIS",
                 "without dial_gain@B", "without dial_lean@C", "without dial_mount@C"}));
  const Json& residuals = document["residuals"];
  for (const char* key : {"sample", "dial", "measured_mm", "before_mm", "after_mm", "good"}) {
    EXPECT_EQ(residuals[key].size(), residuals["sample"].size()) << key;
  }
  // Each reading is one of the session's, under its own sample and dial.
  const auto dial_index = [&](const std::string& id) {
    for (std::size_t i = 0; i < session.rig.dials.size(); ++i) {
      if (session.rig.dials[i].id == id) return i;
    }
    throw std::runtime_error("no dial " + id);
  };
  for (std::size_t i = 0; i < residuals["sample"].size(); ++i) {
    const auto& sample = session.samples[residuals["sample"][i].get<std::size_t>()];
    EXPECT_EQ(
        sample.channels[dial_index(residuals["dial"][i])].value,
        residuals["measured_mm"][i].get<double>());
  }
  EXPECT_EQ(document["inputs"]["data_hash"], "sha256:" + session::data_sha256(session));
  EXPECT_EQ(document["inputs"]["rig_hash"], "sha256:" + session::rig_sha256(session));
}

TEST(Diagnosis, TheSameSeedGivesTheSameDocumentWithAnyNumberOfThreads) {
  for (const char* number : {"06", "12"}) {
    const session::Session session = session_of(number);
    std::set<std::string> documents;
    for (const int threads : {1, 1, 2, 5}) {
      Json document = report::to_json(diagnose(session, {.bootstrap = 20, .threads = threads}));
      document.erase("seconds");
      document.erase("created_utc");
      documents.insert(document.dump());
    }
    EXPECT_EQ(documents.size(), 1u) << number;
  }
}

TEST(Diagnosis, OtherNamesAndAnotherOrderOfTheDialsChangeNothingButNames) {
  const session::Session session = session_of("17");
  session::Session other = session;
  const std::array<std::size_t, 6> order{4, 2, 0, 5, 1, 3};
  std::map<std::string, std::string> renamed;
  for (std::size_t i = 0; i < order.size(); ++i) {
    other.rig.dials[i] = session.rig.dials[order[i]];
    other.rig.dials[i].id = fmt::format("d{}", i + 1);
    renamed[session.rig.dials[order[i]].id] = other.rig.dials[i].id;
  }
  for (std::size_t s = 0; s < session.samples.size(); ++s) {
    for (std::size_t i = 0; i < order.size(); ++i) {
      other.samples[s].channels[i] = session.samples[s].channels[order[i]];
    }
  }
  const Json before = quick(session);
  const Json after = quick(other);
  ASSERT_EQ(before["causes"].size(), 3U);
  ASSERT_EQ(after["causes"].size(), 3U);
  for (const Json& cause : before["causes"]) {
    const Json& same =
        cause_of(after, cause["cause"].get<std::string>() + "@" + renamed.at(cause["where"]));
    EXPECT_EQ(same["certainty"], cause["certainty"]);
    const double size = cause["estimate"][0]["value"];
    EXPECT_LT(
        std::abs(same["estimate"][0]["value"].get<double>() - size),
        kSameSize * std::abs(size));
  }
}

TEST(Diagnosis, RowsInAnotherOrderTellTheSameOfWhatDoesNotDependOnIt) {
  session::Session session = session_of("03");
  const Json before = quick(session);
  std::ranges::shuffle(session.samples, std::mt19937_64(20211));
  const Json after = quick(session);
  EXPECT_EQ(names_of(before), std::set<std::string>{"dial_gain@F"});
  EXPECT_EQ(names_of(after), names_of(before));
  const double size = before["causes"][0]["estimate"][0]["value"];
  EXPECT_LT(
      std::abs(after["causes"][0]["estimate"][0]["value"].get<double>() - size),
      kSameSize * std::abs(size));
  // Hysteresis and clearance do depend on the order: they are still looked for.
  EXPECT_EQ(before["detection_limits"].size(), after["detection_limits"].size());
}

TEST(Diagnosis, WithoutG2TheProgramHoldsSamplesBack) {
  session::Session session = session_of("01");
  for (session::Sample& sample : session.samples) sample.set = "G1";
  DiagnosisRequest request;
  request.bootstrap = 0;
  const Json document = report::to_json(diagnose(session, request));
  EXPECT_EQ(document["judged_on"]["held_out_by_program"], true);
  EXPECT_EQ(document["judged_on"]["samples"], 50);
  EXPECT_EQ(names_of(document), std::set<std::string>{"joint_backlash@joint2"});
  EXPECT_EQ(document["causes"][0]["standing"], "confirmed");
  EXPECT_THAT(
      document["verdict"]["headline"].get<std::string>(),
      HasSubstr("set aside by the program"));
}

TEST(Diagnosis, PositionsAloneShowTheRobotsCausesAndSayWhatTheyCannot) {
  session::Session session = session_of("01");
  const auto trials = session::trials_of(session, "");
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    session::Sample& sample = session.samples[i];
    for (session::ChannelValue& dial : sample.channels) dial.value.reset();
    if (trials[i].position_mm) {
      session::set_position(
          sample, session.rig.dials.size(), session::Position(*trials[i].position_mm));
    }
  }
  const DiagnosisResult result = quick_result(session);
  const Json document = report::to_json(result);
  EXPECT_EQ(names_of(document), std::set<std::string>{"joint_backlash@joint2"});
  const auto blind = std::ranges::count_if(document["not_testable"], [](const Json& each) {
    return each["cause"] == "dial_gain" && !each["reason"].get<std::string>().empty() &&
           !each["needs"].get<std::string>().empty();
  });
  EXPECT_EQ(blind, 6);
  EXPECT_EQ(report::to_json(report::diagnosis_from_json(document)), document);
  EXPECT_EQ(document["residuals"]["dial"][0], "x");
  EXPECT_EQ(document["residuals"]["dial"][1], "y");
  const std::string page = report::diagnosis_page(result, session, "tester");
  EXPECT_THAT(page, HasSubstr("Backlash of joint 2"));
}

TEST(Diagnosis, GrossReadingsAndReadingsHandedOverTwiceAreToldApart) {
  session::Session session = session_of("00");
  for (const std::size_t sample : {20U, 55U, 90U}) {  // C shows what it showed before
    session.samples[sample].channels[2] = session.samples[sample - 1].channels[2];
  }
  *session.samples[40].channels[0].value += 0.3;
  *session.samples[70].channels[1].value -= 0.2;
  const Json document = quick(session);
  EXPECT_EQ(
      names_of(document), (std::set<std::string>{"outliers@samples", "stale_reading@samples"}));
  EXPECT_EQ(cause_of(document, "stale_reading@samples")["estimate"][0]["value"], 3.0);
  EXPECT_EQ(cause_of(document, "outliers@samples")["estimate"][0]["value"], 2.0);
  std::set<std::pair<int, std::string>> listed;
  for (const Json& each : document["gross_readings"]) {
    listed.emplace(each["sample"].get<int>(), each["dial"].get<std::string>());
  }
  EXPECT_EQ(
      listed, (std::set<std::pair<int, std::string>>{
                  {20, "C"}, {55, "C"}, {90, "C"}, {40, "A"}, {70, "B"}}));
}

TEST(Diagnosis, APlungerThatHardlyMovedIsNotStale) {
  session::Session session = session_of("00");
  // The same pose again, the same readings: right, though equal to the sample before.
  session::Sample again = session.samples[30];
  again.repeat = 1;
  session.samples.insert(session.samples.begin() + 31, again);
  EXPECT_TRUE(names_of(quick(session)).empty());
}

TEST(Diagnosis, TooFewReadingsAreRefusedInWords) {
  session::Session session = session_of("00");
  session.samples.resize(3);
  try {
    static_cast<void>(quick(session));
    ADD_FAILURE() << "a diagnosis of three samples was made";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kBadData);
    EXPECT_THAT(error.what(), HasSubstr("at least"));
    EXPECT_FALSE(error.hint().empty());
  }
  EXPECT_THROW(
      (void)report::diagnosis_from_json({{"schema", "sixdial.calibration"}}), StudyError);
}

TEST(Diagnosis, IsCancelledBetweenItsStages) {
  std::stop_source stop;
  std::vector<std::string> stages;
  try {
    static_cast<void>(diagnose(
        session_of("06"), {},
        [&](const Progress& progress) {
          stages.push_back(progress.stage);
          if (stages.size() == 2) stop.request_stop();
        },
        stop.get_token()));
    ADD_FAILURE() << "a cancelled diagnosis was given back";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kCancelled);
  }
  EXPECT_EQ(stages.size(), 2U);
}

}  // namespace
}  // namespace sixdial::studies
