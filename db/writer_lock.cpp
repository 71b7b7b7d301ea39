#include "db/writer_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <set>

#include "db/store_error.h"

namespace sixdial::db {
namespace {

/// The files that this process writes. A second writer in the same process is refused by this
/// list: closing a descriptor of the file would drop the locks that SQLite has on it.
struct Held {
  std::mutex mutex;
  std::set<std::pair<std::uint64_t, std::uint64_t>> files;
};
Held& held() {
  static Held all;
  return all;
}

/// Beside the file that the path means, through links.
std::string note_path(const std::string& database_path) {
  std::error_code ignored;
  const auto real = std::filesystem::weakly_canonical(database_path, ignored);
  return (real.empty() ? database_path : real.string()) + ".lock";
}

std::string holder_of(const std::string& database_path) {
  const int fd = ::open(note_path(database_path).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return "";
  std::array<char, 32> text{};
  const ssize_t count = ::read(fd, text.data(), text.size() - 1);
  ::close(fd);
  std::string who(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0U);
  if (who.ends_with('\n')) who.pop_back();
  return who;
}

/// Only for the message that another writer gets: the lock holds without it.
void note_holder(const std::string& database_path) {
  const int fd = ::open(
      note_path(database_path).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK,
      0644);
  if (fd < 0) return;
  const std::string who = fmt::format("process {}\n", ::getpid());
  if (::write(fd, who.data(), who.size()) != static_cast<ssize_t>(who.size())) {
    (void)::ftruncate(fd, 0);
  }
  ::close(fd);
}

[[noreturn]] void refuse_locked(const std::string& database_path) {
  const std::string who = holder_of(database_path);
  throw StoreError(
      StoreTrouble::kLocked, database_path,
      fmt::format(
          "another Sixdial process{} writes this database already",
          who.empty() ? "" : " (" + who + ")"),
      "talk to that one, or stop it first; readers may open it read-only");
}

/// Whether a plain file may be there: opening a pipe or a device would wait, or do harm.
void refuse_no_plain_file(const std::string& database_path) {
  struct stat about {};
  if (::stat(database_path.c_str(), &about) != 0 || S_ISREG(about.st_mode)) return;
  throw StoreError(
      StoreTrouble::kCannotOpen, database_path, "it is no plain file",
      "give the path of a Sixdial database or of a new file");
}

}  // namespace

WriterLock::WriterLock(const std::string& database_path) {
  refuse_no_plain_file(database_path);
  const std::lock_guard only_one(held().mutex);
  struct stat about {};
  if (::stat(database_path.c_str(), &about) == 0 &&
      held().files.contains({about.st_dev, about.st_ino})) {
    refuse_locked(database_path);
  }
  fd_ = ::open(database_path.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0644);
  if (fd_ < 0) {
    const int code = errno;
    throw StoreError(
        StoreTrouble::kCannotOpen, database_path,
        fmt::format("it cannot be opened: {}", std::strerror(code)),
        "check that the folder exists and may be written");
  }
  if (::fstat(fd_, &about) != 0 || ::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd_);
    refuse_locked(database_path);
  }
  file_ = {about.st_dev, about.st_ino};
  held().files.insert(file_);
  note_holder(database_path);
}

WriterLock::~WriterLock() {
  const std::lock_guard only_one(held().mutex);
  held().files.erase(file_);
  ::close(fd_);
}

}  // namespace sixdial::db
