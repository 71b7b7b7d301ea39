// One description of a result's keys that both writes it as JSON and reads it back:
//
//   // studies::Noise {double sigma_mm; std::optional<int> repeats;}
//   template <class Fields>
//   void describe_keys(Fields& at, Of<Fields, studies::Noise>& noise) {
//     at("sigma_mm", noise.sigma_mm);
//     at("repeats", noise.repeats);
//   }
//   const Json json = write(noise);
//   const auto again = read<studies::Noise>(json, "sixdial.diagnosis");
//
// `describe_keys` stands in namespace sixdial::report (not in an unnamed one: it is found by
// the type of its first argument) and may use `describe_keys` of the members' types. What a
// member may be: bool, whole numbers, double, string, an enum by names(), optional, vector,
// array, pair, a map or a list of pairs by text, Eigen vectors and matrices (rows), Json, and
// any type that has a `describe_keys`.
//
// A number that is not finite and an empty optional are null in JSON; null is read as NaN.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "report/documents/json.h"
#include "studies/error.h"

namespace sixdial::report {

/// What `describe_keys` gets: the value itself to read into it, a constant one to write it.
template <class Fields, class T>
using Of = std::conditional_t<Fields::kReads, T, const T>;

class Writer {
 public:
  static constexpr bool kReads = false;
  explicit Writer(Json& to) : to_(to) {
    if (to_.is_null()) to_ = Json::object();
  }
  /// A key that is always there.
  template <class T>
  void operator()(const char* key, const T& value);
  /// A key that documents of other makes or earlier versions do not have: left out where
  /// empty.
  template <class T>
  void maybe(const char* key, const std::optional<T>& value) {
    if (value) (*this)(key, *value);
  }
  /// Whether a document that is read has this key; what is written has it.
  [[nodiscard]] bool has(const char*) const { return true; }
  /// An enum by its name.
  template <class Enum, class ToText, class FromText>
  void named(const char* key, const Enum& value, ToText to_text, FromText) {
    to_[key] = std::string(to_text(value));
  }
  /// A word that is always the same, "sixdial.calibration".
  void constant(const char* key, std::string_view text) { to_[key] = text; }
  /// Keys of an inner object whose values are members of the same struct.
  template <class Inside>
  void inner(const char* key, Inside inside) {
    Json& json = to_[key];
    Writer writer(json);
    inside(writer);
  }

 private:
  Json& to_;
};

/// Where in a document a reader stands, for the message of an error.
struct DocumentPlace {
  const DocumentPlace* in = nullptr;
  std::string_view key;
  std::size_t index = 0;  // of a list, where key is empty
  [[nodiscard]] std::string words() const {
    if (in == nullptr) return "";
    const std::string outer = in->words();
    if (key.empty()) return fmt::format("{}[{}]", outer, index);
    return outer.empty() ? std::string(key) : fmt::format("{}.{}", outer, key);
  }
};

[[noreturn]] inline void refuse_document(
    std::string_view document, const DocumentPlace& at, std::string_view trouble) {
  throw studies::StudyError(
      studies::StudyErrorCode::kBadData,
      fmt::format("this {} document cannot be read: {} {}", document, at.words(), trouble), {},
      "Make the result again with this version.");
}

class Reader {
 public:
  static constexpr bool kReads = true;
  Reader(const Json& from, std::string_view document, const DocumentPlace& at)
      : from_(from), document_(document), at_(at) {
    if (!from.is_object()) refuse_document(document, at, "is not an object");
  }
  template <class T>
  void operator()(const char* key, T& value);
  template <class T>
  void maybe(const char* key, std::optional<T>& value) {
    value.reset();
    if (from_.contains(key)) (*this)(key, value.emplace());
  }
  [[nodiscard]] bool has(const char* key) const { return from_.contains(key); }
  template <class Enum, class ToText, class FromText>
  void named(const char* key, Enum& value, ToText, FromText from_text) {
    std::string text;
    (*this)(key, text);
    const auto found = from_text(text);
    if (!found) {
      refuse_document(document_, {&at_, key, 0}, fmt::format("is \"{}\", unknown here", text));
    }
    value = *found;
  }
  void constant(const char* key, std::string_view text) {
    std::string found;
    (*this)(key, found);
    if (found != text) {
      refuse_document(
          document_, {&at_, key, 0}, fmt::format("is \"{}\", not \"{}\"", found, text));
    }
  }
  template <class Inside>
  void inner(const char* key, Inside inside) {
    const DocumentPlace there{&at_, key, 0};
    Reader reader(entry(key, there), document_, there);
    inside(reader);
  }

 private:
  const Json& entry(const char* key, const DocumentPlace& there) const {
    const auto found = from_.find(key);
    if (found == from_.end()) refuse_document(document_, there, "is missing");
    return *found;
  }
  const Json& from_;
  std::string_view document_;
  const DocumentPlace& at_;
};

namespace fields {

template <class T>
inline constexpr bool kIsOptional = false;
template <class T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <class T>
inline constexpr bool kIsList = false;
template <class T>
inline constexpr bool kIsList<std::vector<T>> = true;
template <class T>
inline constexpr bool kIsFixedList = false;
template <class T, std::size_t N>
inline constexpr bool kIsFixedList<std::array<T, N>> = true;
/// A list of pairs keeps the order of the document, a map sorts by key.
template <class T>
inline constexpr bool kIsByText = false;
template <class T>
inline constexpr bool kIsByText<std::map<std::string, T>> = true;
template <class T>
inline constexpr bool kIsByText<std::vector<std::pair<std::string, T>>> = true;
template <class T>
concept Matrix = std::derived_from<T, Eigen::MatrixBase<T>>;

}  // namespace fields

template <class T>
[[nodiscard]] Json write(const T& value) {
  using namespace fields;
  if constexpr (std::is_same_v<T, Json>) {
    return value;
  } else if constexpr (std::floating_point<T>) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
  } else if constexpr (std::integral<T> || std::convertible_to<T, std::string_view>) {
    return Json(value);
  } else if constexpr (kIsOptional<T>) {
    return value ? write(*value) : Json(nullptr);
  } else if constexpr (kIsByText<T>) {
    Json json = Json::object();
    for (const auto& [key, each] : value) json[key] = write(each);
    return json;
  } else if constexpr (kIsList<T> || kIsFixedList<T>) {
    Json json = Json::array();
    for (const typename T::value_type& each : value) json.push_back(write(each));
    return json;
  } else if constexpr (Matrix<T>) {
    Json json = Json::array();
    for (Eigen::Index i = 0; i < value.rows(); ++i) {
      if constexpr (T::IsVectorAtCompileTime) {
        for (Eigen::Index k = 0; k < value.cols(); ++k) json.push_back(write(value(i, k)));
      } else {
        Json row = Json::array();
        for (Eigen::Index k = 0; k < value.cols(); ++k) row.push_back(write(value(i, k)));
        json.push_back(std::move(row));
      }
    }
    return json;
  } else {
    Json json = Json::object();
    Writer writer(json);
    describe_keys(writer, value);
    return json;
  }
}

/// Throws studies::StudyError kBadData that names the key and what is wrong with it.
template <class T>
void read_into(T& value, const Json& json, std::string_view document, const DocumentPlace& at) {
  using namespace fields;
  const auto list = [&](std::optional<std::size_t> size) {
    if (!json.is_array()) refuse_document(document, at, "is not a list");
    if (size && json.size() != *size) {
      refuse_document(
          document, at, fmt::format("has {} entries instead of {}", json.size(), *size));
    }
  };
  if constexpr (std::is_same_v<T, Json>) {
    value = json;
  } else if constexpr (std::is_same_v<T, bool>) {
    if (!json.is_boolean()) refuse_document(document, at, "is not true or false");
    value = json.get<bool>();
  } else if constexpr (std::integral<T>) {
    if (!json.is_number_integer()) refuse_document(document, at, "is not a whole number");
    value = json.get<T>();
  } else if constexpr (std::floating_point<T>) {
    if (json.is_null()) {
      value = std::numeric_limits<T>::quiet_NaN();
    } else if (json.is_number()) {
      value = json.get<T>();
    } else {
      refuse_document(document, at, "is not a number");
    }
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (!json.is_string()) refuse_document(document, at, "is not a text");
    value = json.get<std::string>();
  } else if constexpr (kIsOptional<T>) {
    value.reset();
    if (!json.is_null()) read_into(value.emplace(), json, document, at);
  } else if constexpr (kIsByText<T>) {
    if (!json.is_object()) refuse_document(document, at, "is not an object");
    value.clear();
    for (const auto& [key, each] : json.items()) {
      typename T::value_type::second_type one{};
      read_into(one, each, document, DocumentPlace{&at, key, 0});
      value.insert(value.end(), {key, std::move(one)});
    }
  } else if constexpr (kIsList<T> || kIsFixedList<T>) {
    if constexpr (kIsFixedList<T>) {
      list(value.size());
    } else {
      list(std::nullopt);
      value.assign(json.size(), typename T::value_type{});
    }
    for (std::size_t i = 0; i < value.size(); ++i) {
      typename T::value_type one{};
      read_into(one, json[i], document, DocumentPlace{&at, {}, i});
      value[i] = std::move(one);
    }
  } else if constexpr (fields::Matrix<T>) {
    constexpr bool kVector = T::IsVectorAtCompileTime;
    constexpr auto kFixed = static_cast<int>(T::SizeAtCompileTime);
    if constexpr (kVector) {
      list(kFixed == Eigen::Dynamic ? std::nullopt : std::optional<std::size_t>(kFixed));
      std::vector<double> flat;
      read_into(flat, json, document, at);
      value = Eigen::Map<const T>(
          flat.data(), kFixed == Eigen::Dynamic ? std::ssize(flat) : kFixed);
    } else {
      std::vector<std::vector<double>> rows;
      read_into(rows, json, document, at);
      const std::size_t columns = rows.empty() ? 0 : rows.front().size();
      value.resize(std::ssize(rows), static_cast<Eigen::Index>(columns));
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].size() != columns)
          refuse_document(document, at, "has rows of unequal length");
        for (std::size_t k = 0; k < columns; ++k) {
          value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
        }
      }
    }
  } else {
    Reader reader(json, document, at);
    describe_keys(reader, value);
  }
}

template <class T>
[[nodiscard]] T read(const Json& json, std::string_view document) {
  T value{};
  const DocumentPlace top;
  read_into(value, json, document, top);
  return value;
}

template <class T>
void Writer::operator()(const char* key, const T& value) {
  to_[key] = write(value);
}

template <class T>
void Reader::operator()(const char* key, T& value) {
  const DocumentPlace there{&at_, key, 0};
  read_into(value, entry(key, there), document_, there);
}

/// A value that has two states, by a word for each.
template <class Fields, class Value>
void one_of_two(
    Fields& at, const char* key, Value& value, std::remove_cv_t<Value> first, const char* word,
    std::remove_cv_t<Value> second, const char* other) {
  using Plain = std::remove_cv_t<Value>;
  at.named(
      key, value, [=](const Plain& each) { return each == first ? word : other; },
      [=](std::string_view text) -> std::optional<Plain> {
        if (text == word) return first;
        if (text == other) return second;
        return std::nullopt;
      });
}

/// Refuses a document of another schema or a version that is not `least` to `most`.
inline void expect_schema(
    const Json& json, std::string_view schema, int least, int most,
    std::string_view hint = "Make the result again with this version.") {
  const auto text = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_string()
               ? json[key].get<std::string>()
               : std::string("nothing known");
  };
  const int version = json.is_object() && json.contains("schema_version") &&
                              json["schema_version"].is_number_integer()
                          ? json["schema_version"].get<int>()
                          : 0;
  if (text("schema") == schema && version >= least && version <= most) return;
  throw studies::StudyError(
      studies::StudyErrorCode::kBadData,
      fmt::format(
          "a {} document of version {} is needed, this is {} {}", schema,
          least == most ? fmt::format("{}", most) : fmt::format("{} to {}", least, most),
          text("schema"), version),
      {}, std::string(hint));
}

}  // namespace sixdial::report
