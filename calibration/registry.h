// A table of methods: rows that the program brings, one for each file, and rows that are added
// while it runs (by a script, say). A row is an aggregate with `name`, `description` and a
// plain function. In an added row, `made` points to a function object that is called instead.
#pragma once

#include <deque>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::calibration {

/// Safe to use from several threads. Rows are never removed: pointers to them stay valid.
template <class Row, class Function>
class Registry {
 public:
  explicit Registry(std::span<const Row* const> table) : table_(table) {}

  /// The program's own rows first.
  [[nodiscard]] std::vector<const Row*> all() const {
    std::vector<const Row*> rows(table_.begin(), table_.end());
    const std::scoped_lock lock(mutex_);
    for (const Added& each : added_) rows.push_back(&each.row);
    return rows;
  }

  /// Null if there is none of that name.
  [[nodiscard]] const Row* find(std::string_view name) const {
    for (const Row* each : all()) {
      if (each->name == name) return each;
    }
    return nullptr;
  }

  /// Throws std::invalid_argument where the name is taken, empty, or could not stand in
  /// "identifier+residual_model".
  const Row& add(std::string name, std::string description, Function function) {
    if (name.empty() || name == "before" || name.find('+') != std::string::npos) {
      throw std::invalid_argument("'" + name + "' cannot be the name of a method");
    }
    if (find(name) != nullptr) {
      throw std::invalid_argument("there is a method '" + name + "' already");
    }
    const std::scoped_lock lock(mutex_);
    Added& added = added_.emplace_back();
    added.name = std::move(name);
    added.description = std::move(description);
    added.function = std::move(function);
    added.row.name = added.name;
    added.row.title = added.name;
    added.row.description = added.description;
    added.row.made = &added.function;
    return added.row;
  }

 private:
  struct Added {
    std::string name, description;
    Function function;
    Row row;
  };
  std::span<const Row* const> table_;
  mutable std::mutex mutex_;
  std::deque<Added> added_;  // never moves its elements
};

}  // namespace sixdial::calibration
