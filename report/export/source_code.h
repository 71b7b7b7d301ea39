// A model as source text of a language: the robot by its kind's template, its effects as
// statements around it (simulation/effect_in_code.h), and an inverse by steps. C and Python
// differ in how they write lists, frames and declarations; that is what a SourceLanguage says.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/pose.h"
#include "report/export/export_format.h"

namespace sixdial::report {

/// What a template's marks stand for: "BASE" for @BASE@.
using Marks = std::map<std::string, std::string, std::less<>>;

/// A name that statements use and what has to stand before them.
struct DeclaredName {
  std::string_view name, declaration;
};

struct SourceLanguage {
  bool is_python = false;
  char open = '{', close = '}';    // of a list
  std::string_view end = ";";      // of a statement
  std::string_view indent = "  ";  // of the body of a function
  std::string_view mark = " * ";   // before each line of the text's heading
  std::string_view model{}, solve{}, smooth{};
  std::string_view parameters{};  // what a robot with parameters of its own is called with
  std::string_view keep_place{};  // copies p to `was`
  std::string_view turn_tool{};   // turns the tool's frame by `turn`
  std::span<const DeclaredName> names{};
};

/// A kind of robot that can be written.
struct KindSource {
  std::string_view kind;
  std::string_view (*c)() = nullptr;
  std::string_view (*python)() = nullptr;
  bool has_parameters = false;  // that effects change
  void (*fill)(
      const studies::ExportedModel& model, const SourceLanguage& language, bool with_weight,
      Marks& marks) = nullptr;
};
/// Null: no source of this kind can be written.
[[nodiscard]] const KindSource* find_kind_source(std::string_view kind);

/// The template with its marks filled. A line that is a mark alone goes where it is empty.
[[nodiscard]] std::string filled(std::string_view text, const Marks& marks);

[[nodiscard]] std::string list_of(
    const SourceLanguage& language, std::span<const double> values);
[[nodiscard]] std::string frame_of(
    const SourceLanguage& language, const geometry::Pose<double>& pose);

[[nodiscard]] HeldModel hold_source(
    const studies::ExportedModel& full, std::string_view format_in_words);
[[nodiscard]] std::string write_source(
    const studies::ExportedModel& full, const HeldModel& held, std::string_view format,
    const SourceLanguage& language);

/// The lines of an effect with its place and numbers in them. `curve`: what stands for all its
/// numbers; `number` says how number k is written.
struct EffectLines {
  std::vector<std::string> joints{}, tool{};
};
[[nodiscard]] EffectLines effect_lines(
    const simulation::ActiveEffect& effect, const geometry::RobotModel& robot,
    const std::string& curve, const std::function<std::string(std::size_t k)>& number);

}  // namespace sixdial::report
