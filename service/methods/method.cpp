#include "service/methods/method.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "session/nearest.h"

namespace sixdial::service {
namespace {

std::vector<const RpcMethod*> collect_rows() {
  std::vector<const RpcMethod*> rows;
  for (const auto group :
       {service_methods(), session_methods(), plan_methods(), collect_methods(), job_methods(),
        result_methods(), compare_methods(), diagnosis_methods(), compensation_methods(),
        export_methods(), validation_methods(), rig_methods()}) {
    for (const RpcMethod& method : group) rows.push_back(&method);
  }
  std::ranges::sort(rows, {}, &RpcMethod::name);
  return rows;
}

bool has_type(const Json& value, ParamType type) {
  switch (type) {
    case ParamType::kString:
      return value.is_string();
    case ParamType::kInteger:
      return value.is_number_integer();
    case ParamType::kNumber:
      return value.is_number();
    case ParamType::kBoolean:
      return value.is_boolean();
    case ParamType::kStringList:
      return value.is_array() &&
             std::ranges::all_of(value, [](const Json& item) { return item.is_string(); });
    case ParamType::kObject:
      return value.is_object();
  }
  return false;
}

[[noreturn]] void refuse(const Param& param, const std::string& what, std::string hint = {}) {
  throw Error(
      ErrorCode::kInvalidParams, fmt::format("parameter '{}' {}", param.name, what),
      {{"param", param.name}}, std::move(hint));
}

void check_choice(const Param& param, const std::string& text) {
  if (param.one_of.empty() || std::ranges::find(param.one_of, text) != param.one_of.end()) {
    return;
  }
  refuse(
      param, fmt::format("cannot be '{}'", text.substr(0, 64)),
      fmt::format("One of: {}.", fmt::join(param.one_of, ", ")));
}

void check_value(const Param& param, const Json& value) {
  if (!has_type(value, param.type)) {
    refuse(param, fmt::format("must be {}, not {}", to_string(param.type), value.type_name()));
  }
  if (value.is_number()) {
    const auto number = value.get<double>();
    if (!(number >= param.min && number <= param.max)) {
      refuse(
          param, fmt::format("is {}", number),
          fmt::format("It must be from {} to {}.", param.min, param.max));
    }
  }
  if (value.is_string()) check_choice(param, value.get<std::string>());
  if (value.is_array()) {
    for (const Json& item : value) check_choice(param, item.get<std::string>());
  }
}

}  // namespace

std::string_view to_string(ParamType type) {
  switch (type) {
    case ParamType::kString:
      return "string";
    case ParamType::kInteger:
      return "integer";
    case ParamType::kNumber:
      return "number";
    case ParamType::kBoolean:
      return "boolean";
    case ParamType::kStringList:
      return "array of strings";
    case ParamType::kObject:
      return "object";
  }
  return "";
}

std::span<const RpcMethod* const> all_methods() {
  static const std::vector<const RpcMethod*> rows = collect_rows();
  return rows;
}

const RpcMethod& find_method(std::string_view name) {
  const auto rows = all_methods();
  const auto found = std::ranges::lower_bound(rows, name, {}, &RpcMethod::name);
  if (found != rows.end() && (*found)->name == name) return **found;
  std::vector<std::string_view> names;
  for (const RpcMethod* method : rows) names.push_back(method->name);
  const auto nearest = session::nearest_name(name, names);
  throw Error(
      ErrorCode::kUnknownMethod, fmt::format("there is no method '{}'", name.substr(0, 64)),
      {{"method", name.substr(0, 64)}},
      nearest ? fmt::format("Did you mean '{}'? rpc.discover lists all methods.", *nearest)
              : std::string{});
}

void check_params(const RpcMethod& method, const Json& params) {
  std::vector<std::string_view> names;
  for (const Param& param : method.params) names.push_back(param.name);
  for (const auto& [key, value] : params.items()) {
    const auto param = std::ranges::find(method.params, key, &Param::name);
    if (param == method.params.end()) {
      const auto nearest = session::nearest_name(key, names);
      throw Error(
          ErrorCode::kInvalidParams,
          fmt::format("{} has no parameter '{}'", method.name, key.substr(0, 64)),
          {{"param", key.substr(0, 64)}},
          nearest         ? fmt::format("The nearest known one is '{}'.", *nearest)
          : names.empty() ? std::string("It takes none.")
                          : fmt::format("It takes: {}.", fmt::join(names, ", ")));
    }
    if (value.is_null() && !param->required) continue;
    check_value(*param, value);
  }
  for (const Param& param : method.params) {
    if (param.required && !params.contains(param.name)) {
      refuse(
          param, fmt::format("of {} is missing", method.name),
          fmt::format("For example: {}", method.example));
    }
  }
}

Json params_schema(const RpcMethod& method) {
  Json properties = Json::object();
  Json required = Json::array();
  for (const Param& param : method.params) {
    Json schema{{"description", param.doc}};
    if (param.type == ParamType::kStringList) {
      schema["type"] = "array";
      schema["items"] = {{"type", "string"}};
      if (!param.one_of.empty()) schema["items"]["enum"] = param.one_of;
    } else {
      schema["type"] = to_string(param.type);
      if (!param.one_of.empty()) schema["enum"] = param.one_of;
    }
    if (std::isfinite(param.min)) schema["minimum"] = param.min;
    if (std::isfinite(param.max)) schema["maximum"] = param.max;
    properties[std::string(param.name)] = std::move(schema);
    if (param.required) required.push_back(param.name);
  }
  return {
      {"type", "object"},
      {"properties", std::move(properties)},
      {"required", std::move(required)},
      {"additionalProperties", false}};
}

}  // namespace sixdial::service
