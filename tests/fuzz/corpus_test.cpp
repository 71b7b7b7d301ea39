// The fuzzers' kept corpus, and seeded mutations of it, in the ordinary suite: what libFuzzer
// once reached stays reached, with any compiler.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "acquisition/connection.h"
#include "acquisition/dial_protocol.h"
#include "acquisition/modbus_frame.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/exec_command.h"
#include "acquisition/robots/gcode/dialect.h"
#include "acquisition/robots/klipper/message.h"
#include "acquisition/robots/linuxcnc/lines.h"
#include "geometry/robots/serial.h"
#include "service/socket/request.h"
#include "session/bundle.h"
#include "session/import_table.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "tests/support/figure.h"
#include "tests/support/paths.h"

// Each fuzz_*.cpp under its own name (CMakeLists.txt).
extern "C" {
int fuzz_dials(const std::uint8_t* data, std::size_t size);
int fuzz_modbus_reply(const std::uint8_t* data, std::size_t size);
int fuzz_connection(const std::uint8_t* data, std::size_t size);
int fuzz_request(const std::uint8_t* data, std::size_t size);
int session_csv_fuzz(const std::uint8_t* data, std::size_t size);
int session_rig_fuzz(const std::uint8_t* data, std::size_t size);
int import_fuzz(const std::uint8_t* data, std::size_t size);
int urdf_fuzz(const std::uint8_t* data, std::size_t size);
int fuzz_robot_answers(const std::uint8_t* data, std::size_t size);
}

namespace sixdial {
namespace {

struct Fuzzer {
  const char* name;
  const char* corpus;
  int (*run)(const std::uint8_t* data, std::size_t size);
  int mutations;
};

class Corpus : public testing::TestWithParam<Fuzzer> {};

std::vector<std::string> kept(const std::string& corpus) {
  std::vector<std::filesystem::path> paths;
  for (const auto& each : std::filesystem::directory_iterator(
           test_paths::source_dir() + "/tests/fuzz/" + corpus)) {
    paths.push_back(each.path());
  }
  std::ranges::sort(paths);
  std::vector<std::string> inputs;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

std::string mutated(std::string text, std::mt19937_64& random, const std::string& other) {
  const int changes = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < changes; ++i) {
    const std::size_t at = text.empty() ? 0 : random() % text.size();
    switch (random() % 5) {
      case 0:
        if (!text.empty()) text[at] = static_cast<char>(random() % 256);
        break;
      case 1:
        text.insert(at, 1, static_cast<char>(random() % 256));
        break;
      case 2:
        text.erase(at, random() % 8);
        break;
      case 3:
        text.insert(at, text.substr(at, random() % 16));
        break;
      default:
        text = text.substr(0, at) + other.substr(other.empty() ? 0 : random() % other.size());
    }
  }
  return text;
}

// A law that is broken aborts the program; what is thrown fails the test.
TEST_P(Corpus, AndItsMutationsBreakNoLaw) {
  const Fuzzer& fuzzer = GetParam();
  const auto run = [&](const std::string& input) {
    (void)fuzzer.run(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  };
  const std::vector<std::string> inputs = kept(fuzzer.corpus);
  ASSERT_GE(inputs.size(), 2U);
  for (const std::string& input : inputs) run(input);
  std::mt19937_64 random(17);
  int tried = 0;
  for (; tried < fuzzer.mutations; ++tried) {
    const std::string& base = inputs[random() % inputs.size()];
    run(mutated(base, random, inputs[random() % inputs.size()]));
  }
  EXPECT_EQ(tried, fuzzer.mutations);
  test::figure(
      std::string("corpus.") + fuzzer.name, inputs.size() + static_cast<std::size_t>(tried));
}

template <typename Accepts>
int accepted(const std::string& corpus, Accepts accepts) {
  int count = 0;
  for (const std::string& input : kept(corpus)) {
    try {
      if (accepts(input)) ++count;
    } catch (const std::exception&) {  // refused
    }
  }
  return count;
}

// A fuzzer whose corpus is refused at the first byte tries nothing that comes after it.
TEST(CorpusReach, BehindEveryParserIsAValidInput) {
  namespace a = acquisition;
  for (const a::DialProtocol* protocol : a::dial_protocols()) {
    const auto is_frame = [&](const std::string& input) {
      const int channel = protocol->channels > 0
                              ? 1 + static_cast<std::uint8_t>(input.at(0)) % protocol->channels
                              : 0;
      return protocol->parse(std::string_view(input).substr(1), channel).has_value();
    };
    EXPECT_GE(accepted("dials_corpus", is_frame), 1) << protocol->name;
  }
  const auto is_reply = [](const std::string& input) {
    const std::vector<std::uint8_t> bytes(input.begin(), input.end());
    return a::parse_read_reply(std::span(bytes).subspan(1), 1, 4, 1 + bytes.at(0) % 125)
        .has_value();
  };
  EXPECT_GE(accepted("modbus_reply_corpus", is_reply), 1);
  const auto is_write_reply = [](const std::string& input) {
    const std::vector<std::uint8_t> bytes(input.begin(), input.end());
    return a::parse_write_reply(std::span(bytes).subspan(1), 1, 0, 1 + bytes.at(0) % 125)
        .has_value();
  };
  EXPECT_GE(accepted("modbus_reply_corpus", is_write_reply), 1);
  for (const char* scheme : {"serial:", "modbus-tcp:", "modbus-rtu:"}) {
    const auto is_dial = [&](const std::string& input) {
      return input.starts_with(scheme) && a::parse_dial_connection(input).has_value();
    };
    EXPECT_GE(accepted("connection_corpus", is_dial), 1) << scheme;
  }
  const auto is_request = [](const std::string& input) {
    return !service::parse_request(service::parse_line(input)).method.empty();
  };
  EXPECT_GE(accepted("request_corpus", is_request), 1);
  const geometry::Rig rig = geometry::default_rig();
  const auto is_session = [&](const std::string& input) {
    return !session::parse_session(input, "session.csv", session::write_rig(rig), "rig.toml")
                .samples.empty();
  };
  EXPECT_GE(accepted("session_csv_corpus", is_session), 1);
  const auto is_plan = [&](const std::string& input) {
    return !session::parse_plan(input, "plan.csv", rig).points.empty();
  };
  EXPECT_GE(accepted("session_csv_corpus", is_plan), 1);
  const auto is_table = [](const std::string& input) {
    const std::size_t cut = input.find('\f');
    if (cut == std::string::npos) return false;
    const bool yaml = input.substr(cut + 1).starts_with('y');
    const auto table =
        session::read_table(input.substr(cut + (yaml ? 2 : 1)), yaml ? "a.yaml" : "a.csv", {});
    return table.rows.size() >= 2;
  };
  EXPECT_GE(accepted("import_corpus", is_table), 5);
  const auto is_urdf = [](const std::string& input) {
    return geometry::read_urdf(input, "", "").has_value();
  };
  EXPECT_GE(accepted("urdf_corpus", is_urdf), 2);
  const auto is_rig = [](const std::string& input) {
    return session::parse_rig(input, "rig.toml").dials.size() == 6;
  };
  EXPECT_GE(accepted("session_rig_corpus", is_rig), 1);
}

TEST(CorpusReach, BehindEveryParserOfARobotIsAValidInput) {
  namespace a = acquisition;
  const std::vector<a::RobotJoint> joints{{"theta1", true}, {"slide", false}};
  for (const a::RobotDriver* driver : a::robot_drivers()) {
    const auto is_robot = [&](const std::string& input) {
      const auto parsed = a::parse_robot_connection(input, joints);
      return parsed.has_value() && parsed->driver == driver;
    };
    EXPECT_GE(accepted("connection_corpus", is_robot), 1) << driver->scheme;
  }
  for (const a::GcodeDialect* dialect : a::gcode_dialects()) {
    const auto is_report = [&](const std::string& input) {
      const auto line = dialect->parse(input);
      return line && line->kind == a::GcodeLineKind::kReport;
    };
    EXPECT_GE(accepted("robot_answers_corpus", is_report), 1) << dialect->name;
  }
  const auto is_status = [&](const std::string& input) {
    const auto message = a::parse_klipper(input);
    return message && !message->status.live.empty();
  };
  EXPECT_GE(accepted("robot_answers_corpus", is_status), 1);
  const auto is_position = [&](const std::string& input) {
    const auto line = a::parse_linuxcnc(input);
    const auto figures =
        line && line->name == "ABS_ACT_POS" ? a::cnc_figures(line->rest) : std::nullopt;
    return figures && figures->size() == a::kCncAxes.size();
  };
  EXPECT_GE(accepted("robot_answers_corpus", is_position), 1);
  const auto is_printed = [&](const std::string& input) {
    const auto answer = a::parse_exec_output(input, joints);
    return answer && answer->q.has_value();
  };
  EXPECT_GE(accepted("robot_answers_corpus", is_printed), 1);
}

INSTANTIATE_TEST_SUITE_P(
    , Corpus,
    testing::Values(
        Fuzzer{"dials", "dials_corpus", fuzz_dials, 200'000},
        Fuzzer{"modbus_reply", "modbus_reply_corpus", fuzz_modbus_reply, 200'000},
        Fuzzer{"connection", "connection_corpus", fuzz_connection, 50'000},
        Fuzzer{"request", "request_corpus", fuzz_request, 20'000},
        Fuzzer{"session_csv", "session_csv_corpus", session_csv_fuzz, 3'000},
        Fuzzer{"session_rig", "session_rig_corpus", session_rig_fuzz, 1'000},
        Fuzzer{"import", "import_corpus", import_fuzz, 1'000},
        Fuzzer{"urdf", "urdf_corpus", urdf_fuzz, 1'000},
        Fuzzer{"robot_answers", "robot_answers_corpus", fuzz_robot_answers, 100'000}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace sixdial
