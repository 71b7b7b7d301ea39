#include "report/export/holding.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "simulation/effect_in_code.h"

namespace sixdial::report {
namespace {

/// Without what would break a line or end a comment of C, Python or XML.
std::string harmless(std::string_view line, bool xml) {
  std::string result;
  for (const char each : line) {
    const bool control = static_cast<unsigned char>(each) < 0x20 || each == 0x7f;
    const char last = result.empty() ? ' ' : result.back();
    const bool ends = (last == '*' && each == '/') || (xml && last == '-' && each == '-') ||
                      (last == '"' && each == '"') || each == '\\';
    if (ends) result += ' ';
    result += control || each == '\\' ? ' ' : each;
  }
  return result;
}

}  // namespace

void Holding::leave_out(LeftOut item, const Change& change) {
  studies::ExportedModel without = full_;
  change(without);
  item.miss = studies::miss_between(full_, without);
  change(held_.model);
  held_.left_out.push_back(std::move(item));
}

void Holding::leave_nominal(
    LeftOut item, const std::function<bool(const geometry::ParameterInfo&)>& which) {
  const auto& parameters = full_.robot().parameters;
  std::vector<Eigen::Index> changed;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (!which(parameters[k]) || full_.model[at] == full_.nominal[at]) continue;
    changed.push_back(at);
    item.values.push_back(fmt::format(
        "{} = {:.6f} {}", parameters[k].name, full_.model[at] * parameters[k].shown_per_unit,
        parameters[k].shown_unit));
  }
  if (changed.empty()) return;
  item.why += "; what the rig file has is taken for it";
  leave_out(std::move(item), [&](studies::ExportedModel& model) {
    for (const Eigen::Index at : changed) model.model[at] = model.nominal[at];
  });
}

void Holding::leave_out_effects(
    std::string_view why, std::string_view instead,
    const std::function<bool(const simulation::ActiveEffect&)>& holds) {
  for (const simulation::ActiveEffect& each : full_.effects) {
    if (!acts_on_robot(each)) {
      note(words_of(each) + " is of what measures: no part of a robot's model");
      continue;
    }
    if (holds(each)) continue;
    leave_out(
        {.what = words_of(each),
         .why = std::string(why),
         .instead = std::string(instead),
         .values = sizes_of(each)},
        [&each](studies::ExportedModel& model) {
          std::erase_if(model.effects, [&](const simulation::ActiveEffect& other) {
            return other.effect == each.effect && other.place.name == each.place.name;
          });
        });
  }
}

void Holding::leave_out_learned() {
  if (!full_.learned) return;
  LeftOut item{
      .what = fmt::format("what {} learned of the rest", full_.learned_by),
      .why = "it is a network or a process, and no part of the robot's model",
      .instead =
          "`sixdial compensate` commands with it (full, extended_full); the format json holds "
          "its numbers."};
  item.miss = studies::learned_part(full_);
  held_.model.learned = nullptr;
  held_.left_out.push_back(std::move(item));
}

bool is_settled_shift(
    const simulation::ActiveEffect& effect, const studies::ExportedModel& model) {
  return effect.effect->is_step && effect.place.joint >= 0 && !effect.x.empty() &&
         model.order + 1 >= effect.x.back();
}

bool acts_on_robot(const simulation::ActiveEffect& effect) {
  const simulation::EffectInCode* row = simulation::find_effect_in_code(effect.effect->cause);
  if (row == nullptr) return simulation::moves_the_robot(*effect.effect);
  const simulation::EffectStatements statements = row->at(effect.place);
  return !statements.joints.empty() || !statements.tool.empty();
}

void refuse_robot(
    const studies::ExportedModel& model, std::string_view format, const std::string& why) {
  throw studies::StudyError(
      studies::StudyErrorCode::kInvalidParams,
      fmt::format(
          "{} cannot hold this robot ({}): {}", format, model.robot().kind->in_words, why),
      {{"param", "as"}, {"session", model.inputs.session}},
      "The formats c, python and json hold every kind of robot that the program brings with "
      "it.");
}

std::vector<std::string> heading(
    const studies::ExportedModel& full, const HeldModel& held, std::string_view format) {
  const bool extended = full.by == studies::CompensateBy::kExtended;
  std::vector<std::string> lines{
      fmt::format(
          "{}: {}{}.", full.base->rig().name.empty() ? "A robot" : full.base->rig().name,
          full.robot().kind->in_words,
          extended ? ", extended by the causes that were named" : ", as it was calibrated"),
      fmt::format(
          "Written by Sixdial {} (export-model, {}) from the session {}, {} of {}.",
          SIXDIAL_VERSION, format, full.inputs.session, extended ? "diagnosis" : "calibration",
          full.created_utc),
      fmt::format("Data {}, rig {}.", full.inputs.data_hash, full.inputs.rig_hash)};
  if (full.frame) {
    lines.emplace_back(
        "Its frame is that of the instrument, not that of the rig file; json has what brings "
        "one into the other.");
  }
  for (const simulation::ActiveEffect& each : held.model.effects) {
    if (!acts_on_robot(each)) continue;
    lines.push_back(fmt::format(
        "Holds {} ({}){}.", words_of(each), fmt::join(sizes_of(each), ", "),
        each.effect->is_step ? ", as it is since then" : ""));
  }
  for (const std::string& note : held.notes) lines.push_back(note + ".");
  const auto left = left_out_lines(held.left_out, studies::miss_between(full, held.model));
  lines.insert(lines.end(), left.begin(), left.end());
  return lines;
}

std::string commented(const std::vector<std::string>& lines, std::string_view mark, bool xml) {
  std::string text;
  for (const std::string& line : lines) {
    text.append(mark).append(harmless(line, xml)).append("\n");
  }
  return text;
}

std::string exactly(double value) {
  std::string text = fmt::format("{}", value + 0.0);  // no -0.0
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string exactly(const Eigen::Vector3d& value, std::string_view between) {
  return exactly(value[0])
      .append(between)
      .append(exactly(value[1]))
      .append(between)
      .append(exactly(value[2]));
}

std::vector<std::string> sizes_of(const simulation::ActiveEffect& effect) {
  std::vector<std::string> sizes;
  if (effect.effect->is_curve) {
    return {fmt::format("a curve of {} numbers", effect.x.size())};
  }
  for (std::size_t k = 0; k < effect.x.size(); ++k) {
    const auto info =
        simulation::parameter_at(*effect.effect, effect.place, static_cast<int>(k));
    if (!info) continue;
    const std::string unit = info->unit == "1" ? "" : " " + std::string(info->unit);
    sizes.push_back(fmt::format("{} = {}{}", info->name, exactly(effect.x[k]), unit));
  }
  return sizes;
}

std::string words_of(const simulation::ActiveEffect& effect) {
  return simulation::in_words_at(*effect.effect, effect.place.name);
}

}  // namespace sixdial::report
