// What follows from a dial's row: example rig files, the table of doc/devices.md, rows made at
// run time.
#include "acquisition/dial_examples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acquisition/connection.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "tests/support/paths.h"

namespace sixdial::acquisition {
namespace {

using testing::HasSubstr;

TEST(DialExamples, AreTheRigFilesOfTheTree) {
  for (const DialProtocol* protocol : dial_protocols()) {
    if (protocol->example_port.empty()) continue;  // made at run time
    const std::string path =
        test_paths::source_dir() + "/examples/rigs/" + std::string(protocol->name) + ".toml";
    EXPECT_EQ(example_rig(*protocol), session::read_file(path))
        << "make it anew: sixdiald --print-rig " << protocol->name;
  }
}

TEST(DialExamples, AreInTheTableOfTheManual) {
  EXPECT_THAT(
      session::read_file(test_paths::source_dir() + "/doc/devices.md"), HasSubstr(dial_table()))
      << "make it anew: sixdiald --print-dials";
}

std::string request(int) { return "R\r"; }
tl::expected<DialFrame, FaultKind> parse(std::string_view frame, int) noexcept {
  if (frame != "7\r") return tl::unexpected(FaultKind::kBadFrame);
  return DialFrame{.value = 7.0, .unit = Unit::kMillimetre};
}
bool unasked(std::string_view) noexcept { return false; }

TEST(DialRegistry, TakesARowMadeAtRunTime) {
  static std::string name = "made_";
  name += "here";
  static const DialProtocol mine{
      .name = name,
      .line = {},
      .frame_end = "\r",
      .identity_request = "",
      .request = request,
      .parse = parse,
      .unasked = unasked};
  const std::size_t before = dial_protocols().size();
  add_dial_protocol(mine);
  EXPECT_EQ(dial_protocols().size(), before + 1);
  EXPECT_EQ(find_dial_protocol("made_here"), &mine);
  const auto connection = parse_dial_connection("serial:/dev/ttyS9?dialect=made_here");
  ASSERT_TRUE(connection.has_value()) << connection.error();
  EXPECT_EQ(std::get<SerialConnection>(*connection).protocol, &mine);
  EXPECT_THROW(add_dial_protocol(mine), std::invalid_argument) << "the name is taken";
  DialProtocol mute = mine;
  mute.name = "mute";
  mute.request = nullptr;
  EXPECT_THROW(add_dial_protocol(mute), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::acquisition
