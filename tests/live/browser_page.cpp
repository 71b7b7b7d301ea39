#include "tests/live/browser_page.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

#include "tests/support/paths.h"

extern char** environ;

namespace sixdial::testing {

BrowserPage::BrowserPage() {
  std::array<int, 2> in{}, out{};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe");
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  std::string python = "python3";
  std::string script = test_paths::source_dir() + "/tests/live/drive.py";
  std::array<char*, 3> arguments{python.data(), script.data(), nullptr};
  const int failed =
      ::posix_spawnp(&pid_, "python3", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(in[0]);
  ::close(out[1]);
  to_ = in[1];
  from_ = out[0];
  if (failed != 0) throw std::runtime_error("python3 could not be started");
}

BrowserPage::~BrowserPage() {
  ::close(to_);  // the driver ends its browser and itself
  if (pid_ > 0) ::waitpid(pid_, nullptr, 0);
  ::close(from_);
}

Json BrowserPage::tell(const Json& order) {
  const std::string line = order.dump() + "\n";
  if (::write(to_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    throw std::runtime_error("the browser's driver has gone");
  }
  std::size_t end = std::string::npos;
  while ((end = buffer_.find('\n')) == std::string::npos) {
    std::string chunk(65536, '\0');
    const ssize_t size = ::read(from_, chunk.data(), chunk.size());
    if (size <= 0) throw std::runtime_error("the browser's driver has ended");
    buffer_.append(chunk, 0, static_cast<std::size_t>(size));
  }
  const Json answer = Json::parse(buffer_.substr(0, end));
  buffer_.erase(0, end + 1);
  if (answer.contains("error")) throw std::runtime_error(answer["error"].get<std::string>());
  return answer["value"];
}

}  // namespace sixdial::testing
