// Reads TOML tables and remembers each thing that is wrong with its line and column, so that
// one message tells them all. For sources of session/ only: toml++ comes with it.
#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session/data_error.h"

namespace sixdial::session {

/// These keys, and those of what a part can be traced to.
[[nodiscard]] std::vector<std::string> traced(std::vector<std::string> keys);

class TomlChecks {
 protected:
  /// `kind`: what such a file is called in a message.
  explicit TomlChecks(std::string file_name, std::string kind = "rig file")
      : file_(std::move(file_name)), kind_(std::move(kind)) {}
  [[nodiscard]] const std::string& file() const { return file_; }

  void fault(
      const toml::source_region& where, std::string field, std::string what, std::string hint);
  void stop_if_faulty();
  void known_keys(
      const toml::table& from, const std::string& where, const std::vector<std::string>& known);
  static std::string shown_key(const std::string& name);
  void missing(const toml::table& from, const std::string& where, const std::string& key);
  [[nodiscard]] const toml::table* table(const toml::table& top, const std::string& key);
  /// Text of `key`; `otherwise` if it is absent.
  [[nodiscard]] std::string text(
      const toml::table& from, const std::string& where, const char* key,
      const std::string& otherwise);
  [[nodiscard]] std::optional<double> finite(const toml::node& node, const std::string& key);
  [[nodiscard]] std::optional<double> number(
      const toml::table& from, const std::string& where, const std::string& key);
  /// A length that must be > 0, or >= 0.
  void length(
      const toml::table& from, const std::string& where, const std::string& key,
      bool zero_allowed, double& result);
  /// A part's serial number and certificate are text, their dates are dates (traceability.h).
  void check_trace(const toml::table& from, const std::string& where);
  [[nodiscard]] std::optional<Eigen::Vector2d> pair(
      const toml::table& from, const std::string& where, const std::string& key);

 private:
  std::string file_, kind_;
  std::vector<Mistake> mistakes_;
  std::vector<Mistake> unknown_;  // told first: a key that is missing may be one misspelt
};

}  // namespace sixdial::session
