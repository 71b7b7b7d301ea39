#include "tests/db/faulty_disk.h"

#include <sqlite3.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <new>
#include <random>
#include <utility>

namespace sixdial::db {
namespace {

constexpr std::size_t kSector = 512;
constexpr int kLongestPath = 512;

struct OpenFile {
  sqlite3_file base;  // first, as SQLite wants it
  FaultyDisk* disk;
  std::shared_ptr<FaultyDisk::File> file;
};

OpenFile& of(sqlite3_file* file) { return *reinterpret_cast<OpenFile*>(file); }
FaultyDisk& disk_of(sqlite3_vfs* vfs) { return *static_cast<FaultyDisk*>(vfs->pAppData); }
sqlite3_vfs* usual() { return sqlite3_vfs_find(nullptr); }

int close(sqlite3_file* file) {
  of(file).~OpenFile();
  return SQLITE_OK;
}

int read(sqlite3_file* file, void* to, int count, sqlite3_int64 offset) {
  const std::string& now = of(file).file->now;
  const auto wanted = static_cast<std::size_t>(count);
  const auto from = std::min(static_cast<std::size_t>(offset), now.size());
  const std::size_t there = std::min(wanted, now.size() - from);
  std::memcpy(to, now.data() + from, there);
  if (there == wanted) return SQLITE_OK;
  std::memset(static_cast<char*>(to) + there, 0, wanted - there);
  return SQLITE_IOERR_SHORT_READ;
}

int write(sqlite3_file* file, const void* bytes, int count, sqlite3_int64 offset) {
  return of(file).disk->write(
      *of(file).file, static_cast<const char*>(bytes), static_cast<std::size_t>(count),
      static_cast<std::size_t>(offset));
}

int truncate(sqlite3_file* file, sqlite3_int64 size) {
  return of(file).disk->truncate(*of(file).file, static_cast<std::size_t>(size));
}

int sync(sqlite3_file* file, int) { return of(file).disk->sync(*of(file).file); }

int size(sqlite3_file* file, sqlite3_int64* size) {
  *size = static_cast<sqlite3_int64>(of(file).file->now.size());
  return SQLITE_OK;
}

// One connection at a time: nobody to lock against.
int lock(sqlite3_file*, int) { return SQLITE_OK; }
int check_reserved(sqlite3_file*, int* result) {
  *result = 0;
  return SQLITE_OK;
}
int control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int sector_size(sqlite3_file*) { return 4096; }
// As SQLite's own file system says of every disk.
int characteristics(sqlite3_file*) { return SQLITE_IOCAP_POWERSAFE_OVERWRITE; }

int share(sqlite3_file* file, int page, int page_size, int extend, void volatile** where) {
  auto& shared = of(file).file->shared;
  *where = nullptr;
  while (shared.size() <= static_cast<std::size_t>(page)) {
    if (extend == 0) return SQLITE_OK;
    shared.push_back(
        std::make_unique<std::vector<char>>(static_cast<std::size_t>(page_size), '\0'));
  }
  *where = shared[static_cast<std::size_t>(page)]->data();
  return SQLITE_OK;
}
int share_lock(sqlite3_file*, int, int, int) { return SQLITE_OK; }
void share_barrier(sqlite3_file*) {}
int unshare(sqlite3_file* file, int) {
  of(file).file->shared.clear();
  return SQLITE_OK;
}

const sqlite3_io_methods kMethods{
    2,
    close,
    read,
    write,
    truncate,
    sync,
    size,
    lock,
    lock,
    check_reserved,
    control,
    sector_size,
    characteristics,
    share,
    share_lock,
    share_barrier,
    unshare,
    nullptr,
    nullptr};

int open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  FaultyDisk& disk = disk_of(vfs);
  OpenFile* const opened = new (file) OpenFile();
  opened->disk = &disk;
  const std::string path = name == nullptr ? "" : name;
  const auto found = disk.files.find(path);
  if (found != disk.files.end() && !path.empty()) {
    opened->file = found->second;
  } else if ((flags & SQLITE_OPEN_CREATE) != 0 && !disk.read_only()) {
    opened->file = std::make_shared<FaultyDisk::File>();
    if (!path.empty()) disk.files[path] = opened->file;
  } else {
    opened->~OpenFile();
    file->pMethods = nullptr;
    return SQLITE_CANTOPEN;
  }
  if (out_flags != nullptr) {
    *out_flags =
        disk.read_only() ? (flags & ~SQLITE_OPEN_READWRITE) | SQLITE_OPEN_READONLY : flags;
  }
  opened->base.pMethods = &kMethods;
  return SQLITE_OK;
}

int remove(sqlite3_vfs* vfs, const char* name, int) {
  return disk_of(vfs).files.erase(name) > 0 ? SQLITE_OK : SQLITE_IOERR_DELETE_NOENT;
}
int access(sqlite3_vfs* vfs, const char* name, int, int* result) {
  const auto& files = disk_of(vfs).files;
  const auto found = files.find(name);
  *result = found != files.end() ? 1 : 0;
  return SQLITE_OK;
}
int full_path(sqlite3_vfs*, const char* name, int count, char* to) {
  sqlite3_snprintf(count, to, "%s", name);
  return SQLITE_OK;
}
int randomness(sqlite3_vfs*, int count, char* to) {
  return usual()->xRandomness(usual(), count, to);
}
int sleep(sqlite3_vfs*, int microseconds) { return microseconds; }
int time_now(sqlite3_vfs*, double* time) { return usual()->xCurrentTime(usual(), time); }
int last_error(sqlite3_vfs*, int, char*) { return 0; }

}  // namespace

struct FaultyDisk::Registration {
  sqlite3_vfs vfs{};
};

FaultyDisk::FaultyDisk() : registration_(std::make_unique<Registration>()) {
  static std::atomic<int> count{0};
  name_ = "faulty_disk_" + std::to_string(++count);
  sqlite3_vfs& vfs = registration_->vfs;
  vfs.iVersion = 1;
  vfs.szOsFile = sizeof(OpenFile);
  vfs.mxPathname = kLongestPath;
  vfs.zName = name_.c_str();
  vfs.pAppData = this;
  vfs.xOpen = open;
  vfs.xDelete = remove;
  vfs.xAccess = access;
  vfs.xFullPathname = full_path;
  vfs.xRandomness = randomness;
  vfs.xSleep = sleep;
  vfs.xCurrentTime = time_now;
  vfs.xGetLastError = last_error;
  sqlite3_vfs_register(&vfs, 0);
}

FaultyDisk::~FaultyDisk() { sqlite3_vfs_unregister(&registration_->vfs); }

void FaultyDisk::order(Fault fault, int operation) {
  fault_ = fault;
  strikes_at_ = operations_ + operation;
  struck_ = false;
}

std::optional<int> FaultyDisk::strike(int error) {
  ++operations_;
  if (power_lost_) return error;
  if (!fault_ || operations_ < strikes_at_) return std::nullopt;
  const bool once = *fault_ != Fault::kErrorForEver && *fault_ != Fault::kPowerLoss;
  if (once && operations_ > strikes_at_) return std::nullopt;
  struck_ = true;
  power_lost_ = *fault_ == Fault::kPowerLoss;
  return *fault_ == Fault::kFullOnce ? SQLITE_FULL : error;
}

std::size_t FaultyDisk::used() const {
  std::size_t sum = 0;
  for (const auto& [path, file] : files) sum += file->now.size();
  return sum;
}

int FaultyDisk::write(File& file, const char* bytes, std::size_t count, std::size_t offset) {
  const std::optional<int> failed = strike(SQLITE_IOERR_WRITE);
  std::size_t arrives = count;
  if (failed) arrives = struck_ && fault_ == Fault::kTornOnce ? count / 2 : 0;
  const std::size_t end = offset + arrives;
  if (!failed && capacity_ && end > file.now.size() &&
      used() + (end - file.now.size()) > *capacity_) {
    return SQLITE_FULL;
  }
  if (arrives > 0) {
    if (file.now.size() < end) file.now.resize(end, '\0');
    file.now.replace(offset, arrives, bytes, arrives);
    file.pending.push_back({false, offset, std::string(bytes, arrives)});
  }
  return failed.value_or(SQLITE_OK);
}

int FaultyDisk::sync(File& file) {
  if (const auto failed = strike(SQLITE_IOERR_FSYNC)) return *failed;
  file.synced = file.now;
  file.pending.clear();
  return SQLITE_OK;
}

int FaultyDisk::truncate(File& file, std::size_t size) {
  if (const auto failed = strike(SQLITE_IOERR_TRUNCATE)) return *failed;
  file.now.resize(size, '\0');
  file.pending.push_back({true, size, {}});
  return SQLITE_OK;
}

void FaultyDisk::restart(std::uint64_t seed) {
  fault_.reset();
  struck_ = false;
  if (!std::exchange(power_lost_, false)) return;
  std::mt19937_64 random(seed);
  const auto lucky = [&] { return seed == 1 || (seed > 1 && random() % 2 == 0); };
  for (auto& [path, file] : files) {
    std::string disk = file->synced;
    for (const Pending& each : file->pending) {
      if (each.truncation) {
        if (lucky()) disk.resize(each.offset, '\0');
        continue;
      }
      for (std::size_t at = 0; at < each.bytes.size();) {
        const std::size_t place = each.offset + at;
        const std::size_t count = std::min(kSector - place % kSector, each.bytes.size() - at);
        if (lucky()) {
          if (disk.size() < place + count) disk.resize(place + count, '\0');
          disk.replace(place, count, each.bytes, at, count);
        }
        at += count;
      }
    }
    file->now = disk;
    file->synced = disk;
    file->pending.clear();
    file->shared.clear();
  }
}

}  // namespace sixdial::db
