#include "report/export/export_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "report/export/holding.h"

namespace sixdial::report {

extern constinit const ExportFormat c_format, json_format, klipper_format, linuxcnc_format,
    python_format, ur_format, urdf_format;

namespace {

constexpr std::array kFormats{&c_format,      &json_format, &klipper_format, &linuxcnc_format,
                              &python_format, &ur_format,   &urdf_format};

}  // namespace

std::span<const ExportFormat* const> export_formats() { return kFormats; }

const ExportFormat* find_export_format(std::string_view name) {
  const auto* const found =
      std::ranges::find(kFormats, name, [](const ExportFormat* each) { return each->name; });
  return found == kFormats.end() ? nullptr : *found;
}

Exported export_model(
    const studies::ExportedModel& full, std::string_view name, const ExportOptions& options) {
  const ExportFormat* format = find_export_format(name);
  if (format == nullptr) {
    std::vector<std::string_view> known;
    for (const ExportFormat* each : kFormats) known.push_back(each->name);
    throw studies::StudyError(
        studies::StudyErrorCode::kInvalidParams, fmt::format("there is no format '{}'", name),
        {{"param", "as"}}, fmt::format("One of {}.", fmt::join(known, ", ")));
  }
  const auto belongs = [&](bool given, const ExportFormat& to, const char* param) {
    if (!given || format == &to) return;
    throw studies::StudyError(
        studies::StudyErrorCode::kInvalidParams,
        fmt::format("the format {} does not take {}", name, param), {{"param", param}},
        fmt::format("It belongs to the format {}.", to.name));
  };
  belongs(!options.endstops_mm.empty(), klipper_format, "endstops");
  belongs(!options.urdf_text.empty(), urdf_format, "urdf");
  HeldModel held = format->hold(full, options);
  Exported result{
      .format = std::string(format->name),
      .file_name = std::string(format->file_name),
      .model = std::string(studies::to_string(full.by)),
      .text = format->write(full, held, options)};
  result.miss = studies::miss_between(full, held.model);
  result.left_out = std::move(held.left_out);
  result.notes = std::move(held.notes);
  return result;
}

std::vector<std::string> left_out_lines(
    const std::vector<LeftOut>& left_out, const studies::MissBetween& miss) {
  std::vector<std::string> lines;
  for (const LeftOut& each : left_out) {
    lines.push_back(fmt::format(
        "Left out: {}{}{}{}: {}. That alone puts the tool {:.4f} mm off in the mean, {:.4f} mm "
        "at most, over {} poses of the session. {}",
        each.what, each.values.empty() ? "" : " (", fmt::join(each.values, ", "),
        each.values.empty() ? "" : ")", each.why, each.miss.mean_mm, each.miss.max_mm,
        each.miss.poses, each.instead));
  }
  if (left_out.empty()) lines.emplace_back("Nothing of the model is left out.");
  if (left_out.size() > 1 && miss.max_mm > 0.0) {
    lines.push_back(fmt::format(
        "All of it together: {:.4f} mm in the mean, {:.4f} mm at most.", miss.mean_mm,
        miss.max_mm));
  }
  return lines;
}

}  // namespace sixdial::report
