#include "service/report_pdf.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "service/error.h"

extern char** environ;

namespace sixdial::service {
namespace {

constexpr auto kBrowserPatience = std::chrono::seconds(120);  // a loaded machine's browser
constexpr auto kLook = std::chrono::milliseconds(50);

/// Chromium's profile and what it says; goes away with its owner.
class Scratch {
 public:
  Scratch() {
    path_ = (std::filesystem::temp_directory_path() / "sixdial-pdf-").string();
    path_.append(6, 'X');  // mkdtemp's
    if (::mkdtemp(path_.data()) == nullptr) {
      throw Error(ErrorCode::kFile, "no temporary folder for the browser", {{"file", path_}});
    }
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// In a file URL: what is not plain is escaped by its bytes.
std::string file_url(const std::filesystem::path& file) {
  std::string url = "file://";
  for (const char letter : std::filesystem::absolute(file).string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(letter)) != 0 ||
                       std::string_view("/-_.~").find(letter) != std::string_view::npos;
    url += plain ? std::string(1, letter)
                 : fmt::format("%{:02X}", static_cast<unsigned char>(letter));
  }
  return url;
}

/// The exit code; empty: it took too long and was ended.
std::optional<int> run(std::vector<std::string> arguments, const std::string& log) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(
      &actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  pid_t pid = 0;
  const int failed = ::posix_spawn(&pid, argv.front(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return 127;
  const auto end = std::chrono::steady_clock::now() + kBrowserPatience;
  int status = 0;
  while (::waitpid(pid, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      ::kill(pid, SIGKILL);
      ::waitpid(pid, &status, 0);
      return std::nullopt;
    }
    std::this_thread::sleep_for(kLook);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string last_words(const std::string& log) {
  constexpr std::size_t kMost = 400;
  std::ifstream file(log);
  const std::string all(std::istreambuf_iterator<char>(file), {});
  return all.size() > kMost ? all.substr(all.size() - kMost) : all;
}

bool is_pdf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 5> begin{};
  stream.read(begin.data(), begin.size());
  return stream && std::string_view(begin.data(), begin.size()) == "%PDF-";
}

}  // namespace

std::optional<std::filesystem::path> find_chromium() {
  const char* path = std::getenv("PATH");
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
      const std::filesystem::path program = std::filesystem::path(folder) / name;
      if (!folder.empty() && ::access(program.c_str(), X_OK) == 0) return program;
    }
  }
  return std::nullopt;
}

void print_pdf(const std::filesystem::path& html, const std::filesystem::path& pdf) {
  const auto chromium = find_chromium();
  if (!chromium) {
    throw Error(
        ErrorCode::kFile,
        fmt::format("{} was not made: there is no Chromium on this machine", pdf.string()),
        {{"file", pdf.string()}},
        fmt::format(
            "apt-get install chromium, or open {} in any browser and print it.",
            html.string()));
  }
  const Scratch scratch;
  const std::string made = scratch.path() + "/report.pdf";
  const std::string log = scratch.path() + "/log";
  std::vector<std::string> arguments{
      chromium->string(),
      "--headless",
      "--disable-gpu",
      "--disable-dev-shm-usage",
      "--disable-background-networking",
      "--disable-sync",
      "--disable-extensions",
      "--no-first-run",
      "--no-pdf-header-footer",
      "--user-data-dir=" + scratch.path() + "/profile",
      "--print-to-pdf=" + made,
      file_url(html)};
  // Chromium has no sandbox for root; the page is this program's own and asks for nothing.
  if (::geteuid() == 0) arguments.insert(arguments.begin() + 1, "--no-sandbox");
  const auto code = run(std::move(arguments), log);
  if (code != 0 || !is_pdf(made)) {
    throw Error(
        ErrorCode::kFile,
        fmt::format(
            "{} was not made: {} {}", pdf.string(), chromium->string(),
            code ? fmt::format("ended with {}: {}", *code, last_words(log))
                 : "took too long and was ended"),
        {{"file", pdf.string()}},
        fmt::format("Open {} in any browser and print it.", html.string()));
  }
  std::error_code trouble;
  std::filesystem::copy_file(
      made, pdf, std::filesystem::copy_options::overwrite_existing, trouble);
  if (trouble) {
    throw Error(
        ErrorCode::kFile, fmt::format("cannot write {}: {}", pdf.string(), trouble.message()),
        {{"file", pdf.string()}});
  }
}

}  // namespace sixdial::service
