// The socket as clients of every kind meet it: by hand, wrong, greedy, slow, dead.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <vector>

#include "service/socket/request.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::service {
namespace {

using testing::error_code_of;
using testing::eventually;
using testing::LineClient;
using testing::RunningService;

constexpr const char* kHello = R"({"jsonrpc":"2.0","id":1,"method":"hello"})";

TEST(Socket, AHandTypedLineIsAnswered) {
  RunningService running;
  LineClient client = running.client();
  const Json reply = client.ask(kHello);
  EXPECT_EQ(reply["id"], 1);
  EXPECT_EQ(reply["jsonrpc"], "2.0");
  EXPECT_EQ(reply["result"]["service"], "sixdiald");
  EXPECT_EQ(reply["result"]["limits"]["clients"], 64);
}

TEST(Socket, ALastLineWithoutNewlineIsAnsweredBeforeTheConnectionEnds) {
  RunningService running;
  LineClient client = running.client();
  client.send(kHello);
  client.finish_sending();
  EXPECT_EQ(client.read()["result"]["service"], "sixdiald");
  EXPECT_FALSE(client.read_line().has_value());
}

TEST(Socket, AWrongLineGetsAProperErrorAndTheServiceLivesOn) {
  RunningService running;
  LineClient client = running.client();
  struct Case {
    std::string line;
    int number;
    std::string code;
  };
  const std::vector<Case> cases{
      {"hello", -32700, "parse_error"},
      {R"({"jsonrpc":"2.0","id":1,"method":"hello")", -32700, "parse_error"},
      {"\xff\xfe\x80", -32700, "parse_error"},
      {std::string("{\0}", 3), -32700, "parse_error"},
      {R"({"jsonrpc":"2.0","id":1e999,"method":"hello"})", -32700, "parse_error"},
      {"17", -32600, "invalid_request"},
      {"[]", -32600, "invalid_request"},
      {"null", -32600, "invalid_request"},
      {R"({"id":1,"method":"hello"})", -32600, "invalid_request"},
      {R"({"jsonrpc":"1.0","id":1,"method":"hello"})", -32600, "invalid_request"},
      {R"({"jsonrpc":"2.0","id":1})", -32600, "invalid_request"},
      {R"({"jsonrpc":"2.0","id":1,"method":5})", -32600, "invalid_request"},
      {R"({"jsonrpc":"2.0","id":[1],"method":"hello"})", -32600, "invalid_request"},
      {R"({"jsonrpc":"2.0","id":1,"method":"hello","parms":{}})", -32600, "invalid_request"},
      {R"({"jsonrpc":"2.0","id":1,"method":"hello","params":3})", -32600, "invalid_request"},
      {R"({"jsonrpc":"2.0","id":1,"method":"hello","params":[3]})", -32602, "invalid_params"},
      {R"({"jsonrpc":"2.0","id":1,"method":"helo"})", -32601, "unknown_method"},
      {R"({"jsonrpc":"2.0","id":1,"method":"job.status"})", -32602, "invalid_params"},
      {R"({"jsonrpc":"2.0","id":1,"method":"job.status","params":{"job":"x"}})", -32602,
       "invalid_params"},
      {R"({"jsonrpc":"2.0","id":1,"method":"job.status","params":{"job":0}})", -32602,
       "invalid_params"},
      {R"({"jsonrpc":"2.0","id":1,"method":"job.status","params":{"job":77}})", -32010,
       "not_found"},
  };
  for (const Case& each : cases) {
    const Json reply = client.ask(each.line);
    ASSERT_TRUE(reply.contains("error")) << each.line << " -> " << reply;
    EXPECT_EQ(reply["error"]["code"], each.number) << each.line;
    EXPECT_EQ(reply["error"]["data"]["code"], each.code) << each.line;
    EXPECT_FALSE(reply["error"]["message"].get<std::string>().empty());
    EXPECT_TRUE(reply["error"]["data"]["retry"].is_boolean());
    EXPECT_FALSE(reply["error"]["data"]["hint"].get<std::string>().empty());
    EXPECT_TRUE(reply["error"]["data"].contains("at"));
  }
  EXPECT_EQ(client.ask(kHello)["result"]["service"], "sixdiald");
}

TEST(Socket, AMistypedNameIsAnsweredWithTheNearestOne) {
  RunningService running;
  LineClient client = running.client();
  EXPECT_THAT(
      client.ask(R"({"jsonrpc":"2.0","id":1,"method":"job.statsu"})")["error"]["data"]["hint"]
          .get<std::string>(),
      ::testing::HasSubstr("'job.status'"));
  const Json reply =
      client.ask(R"({"jsonrpc":"2.0","id":1,"method":"job.wait","params":{"jop":1}})");
  EXPECT_EQ(reply["error"]["data"]["at"]["param"], "jop");
  EXPECT_THAT(reply["error"]["data"]["hint"].get<std::string>(), ::testing::HasSubstr("'job'"));
}

TEST(Socket, ANotificationGetsNoAnswer) {
  RunningService running;
  LineClient client = running.client();
  client.send(R"({"jsonrpc":"2.0","method":"hello"})"
              "\n\n  \n");
  EXPECT_EQ(client.ask(R"({"jsonrpc":"2.0","id":"second","method":"hello"})")["id"], "second");
}

TEST(Socket, ABatchIsAnsweredByOneArray) {
  RunningService running;
  LineClient client = running.client();
  const Json replies = client.ask(
      R"([{"jsonrpc":"2.0","id":1,"method":"hello"},{"jsonrpc":"2.0","method":"hello"},)"
      R"({"jsonrpc":"2.0","id":2,"method":"nothing.like.it"},5])");
  ASSERT_EQ(replies.size(), 3U);
  EXPECT_EQ(replies[0]["id"], 1);
  EXPECT_EQ(error_code_of(replies[1]), "unknown_method");
  EXPECT_EQ(error_code_of(replies[2]), "invalid_request");
  client.send(R"([{"jsonrpc":"2.0","method":"hello"}])"
              "\n");  // nothing to answer
  EXPECT_EQ(client.ask(kHello)["id"], 1);
}

TEST(Socket, AnswersOfABatchThatDoNotFitIntoALineAreSaidToBeTooLarge) {
  RunningService running;
  LineClient client = running.client();
  Json batch = Json::array();
  for (int i = 0; i < 64; ++i) {
    batch.push_back({{"jsonrpc", "2.0"}, {"id", i}, {"method", "rpc.discover"}});
  }
  client.send(batch.dump() + "\n");
  const auto line = client.read_line();
  ASSERT_TRUE(line.has_value());
  EXPECT_LT(line->size() + 1, kMaxLineBytes);
  const Json replies = Json::parse(*line);
  ASSERT_EQ(replies.size(), 64U);
  EXPECT_EQ(error_code_of(replies[63]), "result_too_large");
  batch.push_back(5);
  EXPECT_EQ(error_code_of(client.ask(batch.dump())), "invalid_request");
}

TEST(Socket, ANestingBombIsRefusedBeforeItIsParsed) {
  RunningService running;
  LineClient client = running.client();
  EXPECT_EQ(error_code_of(client.ask(std::string(1'000'000, '['))), "nesting_too_deep");
  EXPECT_EQ(error_code_of(client.ask(std::string(33, '['))), "nesting_too_deep");
  EXPECT_EQ(error_code_of(client.ask(std::string(32, '['))), "parse_error");
  // Brackets inside a string are no nesting.
  const Json reply =
      client.ask(R"({"jsonrpc":"2.0","id":1,"method":"\"\\)" + std::string(100, '[') + R"("})");
  EXPECT_EQ(error_code_of(reply), "unknown_method");
}

TEST(Socket, AnOversizedLineIsRefusedAndTheNextOneAnswered) {
  RunningService running;
  LineClient client = running.client();
  const std::string huge(3 * kMaxRequestBytes, 'x');
  ASSERT_TRUE(client.send(huge + "\n" + kHello + "\n"));
  EXPECT_EQ(error_code_of(client.read()), "line_too_long");
  EXPECT_EQ(client.read()["result"]["service"], "sixdiald");
}

TEST(Socket, TheLongestAllowedLineIsTaken) {
  RunningService running;
  LineClient client = running.client();
  std::string line = R"({"jsonrpc":"2.0","id":1,"method":"hello"})";
  line += std::string(kMaxRequestBytes - line.size(), ' ');
  EXPECT_EQ(client.ask(line)["result"]["service"], "sixdiald");
  EXPECT_EQ(error_code_of(client.ask(line + " ")), "line_too_long");
}

TEST(Socket, SixtyFourClientsAreServedAndOneMoreIsRefusedInWords) {
  RunningService running;
  std::vector<LineClient> clients;
  for (std::size_t i = 0; i < kMaxClients; ++i) {
    clients.push_back(running.client());
    EXPECT_EQ(clients.back().ask(kHello)["result"]["service"], "sixdiald");
  }
  LineClient one_more = running.client();
  EXPECT_EQ(error_code_of(one_more.read()), "too_many_clients");
  EXPECT_FALSE(one_more.read_line().has_value());
  clients.pop_back();
  EXPECT_TRUE(eventually([&] {
    LineClient again = running.client();
    return again.ask(kHello).contains("result");
  }));
}

TEST(Socket, ManyRequestsOfManyClientsAreEachAnsweredInOrder) {
  RunningService running;
  constexpr int kClients = 16;
  constexpr int kRequests = 200;
  std::vector<LineClient> clients;
  for (int i = 0; i < kClients; ++i) clients.push_back(running.client());
  for (LineClient& client : clients) {
    std::string lines;
    for (int id = 0; id < kRequests; ++id) {
      lines += Json{{"jsonrpc", "2.0"}, {"id", id}, {"method", "job.list"}}.dump() + "\n";
    }
    ASSERT_TRUE(client.send(lines));
  }
  int answered = 0;
  for (LineClient& client : clients) {
    for (int id = 0; id < kRequests; ++id) answered += client.read()["id"] == id ? 1 : 0;
  }
  EXPECT_EQ(answered, kClients * kRequests);
}

TEST(Socket, IsForItsOwnerAloneAndKnowsWhoAsks) {
  RunningService running;
  struct stat about {};
  ASSERT_EQ(::stat(running.socket_path().c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  LineClient client = running.client();
  EXPECT_EQ(client.ask(kHello)["result"]["operator"], operator_of(::getuid()));
}

TEST(Socket, AStaleSocketIsTakenOverAndALiveOneIsNot) {
  testing::TempDirectory directory;
  const auto path = directory.path() / "s";
  Service service({.database = directory.path() / "a.db"});
  {  // a socket file that nobody listens on, as kill -9 leaves it
    asio::io_context loop;
    asio::local::stream_protocol::acceptor dead(
        loop, asio::local::stream_protocol::endpoint(path.string()));
  }
  ASSERT_TRUE(std::filesystem::exists(path));
  Server server(service, {.socket_path = path});
  try {
    Server second(service, {.socket_path = path});
    FAIL() << "a second service took the socket";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kWrongState);
  }
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(Socket, ASocketThatAnswersWithoutALockIsNotTaken) {
  testing::TempDirectory directory;
  const auto path = directory.path() / "s";
  Service service({.database = directory.path() / "a.db"});
  asio::io_context loop;
  asio::local::stream_protocol::acceptor alive(
      loop, asio::local::stream_protocol::endpoint(path.string()));
  EXPECT_THROW(Server(service, {.socket_path = path}), Error);
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(Socket, AFileThatIsNoSocketIsLeftAlone) {
  testing::TempDirectory directory;
  const auto path = directory.path() / "s";
  std::ofstream(path) << "precious";
  Service service({.database = directory.path() / "a.db"});
  EXPECT_THROW(Server(service, {.socket_path = path}), Error);
  EXPECT_EQ(std::filesystem::file_size(path), 8U);
}

TEST(Socket, ATooLongPathIsRefusedInWords) {
  testing::TempDirectory directory;
  Service service({.database = directory.path() / "a.db"});
  const auto path = directory.path() / std::string(120, 'p');
  EXPECT_THROW(Server(service, {.socket_path = path}), Error);
}

TEST(Socket, ShutdownAnswersAndTakesTheSocketAway) {
  RunningService running;
  LineClient client = running.client();
  EXPECT_EQ(client.call("shutdown")["result"]["stopping"], true);
  EXPECT_FALSE(client.read_line().has_value());
  running.stop();
}

}  // namespace
}  // namespace sixdial::service
