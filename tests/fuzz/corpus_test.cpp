// The fuzzers' kept corpus, and seeded mutations of it, in the ordinary suite: what libFuzzer
// once reached stays reached, with any compiler.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/support/figure.h"

// Each fuzz_*.cpp under its own name (CMakeLists.txt).
extern "C" {
int fuzz_dials(const std::uint8_t* data, std::size_t size);
int fuzz_modbus_reply(const std::uint8_t* data, std::size_t size);
int fuzz_connection(const std::uint8_t* data, std::size_t size);
int fuzz_request(const std::uint8_t* data, std::size_t size);
int session_csv_fuzz(const std::uint8_t* data, std::size_t size);
int session_rig_fuzz(const std::uint8_t* data, std::size_t size);
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
           std::string(SIXDIAL_SOURCE_DIR) + "/tests/fuzz/" + corpus)) {
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

INSTANTIATE_TEST_SUITE_P(
    , Corpus,
    testing::Values(
        Fuzzer{"dials", "dials_corpus", fuzz_dials, 200'000},
        Fuzzer{"modbus_reply", "modbus_reply_corpus", fuzz_modbus_reply, 200'000},
        Fuzzer{"connection", "connection_corpus", fuzz_connection, 50'000},
        Fuzzer{"request", "request_corpus", fuzz_request, 20'000},
        Fuzzer{"session_csv", "session_csv_corpus", session_csv_fuzz, 3'000},
        Fuzzer{"session_rig", "session_rig_corpus", session_rig_fuzz, 1'000}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace sixdial
