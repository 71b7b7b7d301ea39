// A disk in memory behind SQLite: counts every write, sync and truncation, fails one on order,
// fills up, tears writes, loses power. What was not synced may be lost, sector by sector.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sixdial::db {

class FaultyDisk {
 public:
  enum class Fault {
    kErrorOnce,     // that operation fails and does nothing
    kTornOnce,      // half of that write arrives, then it fails
    kErrorForEver,  // that operation and all after it fail
    kFullOnce,      // no room for that operation
    kPowerLoss,     // as kErrorForEver; then restart() keeps only what was synced, and luck
  };

  /// Registers itself as an SQLite file system under a name of its own.
  FaultyDisk();
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;
  [[nodiscard]] const std::string& name() const { return name_; }

  /// The `operation`-th write, sync or truncation from now on, counted from 1.
  void order(Fault fault, int operation);
  [[nodiscard]] int operations() const { return operations_; }
  [[nodiscard]] bool struck() const { return struck_; }
  /// Bytes of all files together; beyond it the disk is full.
  void set_capacity(std::optional<std::size_t> bytes) { capacity_ = bytes; }
  void set_read_only(bool read_only) { read_only_ = read_only; }
  /// The machine comes up again: faults end; after a power loss each sector that was not
  /// synced is there or not, by `seed` (0: none, 1: all).
  void restart(std::uint64_t seed = 0);

  // For the SQLite methods.
  struct Pending {
    bool truncation = false;
    std::size_t offset = 0;
    std::string bytes;
  };
  struct File {
    std::string now;
    std::string synced;
    std::vector<Pending> pending;
    std::vector<std::unique_ptr<std::vector<char>>> shared;  // the index of the log
  };
  int write(File& file, const char* bytes, std::size_t count, std::size_t offset);
  int sync(File& file);
  int truncate(File& file, std::size_t size);
  [[nodiscard]] bool read_only() const { return read_only_; }
  std::map<std::string, std::shared_ptr<File>> files;

 private:
  /// The result code with which the operation must fail; nothing: it may go on.
  std::optional<int> strike(int error);
  [[nodiscard]] std::size_t used() const;

  std::string name_;
  struct Registration;
  std::unique_ptr<Registration> registration_;
  std::optional<Fault> fault_;
  int strikes_at_ = 0;
  int operations_ = 0;
  bool struck_ = false;
  bool power_lost_ = false;
  std::optional<std::size_t> capacity_;
  bool read_only_ = false;
};

}  // namespace sixdial::db
