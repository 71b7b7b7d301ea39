// The program sixdiald as systemd and a stranger meet it: handed-over sockets, rights, the end
// within five seconds, and the Python client of examples/.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <array>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "session/csv.h"
#include "tests/support/figure.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::service {
namespace {

using testing::eventually;
using testing::LineClient;
using testing::RunningService;
using testing::TempDirectory;

const std::string kProgram = test_paths::bin_dir() + "/sixdiald";

/// A listening Unix socket, as systemd holds it.
int listening_socket(const std::filesystem::path& path) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.string().copy(address.sun_path, sizeof(address.sun_path) - 1);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::listen(fd, 64) != 0) {
    throw std::runtime_error("cannot listen on " + path.string());
  }
  return fd;
}

/// sixdiald with descriptor 3 and LISTEN_FDS set, as sd_listen_fds(3) says.
pid_t start_with_socket(int socket, const std::filesystem::path& directory) {
  const std::string database = (directory / "a.db").string();
  const std::string own = (directory / "own").string();
  const pid_t pid = ::fork();
  if (pid != 0) return pid;
  if (socket == 3) {
    ::fcntl(3, F_SETFD, 0);
  } else {
    ::dup2(socket, 3);
  }
  ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
  ::setenv("LISTEN_FDS", "1", 1);
  ::execl(
      kProgram.c_str(), "sixdiald", "--db", database.c_str(), "--socket", own.c_str(),
      "--log-level", "error", nullptr);
  ::_exit(99);
}

int ended(pid_t pid) {
  int status = 0;
  ::waitpid(pid, &status, 0);
  return status;
}

/// A child that a test which fails halfway does not leave running: it would hold the test's
/// output open, and whoever runs the tests would wait for it.
struct Child {
  explicit Child(pid_t of) : pid(of) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid > 0 && ::waitpid(pid, nullptr, WNOHANG) == 0) {
      ::kill(pid, SIGKILL);
      ::waitpid(pid, nullptr, 0);
    }
  }
  pid_t pid;
};

TEST(SocketActivation, TheHandedOverSocketIsServedAndNeverTakenAway) {
  TempDirectory directory;
  const auto path = directory.path() / "handed-over";
  const int socket = listening_socket(path);
  for (int run = 0; run < 2; ++run) {
    // The client comes first: systemd starts the service for it.
    LineClient client(path);
    const pid_t pid = start_with_socket(socket, directory.path());
    const Child launched(pid);
    EXPECT_EQ(client.call("hello")["result"]["service"], "sixdiald") << "run " << run;
    EXPECT_FALSE(std::filesystem::exists(directory.path() / "own"))
        << "it must not make a socket of its own besides";
    const auto from = std::chrono::steady_clock::now();
    ::kill(pid, SIGTERM);
    EXPECT_EQ(ended(pid), 0);
    const double took_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    EXPECT_LT(took_s, 5.0);
    test::figure("service.shutdown_s", took_s);
    EXPECT_TRUE(std::filesystem::exists(path)) << "systemd's socket was unlinked";
  }
  ::close(socket);
}

TEST(SocketActivation, SystemdsOwnLauncherStartsItForItsFirstClient) {
  const std::filesystem::path launcher = "/usr/bin/systemd-socket-activate";
  ASSERT_TRUE(std::filesystem::exists(launcher)) << "./run setup installs the package systemd";
  TempDirectory directory;
  const std::string path = (directory.path() / "handed-over").string();
  const std::string database = (directory.path() / "a.db").string();
  const std::string own = (directory.path() / "own").string();
  const std::string said = (directory.path() / "said").string();
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::dup2(::open(said.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
    ::execl(
        launcher.c_str(), launcher.c_str(), "--listen", path.c_str(), kProgram.c_str(), "--db",
        database.c_str(), "--socket", own.c_str(), "--log-level", "error", nullptr);
    ::_exit(99);
  }
  const Child launched(pid);
  ASSERT_TRUE(eventually([&] { return std::filesystem::exists(path); }));
  EXPECT_FALSE(std::filesystem::exists(database)) << "it starts for a client, not before";
  // The file is there a moment before anybody listens.
  std::unique_ptr<LineClient> client;
  ASSERT_TRUE(eventually([&] {
    try {
      client = std::make_unique<LineClient>(path);
    } catch (const std::runtime_error&) {
      return false;
    }
    return true;
  })) << session::read_file(said);
  EXPECT_EQ(client->call("hello")["result"]["service"], "sixdiald");
  EXPECT_TRUE(std::filesystem::exists(database));
  EXPECT_FALSE(std::filesystem::exists(own));
  ::kill(pid, SIGTERM);
  EXPECT_EQ(ended(pid), 0) << session::read_file(said);
  EXPECT_TRUE(std::filesystem::exists(path)) << "systemd's socket was unlinked";
}

TEST(SocketActivation, AVariableMeantForAnotherProcessIsPassedOver) {
  TempDirectory directory;
  const std::string database = (directory.path() / "a.db").string();
  const std::string own = (directory.path() / "own").string();
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::setenv("LISTEN_PID", "1", 1);
    ::setenv("LISTEN_FDS", "1", 1);
    ::execl(
        kProgram.c_str(), "sixdiald", "--db", database.c_str(), "--socket", own.c_str(),
        "--log-level", "error", nullptr);
    ::_exit(99);
  }
  EXPECT_TRUE(eventually([&] {
    try {
      return LineClient(own).call("hello").contains("result");
    } catch (const std::runtime_error&) {
      return false;
    }
  }));
  ::kill(pid, SIGTERM);
  EXPECT_EQ(ended(pid), 0);
}

TEST(Rights, NobodyWithoutThemOnTheSocketGetsIn) {
  RunningService running;
  struct stat about {};
  ASSERT_EQ(::stat(running.socket_path().c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  if (::geteuid() != 0) return;  // only root can become somebody else to try it
  std::filesystem::permissions(
      running.directory(), std::filesystem::perms::others_exec,
      std::filesystem::perm_options::add);
  const std::string path = running.socket_path().string();
  const pid_t stranger = ::fork();
  if (stranger == 0) {
    if (::setgid(65534) != 0 || ::setuid(65534) != 0) ::_exit(3);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    const int got = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
    ::_exit(got != 0 && errno == EACCES ? 0 : 1);
  }
  EXPECT_EQ(ended(stranger), 0) << "a stranger was let in, or not kept out by rights";
  EXPECT_EQ(running.client().call("hello")["result"]["service"], "sixdiald");
}

struct Said {
  int status = -1;
  std::string text;
};

Said run_client(const std::string& words, const std::filesystem::path& socket) {
  const std::string command = "SIXDIAL_SOCKET='" + socket.string() + "' timeout 60 python3 '" +
                              test_paths::source_dir() + "/examples/client.py' " + words +
                              " 2>&1";
  Said said;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return said;
  std::array<char, 4096> piece{};
  for (std::size_t size = 0; (size = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) {
    said.text.append(piece.data(), size);
  }
  said.status = ::pclose(pipe);
  return said;
}

TEST(PythonClient, AsksAndTellsErrorsWithTheirHint) {
  RunningService running;
  const Said hello = run_client("hello", running.socket_path());
  ASSERT_EQ(hello.status, 0) << hello.text;
  EXPECT_EQ(Json::parse(hello.text)["service"], "sixdiald");
  const std::string bundle = test_paths::test_data() + "/session_00";
  const Said imported =
      run_client("session.import name=one path=" + bundle, running.socket_path());
  ASSERT_EQ(imported.status, 0) << imported.text;
  EXPECT_EQ(Json::parse(imported.text)["samples"], 150);
  const Said page = run_client("session.show session=one limit=3", running.socket_path());
  EXPECT_EQ(Json::parse(page.text)["page"].size(), 3U);
  const Said wrong = run_client("session.show session=two", running.socket_path());
  EXPECT_NE(wrong.status, 0);
  EXPECT_THAT(wrong.text, ::testing::HasSubstr("two"));
  std::ifstream source(test_paths::source_dir() + "/examples/client.py");
  int lines = 0;
  for (std::string line; std::getline(source, line);) ++lines;
  EXPECT_LE(lines, 30) << "an example to copy is short";
}

}  // namespace
}  // namespace sixdial::service
