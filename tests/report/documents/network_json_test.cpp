// ANFIS saved, loaded and shown.
#include "report/documents/network_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "calibration/random.h"
#include "report/documents/calibration_json.h"
#include "report/report_run.h"
#include "report/sections/sections_of_studies.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "tests/support/paths.h"

namespace sixdial::report {
namespace {

using calibration::AnfisModel;
using calibration::MembershipKind;

const std::filesystem::path kBundle =
    std::filesystem::path(test_paths::test_data()) / "session_00";

calibration::AnfisReport read_network(const Json& json) {
  return read<calibration::AnfisReport>(json, "network");
}

struct Lesson {
  Eigen::MatrixXd inputs;
  Eigen::VectorXd targets;
};

/// A smooth surface of a few hundredths of a millimetre with noise, over angles.
Lesson lesson(int inputs, int samples, std::uint64_t seed) {
  calibration::RandomSequence random(seed);
  Lesson result{Eigen::MatrixXd(samples, inputs), Eigen::VectorXd(samples)};
  for (int i = 0; i < samples; ++i) {
    double sum = 0.0;
    for (int k = 0; k < inputs; ++k) {
      result.inputs(i, k) = random.uniform(0.4 + k, 1.9 + k);
      sum += std::sin((2 + k) * result.inputs(i, k));
    }
    result.targets[i] = 0.03 * sum + 0.002 * random.normal();
  }
  return result;
}

TEST(NetworkJson, WhatIsLoadedAnswersAsWhatWasSavedBitForBit) {
  int tried = 0;
  for (const auto kind : {MembershipKind::kGaussian, MembershipKind::kBell}) {
    for (const int inputs : {1, 2, 3}) {
      for (const bool chosen : {false, true}) {
        const Lesson taught = lesson(inputs, 80, static_cast<std::uint64_t>(10 + inputs));
        calibration::AnfisLearning learning;
        learning.anfis.kind = kind;
        learning.anfis.functions = 4;
        learning.anfis.epochs = 20;
        learning.cross_validate = chosen;
        const auto report = calibration::learn_anfis(taught.inputs, taught.targets, learning);
        ASSERT_GT(report.model.functions, 0);
        const std::string text = write(report).dump();
        const AnfisModel loaded = read_network(Json::parse(text)).model;
        EXPECT_EQ(loaded.effective_parameters, report.model.effective_parameters);
        EXPECT_EQ(loaded.ridge, report.model.ridge);
        EXPECT_EQ(loaded.rules(), report.model.rules());
        calibration::RandomSequence random(99);
        for (int i = 0; i < 200; ++i) {
          Eigen::VectorXd at(inputs);
          for (double& each : at) each = random.uniform(-1.0, 5.0);  // beyond the box too
          ASSERT_EQ(loaded.predict(at), report.model.predict(at));
          ++tried;
        }
        // saved again it is the same text
        auto again = report;
        again.model = loaded;
        EXPECT_EQ(write(again).dump(), text);
      }
    }
  }
  EXPECT_EQ(tried, 2400);
}

TEST(NetworkJson, NoNetworkStaysNoNetwork) {
  calibration::AnfisReport report;
  report.model = calibration::zero_anfis(2);
  const AnfisModel loaded = read_network(Json::parse(write(report).dump())).model;
  EXPECT_EQ(loaded.functions, 0);
  EXPECT_EQ(loaded.inputs, 2);
  EXPECT_EQ(loaded.predict(Eigen::Vector2d(1.0, 2.0)), 0.0);
}

TEST(NetworkJson, ADamagedNetworkIsRefusedByName) {
  const Lesson taught = lesson(2, 60, 3);
  calibration::AnfisLearning learning;
  learning.anfis.functions = 3;
  learning.anfis.epochs = 5;
  learning.cross_validate = false;
  const Json whole = write(calibration::learn_anfis(taught.inputs, taught.targets, learning));
  const auto trouble = [](const Json& json) -> std::string {
    try {
      static_cast<void>(read_network(json));
    } catch (const studies::StudyError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(trouble(whole), "");
  for (const char* key :
       {"kind", "functions", "input_mean", "input_scale", "centre", "width", "consequents",
        "box_low", "box_high", "output_low_mm", "output_high_mm"}) {
    Json without = whole;
    without.erase(key);
    EXPECT_THAT(trouble(without), ::testing::HasSubstr(key));
  }
  Json damaged = whole;
  damaged["consequents"].erase(0);
  EXPECT_THAT(trouble(damaged), ::testing::HasSubstr("consequents"));
  damaged = whole;
  damaged["centre"][1][0] = "wide";
  EXPECT_THAT(trouble(damaged), ::testing::HasSubstr("centre"));
  damaged = whole;
  damaged["functions"] = 5000;
  EXPECT_THAT(trouble(damaged), ::testing::HasSubstr("functions"));
}

const report::Table* table_of(const report::Section& section, const std::string& id) {
  for (const report::Block& block : section.blocks) {
    const auto* table = std::get_if<report::Table>(&block);
    if (table != nullptr && table->id == id) return table;
  }
  return nullptr;
}

const report::Figure* figure_of(const report::Section& section) {
  for (const report::Block& block : section.blocks) {
    if (const auto* figure = std::get_if<report::Figure>(&block)) return figure;
  }
  return nullptr;
}

double value_of(const report::Cell& cell) { return std::get<report::Number>(cell).value; }

TEST(NetworkJson, TheReportShowsMembershipsEffectiveParametersAndTheSizesOffered) {
  const Lesson taught = lesson(2, 100, 5);
  const auto learned = calibration::learn_anfis(taught.inputs, taught.targets, {});
  ASSERT_GT(learned.model.functions, 0);
  const auto sections = anfis_sections({learned, learned});
  ASSERT_EQ(sections.size(), 1U);

  const report::Table* networks = table_of(sections[0], "anfis");
  ASSERT_NE(networks, nullptr);
  ASSERT_EQ(networks->rows.size(), 2U);
  const double samples = value_of(networks->rows[0][4]);
  const double effective = value_of(networks->rows[0][5]);
  EXPECT_EQ(samples, 100);
  EXPECT_EQ(value_of(networks->rows[0][3]), 3 * value_of(networks->rows[0][2]));
  EXPECT_DOUBLE_EQ(effective, learned.model.effective_parameters);
  EXPECT_GT(effective, 1.0);
  EXPECT_LT(effective, samples);

  const report::Table* sizes = table_of(sections[0], "anfis_sizes");
  ASSERT_NE(sizes, nullptr);
  // none, 1, 2, 3, 4, 6 functions and the paper's setting, for x and y
  ASSERT_EQ(sizes->rows.size(), 14U);
  int chosen = 0;
  double best = HUGE_VAL;
  double chosen_rmse = 0.0;
  for (std::size_t i = 0; i < 7; ++i) {
    best = std::min(best, value_of(sizes->rows[i][4]));
    if (std::get<std::string>(sizes->rows[i][5]) != "chosen") continue;
    ++chosen;
    chosen_rmse = value_of(sizes->rows[i][4]);
  }
  EXPECT_EQ(chosen, 1);
  EXPECT_EQ(chosen_rmse, best);
  EXPECT_EQ(std::get<std::string>(sizes->rows[6][5]), "the paper's setting");
  EXPECT_GT(value_of(sizes->rows[6][3]), 40.0);  // 108 consequents, hardly any ridge

  const report::Figure* plot = figure_of(sections[0]);
  ASSERT_NE(plot, nullptr);
  EXPECT_EQ(plot->chart.panels.size(), 4U);
  for (const report::Panel& panel : plot->chart.panels) {
    EXPECT_EQ(std::ssize(panel.series), learned.model.functions);
    for (const report::Series& series : panel.series) {
      EXPECT_EQ(series.x.size(), series.y.size());
      for (const double mu : series.y) {
        EXPECT_GE(mu, 0.0);
        EXPECT_LE(mu, 1.0);
      }
    }
  }
  EXPECT_EQ(std::ssize(plot->table.rows), 4 * learned.model.functions);
}

TEST(NetworkJson, ACalibrationsNetworksGoThroughItsDocumentToCompensationAndReport) {
  const session::Session session = session::read_bundle(kBundle);
  studies::CalibrationRequest request;
  request.profile = calibration::Profile::kPaper;
  request.particles = 20;
  request.qpso1_iterations = 5;
  request.qpso2_iterations = 30;
  request.anfis_epochs = 10;
  const studies::CalibrationResult result = studies::calibrate(session, request);
  const Json document = to_json(result);
  EXPECT_EQ(document["anfis"]["x"]["consequents_count"], 108);
  EXPECT_EQ(document["anfis"]["x"]["samples"], 80);
  EXPECT_LT(document["anfis"]["x"]["effective_parameters"].get<double>(), 80.0);
  const auto now =
      studies::compensation_model(result, session.rig, studies::CompensateBy::kFull);
  const auto later = studies::compensation_model(
      calibration_from_json(Json::parse(document.dump())), session.rig,
      studies::CompensateBy::kFull);
  for (const session::Sample& sample : session.samples) {
    EXPECT_EQ(now.correction(sample.q), later.correction(sample.q));
  }
  const report::ReportData data = report::report_data(result, session, "somebody");
  const auto section =
      std::ranges::find(data.sections, std::string("anfis"), &report::Section::id);
  ASSERT_NE(section, data.sections.end());
  EXPECT_NE(figure_of(*section), nullptr);
  EXPECT_EQ(table_of(*section, "anfis_sizes"), nullptr);  // the paper's profile offers no other
}

}  // namespace
}  // namespace sixdial::report
