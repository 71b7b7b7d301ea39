// What the verdicts and the commands make of what speaks against a session.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>

#include "geometry/units.h"
#include "report/documents/calibration_json.h"
#include "report/documents/warnings_document.h"
#include "report/headline.h"
#include "report/report_run.h"
#include "report/words/warning_words.h"
#include "session/bundle.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/plausibility.h"
#include "studies/plausibility/check.h"
#include "studies/stored_warnings.h"
#include "tests/studies/plausible_session.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// All samples at the first poses, with the noise of their own.
session::Session session_at(std::size_t poses) {
  return session_with([&](session::Session& each) {
    std::vector<session::Sample> kept(
        each.samples.begin(), each.samples.begin() + static_cast<std::ptrdiff_t>(poses));
    each.samples.clear();
    for (int repeat = 0; repeat < 20; ++repeat) {
      for (session::Sample sample : kept) {
        sample.repeat = repeat;
        for (std::size_t i = 0; i < each.rig.dials.size(); ++i) {
          if (sample.channels[i].value)
            *sample.channels[i].value += 0.001 * ((repeat + 3 * static_cast<int>(i)) % 5);
        }
        each.samples.push_back(sample);
      }
    }
  });
}

TEST(Plausibility, TooFewPosesCalibrateNothingAndAccuseNobody) {
  for (const std::size_t poses : {std::size_t{1}, std::size_t{3}, std::size_t{4}}) {
    const CalibrationResult result = calibrate(session_at(poses), quick());
    ASSERT_TRUE(result.warnings);
    EXPECT_THAT(codes_of(*result.warnings), ::testing::Contains("too_few_poses"));
    EXPECT_THAT(result.gross_errors->found, IsEmpty());
    const report::Verdict said = report::verdict_of(result);
    EXPECT_EQ(said.state, report::CalibrationState::kNotCalibrated);
    EXPECT_THAT(said.headline, Not(HasSubstr("times less")));
    // What the poses leave open is as uncertain as before.
    double widest_mm = 0.0;
    for (const ParameterRow& row : result.assessment->parameters) {
      if (row.unit == "mm") widest_mm = std::max(widest_mm, row.sd);
    }
    EXPECT_GT(widest_mm, 0.5);
  }
}

// The smaller fit that is proposed has what it needs, and proposes nothing more.
TEST(Plausibility, TooFewPosesProposeAFitThatTheyDetermine) {
  const session::Session few = session_at(6);  // 12 coordinates for ten parameters
  const CalibrationResult all = calibrate(few, quick());
  const auto smaller = std::ranges::find(*all.warnings, "smaller_fit", &Warning::code);
  ASSERT_NE(smaller, all.warnings->end());
  CalibrationRequest request = quick();
  std::string word;
  for (std::istringstream words(std::get<std::string>(smaller->parts.at("fix")));
       std::getline(words, word, ',');) {
    request.fix.push_back(word);
  }
  EXPECT_FALSE(request.fix.empty());
  EXPECT_EQ(
      static_cast<double>(request.fix.size()) + std::get<double>(smaller->parts.at("fitted")),
      10.0);
  const CalibrationResult held = calibrate(few, request);
  EXPECT_THAT(codes_of(*held.warnings), Not(::testing::Contains("too_few_poses")));
  EXPECT_THAT(held.identification.held, IsEmpty());
}

// Every method of a comparison says what these poses leave open, and how far.
TEST(Plausibility, AComparisonOfTooFewPosesSaysWhatWasHeld) {
  CompareRequest request;
  request.methods = {"before", "lm", "lse", "ekf"};
  request.threads = 1;
  const auto widest_of = [&](const session::Session& session, bool held) {
    const ComparisonResult result = compare(session, request);
    for (const ComparedRow& method : result.methods) {
      if (!method.robot) continue;
      SCOPED_TRACE(method.id);
      double widest_mm = 0.0;
      int holds = 0;
      for (const auto& [name, parameter] : method.robot->parameters) {
        holds += parameter.partly_held.value();
        if (name.front() == 'l') widest_mm = std::max(widest_mm, parameter.sd);
      }
      EXPECT_EQ(holds > 0, held);
      EXPECT_EQ(widest_mm > 0.5, held) << widest_mm;
    }
  };
  widest_of(session_at(4), true);
  widest_of(right_session(), false);
}

// A version that did not look left no warnings: its result is called nothing before somebody
// has looked, and is then held against the data as that version took them.
TEST(Plausibility, AResultOfAnEarlyVersionIsJudgedWhereItsSessionIs) {
  const auto of_an_early_version = [](const session::Session& session) {
    CalibrationResult result = calibrate(session, quick());
    result.warnings.reset();
    return result;
  };
  const session::Session right = right_session();
  CalibrationResult result = of_an_early_version(right);
  EXPECT_EQ(report::verdict_of(result).state, report::CalibrationState::kUnknown);
  EXPECT_EQ(report::verdict_of(result).title, "Not judged");
  EXPECT_FALSE(report::to_json(result).contains("state"));
  const session::Session copied = session_with([](session::Session& each) {
    for (std::size_t i = 0; i < 20; ++i) {
      each.samples.push_back(each.samples[i]);
      each.samples.back().point += 1000;
    }
  });
  judge_stored(result, copied);
  EXPECT_FALSE(result.warnings) << "of another session";
  judge_stored(result, right);
  ASSERT_TRUE(result.warnings);
  EXPECT_THAT(*result.warnings, IsEmpty());
  EXPECT_EQ(report::verdict_of(result).state, report::CalibrationState::kCalibrated);
  EXPECT_EQ(report::to_json(result)["state"], "calibrated");
  // Today the copies are left out; the early version fitted them.
  result = of_an_early_version(copied);
  judge_stored(result, copied);
  EXPECT_THAT(codes_of(*result.warnings), ElementsAre("copied_rows", kMadeUnjudged));
  const report::Verdict said = report::verdict_of(result);
  EXPECT_EQ(said.state, report::CalibrationState::kNotCalibrated);
  EXPECT_THAT(said.headline, HasSubstr("This calibration is of an earlier version"));
}

TEST(Plausibility, ALengthThatNoSuchRobotHasIsNotCalibrated) {
  std::vector<ParameterRow> rows(1);
  const session::Session session = session_with([](session::Session& each) {
    each.rig.robot.nominal[0] += 25.0;  // the rig file says 85 mm where 60 mm are true
  });
  const CalibrationResult result = calibrate(session, quick());
  EXPECT_FALSE(is_clean(*result.warnings));
  EXPECT_EQ(report::verdict_of(result).state, report::CalibrationState::kNotCalibrated);
}

TEST(Plausibility, WhatNoSuchRobotGaveIsNotCalibratedByAnyMethod) {
  // Each pose with the readings of another one, so that no column tells.
  const session::Session session = session_with([](session::Session& each) {
    const std::vector<session::Sample> right = each.samples;
    for (std::size_t i = 0; i < right.size(); ++i) {
      each.samples[i].channels = right[(7 * i + 3) % right.size()].channels;
      each.samples[i].target_mm.reset();
    }
  });
  for (const char* const method : {"lm", "ekf_dqpso"}) {
    CalibrationRequest request = quick();
    request.method = method;
    const CalibrationResult result = calibrate(session, request);
    EXPECT_THAT(codes_of(*result.warnings), Contains("fits_nowhere")) << method;
    EXPECT_TRUE(forbids_commands(*result.warnings)) << method;
  }
  const ComparisonResult compared = compare(session, {.methods = {"tikhonov"}});
  EXPECT_THAT(codes_of(*compared.warnings), Contains("fits_nowhere"));
}

TEST(Plausibility, WhatAUserHoldsIsNoFaultOfTheData) {
  const session::Session session = session_with([](session::Session& each) {
    const auto zero = each.rig.robot.model->find_parameter("dtheta1");
    each.rig.robot.nominal[*zero] += 5.0 * geometry::kRadPerDeg;
  });
  CalibrationRequest one_link = quick();
  one_link.free = {"l11"};
  for (const CalibrationRequest& request : {one_link, quick()}) {
    const CalibrationResult result = calibrate(session, request);
    EXPECT_THAT(codes_of(*result.warnings), Not(Contains("fits_nowhere")));
  }
}

TEST(Plausibility, AJointWhoseZeroIsFarFromTheRigFilesIsTold) {
  const session::Session session = session_with([](session::Session& each) {
    const auto zero = each.rig.robot.model->find_parameter("dtheta1");
    ASSERT_TRUE(zero.has_value());
    each.rig.robot.nominal[*zero] += 20.0 * geometry::kRadPerDeg;
  });
  const CalibrationResult result = calibrate(session, quick());
  EXPECT_THAT(codes_of(*result.warnings), Contains("far_angle"));
  EXPECT_TRUE(is_clean(*result.warnings)) << report::warnings_text(*result.warnings);
}

TEST(Plausibility, NothingFreeIsRefusedInWords) {
  CalibrationRequest request = quick();
  request.fix = {"l11", "l12", "l21", "l22", "d", "x0", "y0", "alpha", "dtheta1", "dtheta2"};
  EXPECT_THROW(static_cast<void>(calibrate(right_session(), request)), StudyError);
  CompareRequest comparison;
  comparison.methods = {"lm"};
  comparison.fix = request.fix;
  for (const char* space : {"positions", "dials"}) {
    comparison.space = space;
    EXPECT_THROW(static_cast<void>(compare(right_session(), comparison)), StudyError);
  }
}

TEST(Plausibility, NumbersOfThreadsThatNoMachineHasDoNotMatter) {
  CalibrationRequest request = quick();
  request.method = "ekf_dqpso";
  request.particles = 10;
  request.qpso1_iterations = 3;
  request.qpso2_iterations = 3;
  const CalibrationResult one = calibrate(right_session(), request);
  request.threads = 100000;
  const CalibrationResult many = calibrate(right_session(), request);
  EXPECT_EQ(one.identified(), many.identified());
}

TEST(Plausibility, WarningsComeBackFromTheDocument) {
  const session::Session session =
      session_with([](session::Session& each) { each.samples[5].temperature_c = 2137.0; });
  const CalibrationResult result = calibrate(session, quick());
  const Json document = Json::parse(report::to_json(result).dump());
  ASSERT_EQ(document["warnings"].size(), 1U);
  EXPECT_EQ(document["warnings"][0]["code"], "wrong_temperature");
  EXPECT_THAT(document["warnings"][0]["message"].get<std::string>(), HasSubstr("2137"));
  EXPECT_THAT(document["warnings"][0]["where"].get<std::string>(), HasSubstr("line 7"));
  EXPECT_EQ(document["state"], "calibrated");
  const CalibrationResult again = report::calibration_from_json(document);
  EXPECT_EQ(report::to_json(again), document);
}

TEST(Plausibility, TheReportTellsItFirst) {
  const session::Session session = session_with([](session::Session& each) {
    each.rig.robot.working_mode = geometry::WorkingMode(-1, -1);
  });
  const CalibrationResult result = calibrate(session, quick());
  const report::ReportData data = report::report_data(result, session, "somebody");
  ASSERT_EQ(data.warnings.size(), 1U);
  EXPECT_EQ(report::verdict(data).state, report::CalibrationState::kNotCalibrated);
  EXPECT_THAT(report::headline_text(result), HasSubstr("working mode"));
}

TEST(Plausibility, DataThatContradictThemselvesCommandNothing) {
  const session::Session session = session_with([](session::Session& each) {
    each.rig.cuboid.reference_pose_mm = {0.0, 60.0};
  });
  EXPECT_THROW(report::check_may_command(plausible(session).warnings), StudyError);
  EXPECT_NO_THROW(report::check_may_command(plausible(right_session()).warnings));
}

TEST(Plausibility, ThreeDialsWithoutPositionsAreCompared) {
  const session::Session session = session_with([](session::Session& each) {
    each.rig.dials.resize(3);
    for (session::Sample& sample : each.samples) sample.channels.resize(3);
  });
  CompareRequest request;
  request.space = "dials";
  request.threads = 1;
  request.methods = {"before", "lm"};
  const ComparisonResult result = compare(session, request);
  ASSERT_EQ(result.methods.size(), 2U);
  EXPECT_FALSE(result.methods[1].g1);
  ASSERT_TRUE(result.methods[1].robot);
  EXPECT_GT(result.assessment.readings, 100);
  request.methods = {"lm+gp"};
  EXPECT_THROW(static_cast<void>(compare(session, request)), StudyError);
}

TEST(Plausibility, AResultKnowsItsData) {
  const CalibrationResult result = calibrate(right_session(), quick());
  const session::Session other =
      session_with([](session::Session& each) { each.samples.pop_back(); });
  EXPECT_NO_THROW(check_same_data(result.inputs, right_session(), "calibration", ""));
  EXPECT_THROW(check_same_data(result.inputs, other, "calibration", ""), StudyError);
}

}  // namespace
}  // namespace sixdial::studies
