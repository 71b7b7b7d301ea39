// One writer a database: an flock on "<database>.lock", which the kernel drops when its holder
// ends, however it ends. The file stays and says who held it last.
#pragma once

#include <string>

namespace sixdial::db {

class WriterLock {
 public:
  /// Throws StoreError kLocked, naming the holder's process, if another writer has it.
  explicit WriterLock(const std::string& database_path);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace sixdial::db
