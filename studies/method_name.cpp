#include "studies/method_name.h"

#include <fmt/format.h>

#include "session/nearest.h"
#include "studies/error.h"

namespace sixdial::studies {

std::string method_name(std::string_view id) {
  if (id == "before") return "before calibration";
  const std::size_t plus = id.find('+');
  const std::string_view first = id.substr(0, plus);
  const calibration::Identifier* identifier = calibration::find_identifier(first);
  const std::string name(identifier != nullptr ? identifier->title : first);
  if (plus == std::string_view::npos) return name;
  const std::string_view second = id.substr(plus + 1);
  const calibration::ResidualModel* model = calibration::find_residual_model(second);
  return name + " + " + std::string(model != nullptr ? model->title : second);
}

std::string without_residual_model(std::string_view id) {
  return std::string(id.substr(0, id.find('+')));
}

calibration::MethodChoice chosen_method(const std::string& id, const std::string& param) {
  auto choice = calibration::method_choice(id);
  if (choice) return *std::move(choice);
  const calibration::UnknownMethod& unknown = choice.error();
  const auto nearest = session::nearest_name(unknown.word, unknown.known);
  const std::string shown = id.substr(0, 64);
  const std::string part = unknown.word.substr(0, 64);
  throw StudyError(
      StudyErrorCode::kInvalidParams,
      part == shown ? fmt::format("there is no method '{}'", shown)
                    : fmt::format("there is no '{}' for the method '{}'", part, shown),
      {{"param", param}},
      nearest ? fmt::format("The nearest known one is '{}'.", *nearest)
              : fmt::format("One of: {}.", fmt::join(unknown.known, ", ")));
}

}  // namespace sixdial::studies
