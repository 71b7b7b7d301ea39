// sixdial doctor and rig scan: each trouble is a line with what to do, and an exit code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "cli/health.h"
#include "db/store.h"
#include "mock_devices/mock_rig.h"
#include "session/rig_file.h"
#include "tests/support/command_line.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;

using ::testing::HasSubstr;
using testing::RunningService;
using testing::TempDirectory;

Json line_of(const Json& document, const std::string& check) {
  for (const Json& row : document["checks"]) {
    if (row["check"] == check) return row;
  }
  ADD_FAILURE() << "no line on " << check;
  return Json::object();
}

TEST(Doctor, FindsAllWellWhereItIs) {
  RunningService running;
  const Outcome outcome = sixdial(
      {"doctor", "--json", "--socket", running.socket_path().string(), "--db",
       (running.directory() / "sixdial.db").string(), "--by-id",
       (running.directory() / "none").string()});
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  const Json json = outcome.json();
  EXPECT_EQ(json["schema"], "sixdial.doctor");
  EXPECT_EQ(json["healthy"], true);
  for (const char* check : {"socket", "database", "disk", "known answer"}) {
    EXPECT_EQ(line_of(json, check)["state"], "ok") << line_of(json, check);
  }
}

TEST(Doctor, WithoutAServiceSaysHowToStartOneAndIsThree) {
  TempDirectory directory;
  const Outcome outcome = sixdial(
      {"doctor", "--socket", (directory.path() / "s").string(), "--db",
       (directory.path() / "a.db").string()});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.out, HasSubstr("failed   socket"));
  EXPECT_THAT(outcome.out, HasSubstr("-> start it: sixdiald"));
  EXPECT_THAT(outcome.out, HasSubstr("known answer"));
}

TEST(Doctor, TellsAStaleSocketADamagedAndAForeignDatabase) {
  TempDirectory directory;
  const auto path = directory.path() / "s";
  {  // as kill -9 leaves it
    boost::asio::io_context loop;
    boost::asio::local::stream_protocol::acceptor dead(
        loop, boost::asio::local::stream_protocol::endpoint(path.string()));
  }
  const Check stale = check_socket(path);
  EXPECT_EQ(stale.health, Health::kFailed);
  EXPECT_THAT(stale.fix, HasSubstr("start it again"));

  const auto foreign = directory.path() / "letter.db";
  std::ofstream(foreign) << "this is a letter and no database, and is long enough to see that";
  const Check letter = check_database(foreign);
  EXPECT_EQ(letter.health, Health::kFailed);
  EXPECT_FALSE(letter.fix.empty());

  const auto damaged = directory.path() / "damaged.db";
  {
    db::Store store = db::Store::open(damaged.string());
    const auto rig = session::write_rig(geometry::default_rig());
    for (int i = 0; i < 20; ++i) {
      (void)store.create_session("s" + std::to_string(i), rig);
    }
    store.checkpoint();
  }
  {
    std::fstream raw(damaged, std::ios::in | std::ios::out | std::ios::binary);
    raw.seekp(4096);
    const std::string junk(8 * 4096, '\x5A');
    raw.write(junk.data(), static_cast<std::streamsize>(junk.size()));
  }
  const Check torn = check_database(damaged);
  EXPECT_EQ(torn.health, Health::kFailed) << torn.what;
  EXPECT_THAT(torn.fix, HasSubstr("keep the file"));

  EXPECT_EQ(check_database(directory.path() / "new.db").health, Health::kOk);
  EXPECT_EQ(check_disk(directory.path() / "new.db").health, Health::kOk)
      << check_disk(directory.path() / "new.db").what;
}

TEST(Doctor, SolvesAKnownAnswer) {
  const Check check = check_known_answer();
  EXPECT_EQ(check.health, Health::kOk) << check.what;
  EXPECT_THAT(check.what, HasSubstr("25 poses"));
}

class RigScanCommand : public ::testing::Test {
 protected:
  RigScanCommand() {
    mock_devices::MockRigOptions options;
    options.world.robot.parameters = geometry::table_2_robot();
    mock_ = std::make_unique<mock_devices::MockRig>(options);
    mock_->start();
  }
  std::string rig_file(const geometry::Rig& rig) {
    const std::string path = (directory_.path() / "rig.toml").string();
    std::ofstream(path) << session::write_rig(rig);
    return path;
  }
  TempDirectory directory_;
  std::unique_ptr<mock_devices::MockRig> mock_;
};

TEST_F(RigScanCommand, ShowsLiveValuesOfAGoodRigAndIsZero) {
  const std::string file = rig_file(mock_->connected_rig("modbus-tcp"));
  const std::string none = (directory_.path() / "none").string();
  const Outcome outcome = sixdial({"rig", "scan", "--rig", file, "--by-id", none, "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  const Json json = outcome.json();
  EXPECT_EQ(json["schema"], "sixdial.rig.scan");
  EXPECT_EQ(json["rig"]["dials"].size(), 6U);
  EXPECT_TRUE(json["rig"]["dials"][0]["value_mm"].is_number());
  EXPECT_EQ(json["rig"]["robot"]["theta_rad"].size(), 2U);
  bool box = false;
  for (const Json& place : json["found"]) box = box || place["dials"].size() == 6;
  EXPECT_TRUE(box) << "the gauge box that the rig file names was asked, too";
  const Outcome text = sixdial({"rig", "scan", "--rig", file, "--no-search"});
  EXPECT_THAT(text.out, HasSubstr("dial A: "));
  EXPECT_THAT(text.out, HasSubstr(" mm  modbus-tcp://"));
}

TEST_F(RigScanCommand, ADialThatDoesNotAnswerIsFourWithWhatToDo) {
  geometry::Rig rig = mock_->connected_rig("modbus-tcp");
  rig.dials[3].connection = "serial:/dev/serial/by-id/usb-none?dialect=sylvac";
  const std::string file = rig_file(rig);
  const Outcome outcome = sixdial({"rig", "scan", "--rig", file, "--no-search"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.out, HasSubstr("failed   dial D: disconnected"));
  EXPECT_THAT(outcome.out, HasSubstr("-> plug the adapter"));
  EXPECT_EQ(sixdial({"rig", "scan", "--rig", "/nowhere/rig.toml"}).code, 5);
}

}  // namespace
}  // namespace sixdial::cli
