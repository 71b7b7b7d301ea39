// What speaks against a session and stands in the text of its files: blanks that nobody sees,
// certificates; and what a study says where nothing plausible is left.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "db/store.h"
#include "report/documents/calibration_json.h"
#include "report/documents/warnings_document.h"
#include "report/headline.h"
#include "report/words/warning_words.h"
#include "service/recommended_model.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/diagnose.h"
#include "studies/error.h"
#include "studies/plausibility.h"
#include "studies/stored_warnings.h"
#include "tests/studies/plausible_session.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Plausibility, ABlankAroundTheNameOfASetIsTold) {
  const std::string folder = test_paths::test_data() + "/session_00/";
  std::string csv = session::read_file(folder + "session.csv");
  const std::string rig = session::read_file(folder + "rig.toml");
  const auto put = [&](std::string_view before, std::string_view after) {
    const std::size_t at = csv.find(before);
    ASSERT_NE(at, std::string::npos);
    csv.replace(at, before.size(), after);
  };
  put("\nG1,3,", "\nG1 ,3,");
  put("\nG1,5,", "\n\"\u00A0G1\",5,");
  put("\nG1,7,0,", "\nG1,7, 0,");  // a blank around a number is nothing
  const session::Session session = session::parse_session(csv, "session.csv", rig, "rig.toml");
  const PlausibleSession judged = plausible(session);
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "set_with_blanks");
  EXPECT_EQ(told.severity, Severity::kNote);
  EXPECT_EQ(told.where.rows, 2);
  EXPECT_THAT(
      report::warning_line(told),
      HasSubstr("it is read as \"G1\". (session.csv, lines 5 and 7, column set)"));
  EXPECT_EQ(counted(judged, "G1"), 100U);
}

TEST(Plausibility, ACertificateThatHadRunOutIsTold) {
  const std::string folder = test_paths::test_data() + "/session_00/";
  const std::string csv = session::read_file(folder + "session.csv");  // of 2026-03-02
  const auto told_with = [&](const std::string& cuboid, const std::string& dial_b) {
    std::string rig = session::read_file(folder + "rig.toml");
    rig.insert(rig.find('\n', rig.find("[cuboid]")) + 1, cuboid);
    rig.insert(rig.find('\n', rig.find("id = \"B\"")) + 1, dial_b);
    return plausible(session::parse_session(csv, "session.csv", rig, "rig.toml")).warnings;
  };
  EXPECT_THAT(told_with("due = 2026-03-02\n", "due = \"2027-01-15\"\n"), IsEmpty());
  EXPECT_THAT(told_with("certificate = \"K 1\"\n", ""), IsEmpty());  // nobody says until when
  const auto warnings =
      told_with("due = 2026-03-01\n", "serial = \"12\"\ndue = \"2025-12-31\"\n");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].code, "certificate_expired");
  EXPECT_TRUE(is_clean(warnings));  // it is told, and the calibration stands
  EXPECT_THAT(
      report::warning_line(warnings[0]),
      HasSubstr(
          "certificate of cuboid, dial B had run out (due 2025-12-31 at the earliest) when "
          "this was measured on 2026-03-02"));
}

// Stored by a version that did not look: the service commands nothing by it either.
TEST(Plausibility, AnEarlyResultInAStoreIsJudgedByItsSession) {
  const std::string folder = test_paths::test_data() + "/session_00/";
  const std::string csv = session::read_file(folder + "session.csv");
  const std::string right = session::read_file(folder + "rig.toml");
  std::string wrong = right;
  const std::string_view pose = "reference_pose_mm = [28.0, 48.0]";
  ASSERT_NE(wrong.find(pose), std::string::npos);
  wrong.replace(wrong.find(pose), pose.size(), "reference_pose_mm = [0.0, 60.0]");
  db::Store store = db::Store::open(":memory:");
  const auto record_of = [&](const std::string& rig, const std::string& name) {
    session::Session session = session::parse_session(csv, "session.csv", rig, "rig.toml");
    session.name = name;
    const db::SessionId id = store.import_session(session);
    CalibrationResult result = calibrate(store.load_session(id), quick());
    result.warnings.reset();
    const std::string json = report::to_json(result).dump();
    return store.load_result(
        store.save_result({.session = id, .kind = "calibration", .json = json}));
  };
  const auto judged = [&](const db::ResultRecord& record) {
    return service::warnings_of(store, record, Json::parse(record.json));
  };
  EXPECT_THAT(judged(record_of(right, "right")), IsEmpty());
  const db::ResultRecord of_wrong = record_of(wrong, "wrong");
  EXPECT_THAT(codes_of(judged(of_wrong)), ElementsAre("reference_pose", kMadeUnjudged));
  EXPECT_THROW(report::check_may_command(judged(of_wrong)), StudyError);
  const auto model = service::recommended_model(store, of_wrong);
  EXPECT_EQ(
      report::verdict_of(model.calibration).state, report::CalibrationState::kNotCalibrated);
}

TEST(Plausibility, TheSignOfAllDialsIsOneMessageAndComesBeforeMorePoints) {
  const session::Session session = session_with([](session::Session& each) {
    for (session::Sample& sample : each.samples) {
      for (session::ChannelValue& channel : sample.channels) {
        if (channel.value) *channel.value *= -1.0;
      }
    }
  });
  const Warning told = only_warning(plausible(session));
  EXPECT_EQ(told.code, "sign_of_dial");
  EXPECT_THAT(report::warning_text(told), HasSubstr("Readings of all dials are below zero"));
  const auto hint_of = [&](const auto& study) -> std::string {
    try {
      static_cast<void>(study());
    } catch (const StudyError& error) {
      return error.hint();
    }
    return "not refused";
  };
  EXPECT_THAT(
      hint_of([&] { return calibrate(session, quick()); }),
      HasSubstr("are not used, as they are not plausible: settle first"));
  EXPECT_THAT(
      hint_of([&] { return compare(session, {.methods = {"lm"}}); }),
      HasSubstr("settle first"));
  EXPECT_THAT(hint_of([&] { return diagnose(session, {}); }), HasSubstr("settle first"));
}

}  // namespace
}  // namespace sixdial::studies
