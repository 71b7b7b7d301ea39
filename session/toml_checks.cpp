#include "session/toml_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "session/traceability.h"

namespace sixdial::session {

void TomlChecks::fault(
    const toml::source_region& where, std::string field, std::string what, std::string hint) {
  mistakes_.push_back(
      {static_cast<int>(where.begin.line), static_cast<int>(where.begin.column),
       std::move(field), std::move(what), std::move(hint)});
}

void TomlChecks::stop_if_faulty() {
  std::sort(unknown_.begin(), unknown_.end(), [](const Mistake& a, const Mistake& b) {
    return std::pair(a.line, a.column) < std::pair(b.line, b.column);
  });
  mistakes_.insert(mistakes_.begin(), unknown_.begin(), unknown_.end());
  if (mistakes_.empty()) return;
  const std::size_t total = mistakes_.size();
  throw DataError(file_, std::move(mistakes_), total);
}

void TomlChecks::known_keys(
    const toml::table& from, const std::string& where, const std::vector<std::string>& known) {
  for (const auto& [key, node] : from) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const auto& place = key.source().begin;
    unknown_.push_back(
        {static_cast<int>(place.line), static_cast<int>(place.column), shown_key(name),
         "unknown key in " + where,
         fmt::format("the nearest known key is '{}'", nearest_word(name, known))});
  }
}

std::string TomlChecks::shown_key(const std::string& name) {
  return name.size() <= 60 ? name : name.substr(0, 57) + "...";
}

void TomlChecks::missing(
    const toml::table& from, const std::string& where, const std::string& key) {
  fault(
      from.source(), key, "missing in " + where,
      fmt::format("add it: every {} needs it", kind_));
}

const toml::table* TomlChecks::table(const toml::table& top, const std::string& key) {
  const toml::node* node = top.get(key);
  if (node == nullptr) {
    fault(
        {}, key, fmt::format("there is no [{}] table", key),
        fmt::format("every {} needs it", kind_));
    return nullptr;
  }
  if (!node->is_table()) {
    fault(node->source(), key, "is not a table", fmt::format("write [{}] on a line", key));
    return nullptr;
  }
  return node->as_table();
}

std::string TomlChecks::text(
    const toml::table& from, const std::string& where, const char* key,
    const std::string& otherwise) {
  const toml::node* node = from.get(key);
  if (node == nullptr) return otherwise;
  if (const auto value = node->value_exact<std::string>()) return *value;
  fault(
      node->source(), key,
      where.empty() ? "is not text" : fmt::format("is not text in {}", where),
      "write it in quotes");
  return otherwise;
}

std::optional<double> TomlChecks::finite(const toml::node& node, const std::string& key) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) {
    fault(node.source(), key, "is not a number", "write a number, without quotes");
    return std::nullopt;
  }
  if (!std::isfinite(*value)) {
    fault(node.source(), key, "is not finite", "write a finite number");
    return std::nullopt;
  }
  return value;
}

std::optional<double> TomlChecks::number(
    const toml::table& from, const std::string& where, const std::string& key) {
  const toml::node* node = from.get(key);
  if (node == nullptr) {
    missing(from, where, key);
    return std::nullopt;
  }
  return finite(*node, key);
}

void TomlChecks::length(
    const toml::table& from, const std::string& where, const std::string& key,
    bool zero_allowed, double& result) {
  const auto value = number(from, where, key);
  if (!value) return;
  if (*value < 0.0 || (*value == 0.0 && !zero_allowed)) {
    fault(
        from.get(key)->source(), key, fmt::format("{} makes no sense", *value),
        zero_allowed ? "it must not be negative" : "it must be greater than 0");
    return;
  }
  result = *value;
}

std::optional<Eigen::Vector2d> TomlChecks::pair(
    const toml::table& from, const std::string& where, const std::string& key) {
  const toml::node* node = from.get(key);
  if (node == nullptr) {
    missing(from, where, key);
    return std::nullopt;
  }
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() != 2) {
    fault(
        node->source(), key,
        array == nullptr ? "is not a pair of numbers"
                         : fmt::format("has {} numbers", array->size()),
        "write two numbers, such as [28.0, 48.0]");
    return std::nullopt;
  }
  const auto x = finite(*array->get(0), key);
  const auto y = finite(*array->get(1), key);
  if (!x || !y) return std::nullopt;
  return Eigen::Vector2d(*x, *y);
}

std::vector<std::string> traced(std::vector<std::string> keys) {
  keys.insert(keys.end(), kTraceKeys.begin(), kTraceKeys.end());
  return keys;
}

void TomlChecks::check_trace(const toml::table& from, const std::string& where) {
  static_cast<void>(text(from, where, "serial", ""));
  static_cast<void>(text(from, where, "certificate", ""));
  for (const char* key : {"certified", "due"}) {
    const toml::node* node = from.get(key);
    if (node == nullptr || node->is_date()) continue;
    if (is_date(node->value<std::string>().value_or(""))) continue;
    fault(node->source(), key, "is not a date", "write it as 2026-01-15");
  }
}

}  // namespace sixdial::session
