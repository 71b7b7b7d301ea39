#include "db/writer_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "db/store_error.h"

namespace sixdial::db {

WriterLock::WriterLock(const std::string& database_path) {
  const std::string path = database_path + ".lock";
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd_ < 0) {
    const int code = errno;
    throw StoreError(
        StoreTrouble::kCannotOpen, database_path,
        fmt::format("its lock file cannot be opened: {}", std::strerror(code)),
        "check that the folder exists and may be written");
  }
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    std::array<char, 32> holder{};
    const ssize_t count = ::pread(fd_, holder.data(), holder.size() - 1, 0);
    std::string who(holder.data(), count > 0 ? static_cast<std::size_t>(count) : 0U);
    if (who.ends_with('\n')) who.pop_back();
    ::close(fd_);
    throw StoreError(
        StoreTrouble::kLocked, database_path,
        fmt::format(
            "another Sixdial process{} writes this database already",
            who.empty() ? "" : " (" + who + ")"),
        "talk to that one, or stop it first; readers may open it read-only");
  }
  const std::string who = fmt::format("process {}\n", ::getpid());
  // Only for the message above: the lock holds without it.
  if (::ftruncate(fd_, 0) == 0 &&
      ::pwrite(fd_, who.data(), who.size(), 0) != static_cast<ssize_t>(who.size())) {
    (void)::ftruncate(fd_, 0);
  }
}

WriterLock::~WriterLock() { ::close(fd_); }

}  // namespace sixdial::db
