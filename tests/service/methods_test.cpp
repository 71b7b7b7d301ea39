// The method table: every example is run, every row says what it must, the printed protocol is
// the committed one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "service/socket/request.h"
#include "session/bundle.h"
#include "session/rig_file.h"
#include "tests/support/job_answers.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::service {
namespace {

using testing::error_code_of;
using testing::finished;
using testing::LineClient;
using testing::RunningService;

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at)) {
    text.replace(at, what.size(), with);
    at += with.size();
  }
  return text;
}

Json example_of(const std::string& method, const RunningService& running) {
  return Json::parse(replaced(
      std::string(find_method(method).example), "/srv/rig", running.directory().string()));
}

/// The answer, however long it takes: some methods compute before they answer, and a client of
/// these tests gives up after kPatience. A connection that has ended is told at once.
Json patient_answer(LineClient& client, const std::string& method, const Json& params) {
  constexpr int kTimes = 20;
  client.send(
      Json{{"jsonrpc", "2.0"}, {"id", method}, {"method", method}, {"params", params}}.dump() +
      "\n");
  for (int i = 0; i < kTimes;) {
    const auto line = client.read_line();
    if (!line) {
      ++i;
      continue;
    }
    Json reply = Json::parse(*line);
    if (reply.value("id", Json{}) == method) return reply;
  }
  throw std::runtime_error(method + ": no answer");
}

/// The world that the examples speak of: session `demo`, and a bundle in /srv/rig/bundle.
void prepare(RunningService& running) {
  const std::filesystem::path bundle =
      std::filesystem::path(test_paths::test_data()) / "session_00";
  std::filesystem::create_directories(running.directory() / "bundle");
  for (const char* file : {"session.csv", "rig.toml"}) {
    std::filesystem::copy_file(bundle / file, running.directory() / "bundle" / file);
  }
  LineClient client = running.client();
  ASSERT_EQ(
      error_code_of(
          client.call("session.import", {{"path", bundle.string()}, {"name", "demo"}})),
      "");
}

TEST(Methods, EveryExampleIsAnsweredAsItsRowSays) {
  RunningService running;
  prepare(running);
  LineClient client = running.client();
  std::set<std::string> tried;
  const auto run = [&](const std::string& method) {
    tried.insert(method);
    return patient_answer(client, method, example_of(method, running));
  };
  const auto run_well = [&](const std::string& method) {
    Json reply = run(method);
    EXPECT_TRUE(reply.contains("result")) << method << ": " << reply;
    return reply.value("result", Json::object());
  };

  EXPECT_EQ(run_well("hello")["service"], "sixdiald");
  EXPECT_EQ(run_well("rpc.discover")["methods"].size(), 1U);
  EXPECT_EQ(run_well("events.subscribe")["lost"], 0);
  EXPECT_EQ(run_well("session.create")["samples"], 0);
  EXPECT_EQ(run_well("session.import")["samples"], 150);
  EXPECT_EQ(run_well("session.list")["total"], 3);
  EXPECT_EQ(run_well("session.show")["page"].size(), 5U);
  EXPECT_EQ(run_well("session.choices")["choices"]["start"], "there is no plan yet");
  EXPECT_EQ(run_well("session.plan")["total"], 0);  // an imported session has none
  EXPECT_EQ(run_well("session.export")["samples"], 150);
  EXPECT_EQ(run_well("plan.grid")["points"], 100);
  EXPECT_EQ(run_well("plan.random")["points"], 50);
  EXPECT_EQ(run_well("plan.next")["points"], 5);
  EXPECT_EQ(run_well("plan.separate")["points"], 8);

  const Json calibration = run_well("calibrate.start");
  EXPECT_EQ(calibration["job"], 1);
  EXPECT_EQ(finished(client, calibration)["state"], "done");  // the example waits a while only
  EXPECT_EQ(run_well("job.wait")["state"], "done");
  EXPECT_EQ(run_well("job.status")["result"], 1);
  EXPECT_EQ(run_well("job.cancel")["cancelling"], false);
  EXPECT_EQ(run_well("job.list")["jobs"].size(), 1U);
  EXPECT_EQ(run_well("result.list")["results"].size(), 1U);
  EXPECT_GT(run_well("result.get")["bytes"], 10'000);
  EXPECT_EQ(run_well("result.recommend")["schema"], "sixdial.recommendation");
  EXPECT_GT(run_well("report.write")["files"].size(), 5U);
  EXPECT_TRUE(std::filesystem::exists(running.directory() / "report" / "report.html"));

  EXPECT_LT(run_well("compensate.target")["closure_mm"], 1e-9);
  EXPECT_EQ(run_well("compensate.plan")["points"], 1);
  EXPECT_EQ(run_well("model.export")["format"], "python");
  EXPECT_EQ(run_well("compare.start")["kind"], "comparison");
  EXPECT_EQ(error_code_of(run("diagnose.report")), "not_found");
  const Json diagnosis = run_well("diagnose.start");
  EXPECT_EQ(diagnosis["kind"], "diagnosis");
  EXPECT_EQ(finished(client, diagnosis)["state"], "done");
  EXPECT_TRUE(run_well("diagnose.report")["path"].is_string());
  EXPECT_EQ(run_well("session.undo")["samples"], 149);

  // Without a plan and without a rig these answer with the error that says so.
  EXPECT_EQ(run_well("collect.status")["state"], "idle");
  EXPECT_EQ(run_well("collect.wait")["state"], "idle");
  EXPECT_EQ(error_code_of(run("collect.start")), "bad_data");
  EXPECT_EQ(error_code_of(run("validate.start")), "bad_data");
  for (const char* verb : {"pause", "resume", "skip", "retake", "accept", "moved", "stop"}) {
    EXPECT_EQ(error_code_of(run(std::string("collect.") + verb)), "wrong_state") << verb;
  }
  EXPECT_EQ(error_code_of(run("robot.stop")), "wrong_state");
  EXPECT_EQ(error_code_of(run("dials.watch")), "bad_data");
  EXPECT_EQ(error_code_of(run("dials.check")), "wrong_state");
  EXPECT_EQ(run_well("dials.stop")["watching"], false);
  EXPECT_EQ(run_well("shutdown")["stopping"], true);

  for (const RpcMethod* method : all_methods()) {
    EXPECT_TRUE(tried.contains(std::string(method->name))) << method->name << " was not tried";
  }
}

TEST(Methods, EveryRowHasWordsSchemaAndAnExampleThatFitsIt) {
  int rows = 0;
  for (const RpcMethod* method : all_methods()) {
    ++rows;
    EXPECT_FALSE(method->summary.empty()) << method->name;
    EXPECT_FALSE(method->result.empty()) << method->name;
    EXPECT_NE(method->run == nullptr, method->wait == nullptr) << method->name;
    EXPECT_NO_THROW(check_params(*method, Json::parse(method->example))) << method->name;
    for (const Param& param : method->params) EXPECT_FALSE(param.doc.empty()) << param.name;
    EXPECT_EQ(params_schema(*method)["properties"].size(), method->params.size());
  }
  EXPECT_GT(rows, 20);
}

TEST(Methods, TheWholeTableFitsIntoOneLine) {
  RunningService running;
  LineClient client = running.client();
  client.send(R"({"jsonrpc":"2.0","id":1,"method":"rpc.discover"})"
              "\n");
  const auto line = client.read_line();
  ASSERT_TRUE(line.has_value());
  EXPECT_LT(line->size() + 1, kMaxLineBytes);
  EXPECT_EQ(Json::parse(*line)["result"]["methods"].size(), all_methods().size());
}

TEST(Methods, TheCommittedProtocolIsTheOneOfTheTable) {
  std::ifstream file(std::filesystem::path(test_paths::source_dir()) / "doc" / "protocol.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), protocol_markdown())
      << "print it anew: sixdiald --print-protocol > doc/protocol.md";
}

TEST(Methods, ErrorNumbersAndWordsAreUnique) {
  std::set<int> numbers;
  std::set<std::string_view> codes;
  for (const ErrorKind& kind : error_table()) {
    EXPECT_TRUE(numbers.insert(kind.number).second) << kind.code;
    EXPECT_TRUE(codes.insert(kind.code).second) << kind.code;
    EXPECT_FALSE(kind.hint.empty());
    EXPECT_EQ(&error_kind(kind.key), &kind);
  }
}

TEST(Methods, AWrongBundleIsRefusedWithFileLineAndColumn) {
  RunningService running;
  prepare(running);
  std::ifstream in(running.directory() / "bundle" / "session.csv");
  std::stringstream whole;
  whole << in.rdbuf();
  const auto import_with = [&](const std::string& what, const std::string& with) {
    std::string text = whole.str();
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos);
    text.replace(at, what.size(), with);
    std::ofstream(running.directory() / "bundle" / "session.csv") << text;
    LineClient client = running.client();
    return client.call(
        "session.import",
        {{"path", (running.directory() / "bundle").string()}, {"name", "wrong"}});
  };
  const Json text = import_with("1.411917868", "abc");
  EXPECT_EQ(error_code_of(text), "bad_data");
  EXPECT_EQ(text["error"]["data"]["at"]["line"], 3);
  EXPECT_GT(text["error"]["data"]["at"]["column"], 1);
  EXPECT_THAT(
      text["error"]["data"]["at"]["file"].get<std::string>(),
      ::testing::EndsWith("session.csv"));
  EXPECT_EQ(
      error_code_of(import_with("1.411917868,2.880616311", "3.1,0.0")),
      "bad_data");  // out of reach
  EXPECT_EQ(error_code_of(import_with("1.411917868", "nan")), "bad_data");
  EXPECT_EQ(error_code_of(import_with("theta2_rad", "theta2")), "bad_data");  // missing column
  EXPECT_EQ(error_code_of(import_with("dial_F_mm", "dial_Z_mm")), "bad_data");
  EXPECT_EQ(error_code_of(import_with("\nG1,1,0,", "\nG1,0,0,")), "bad_data");  // twice
  LineClient client = running.client();
  EXPECT_EQ(error_code_of(client.call("session.show", {{"session", "wrong"}})), "not_found");
  EXPECT_EQ(import_with("G1,0,0,", "G1,0,0,")["result"]["samples"], 150);  // as it was
  EXPECT_EQ(error_code_of(import_with("G1,0,0,", "G1,0,0,")), "already_exists");
}

TEST(Methods, PathsMustBeAbsoluteAndNamesHarmless) {
  RunningService running;
  prepare(running);
  LineClient client = running.client();
  EXPECT_EQ(
      error_code_of(client.call("session.import", {{"path", "bundle"}})), "invalid_params");
  EXPECT_EQ(
      error_code_of(client.call("session.export", {{"session", "demo"}, {"path", "x"}})),
      "invalid_params");
  const std::string rig = session::write_rig(geometry::default_rig());
  for (const char* name : {"", "../up", "a b", ".hidden", "x/y"}) {
    EXPECT_EQ(
        error_code_of(client.call("session.create", {{"name", name}, {"rig_toml", rig}})),
        "invalid_params")
        << name;
  }
}

}  // namespace
}  // namespace sixdial::service
