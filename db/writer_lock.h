// One writer a database: an flock on the database file itself, whatever name or link it was
// opened by; the kernel drops it when its holder ends, however it ends. "<database>.lock"
// beside it says who holds it, or held it last.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace sixdial::db {

class WriterLock {
 public:
  /// Makes the file if there is none. Throws StoreError: kLocked, naming the holder's process,
  /// if another writer has it; kCannotOpen, also for what is no plain file.
  explicit WriterLock(const std::string& database_path);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  using FileId = std::pair<std::uint64_t, std::uint64_t>;  // device, inode

  int fd_ = -1;
  FileId file_{};
};

}  // namespace sixdial::db
