#include "report/export/source_code.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "report/export/holding.h"
#include "simulation/effect_in_code.h"

namespace sixdial::report {
namespace {

void replace_all(std::string& text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// Whether a statement uses a name: not as a part of another one.
bool uses(std::string_view line, std::string_view name) {
  const auto is_letter = [](char each) {
    return std::isalnum(static_cast<unsigned char>(each)) != 0 || each == '_';
  };
  for (std::size_t at = line.find(name); at != std::string_view::npos;
       at = line.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || !is_letter(line[at - 1])) && (end == line.size() || !is_letter(line[end])))
      return true;
  }
  return false;
}

/// One line for each axis or each growing parameter, where a statement says so.
std::vector<std::string> repeated(const std::string& line, const geometry::RobotModel& robot) {
  constexpr int kAxes = 3;
  std::vector<std::string> lines;
  const auto add = [&](std::string_view mark, std::size_t number) {
    lines.push_back(line);
    replace_all(lines.back(), mark, std::to_string(number));
  };
  if (line.find("{axis}") != std::string::npos) {
    for (int axis = 0; axis < kAxes; ++axis) add("{axis}", static_cast<std::size_t>(axis));
  } else if (line.find("{grows}") != std::string::npos) {
    for (std::size_t k = 0; k < robot.parameters.size(); ++k) {
      if (robot.parameters[k].grows) add("{grows}", k);
    }
  } else {
    lines.push_back(line);
  }
  return lines;
}

}  // namespace

EffectLines effect_lines(
    const simulation::ActiveEffect& effect, const geometry::RobotModel& robot,
    const std::string& curve, const std::function<std::string(std::size_t k)>& number) {
  const simulation::EffectInCode* row = simulation::find_effect_in_code(effect.effect->cause);
  if (row == nullptr) return {};
  const auto with_numbers = [&](std::string_view statements) {
    std::vector<std::string> lines;
    for (const std::string& statement : lines_of(statements)) {
      for (std::string& line : repeated(statement, robot)) {
        replace_all(line, "{joint}", std::to_string(effect.place.joint));
        replace_all(line, "{other}", std::to_string(effect.place.other_joint));
        replace_all(line, "{curve}", curve);
        for (std::size_t k = 0; !effect.effect->is_curve && k < effect.x.size(); ++k) {
          replace_all(line, fmt::format("{{{}}}", k), number(k));
        }
        lines.push_back(std::move(line));
      }
    }
    return lines;
  };
  const simulation::EffectStatements statements = row->at(effect.place);
  return {with_numbers(statements.joints), with_numbers(statements.tool)};
}

std::string filled(std::string_view text, const Marks& marks) {
  std::string result;
  for (std::string line : lines_of(text)) {
    const std::size_t first = line.find('@');
    if (first == std::string::npos) {
      result += line + '\n';
      continue;
    }
    if (first == 0 && line.size() > 1 && line.find('@', 1) == line.size() - 1) {
      const auto mark = marks.find(line.substr(1, line.size() - 2));
      if (mark == marks.end()) throw std::logic_error("a template has the mark " + line);
      result += mark->second;
      if (!mark->second.empty() && mark->second.back() != '\n') result += '\n';
      continue;
    }
    for (std::size_t at = first; at != std::string::npos;) {
      const std::size_t end = line.find('@', at + 1);
      const auto mark = end == std::string::npos
                            ? marks.end()
                            : marks.find(line.substr(at + 1, end - at - 1));
      if (mark == marks.end()) throw std::logic_error("a template has the mark " + line);
      line.replace(at, end - at + 1, mark->second);
      at = line.find('@', at + mark->second.size());
    }
    result += line + '\n';
  }
  return result;
}

std::string list_of(const SourceLanguage& language, std::span<const double> values) {
  std::vector<std::string> texts;
  for (const double each : values) texts.push_back(exactly(each));
  return fmt::format("{}{}{}", language.open, fmt::join(texts, ", "), language.close);
}

std::string frame_of(const SourceLanguage& language, const geometry::Pose<double>& pose) {
  std::vector<std::string> rows;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::array row{pose.R(i, 0), pose.R(i, 1), pose.R(i, 2)};
    const std::string text = list_of(language, row);
    rows.push_back(language.is_python ? text : text.substr(1, text.size() - 2));
  }
  return fmt::format(
      "{0}{0}{2}{1}, {3}{1}", language.open, language.close, fmt::join(rows, ", "),
      list_of(language, std::span(pose.p.data(), 3)));
}

HeldModel hold_source(const studies::ExportedModel& full, std::string_view in_words) {
  const KindSource* source = find_kind_source(full.robot().kind->name);
  if (source == nullptr) {
    throw studies::StudyError(
        studies::StudyErrorCode::kInvalidParams,
        fmt::format(
            "{} cannot hold this robot: its kind {} has no source text", in_words,
            full.robot().kind->name),
        {{"param", "as"}}, "The format json holds its numbers.");
  }
  Holding holding(full);
  holding.leave_out_effects(
      "it goes by forces that only the rig's dials make, or has no statements for a program",
      "`sixdial compensate` commands with it, and json has its numbers.",
      [&](const simulation::ActiveEffect& each) {
        return simulation::find_effect_in_code(each.effect->cause) != nullptr;
      });
  holding.leave_out_learned();
  return holding.done();
}

namespace {

/// The statements of all effects, with what they need declared before them.
struct Body {
  std::string before{}, after{}, curves{};
  bool with_weight = false;
};

/// Makes the body of `forward` line by line.
class BodyWriter {
 public:
  BodyWriter(
      const studies::ExportedModel& full, const SourceLanguage& language,
      const KindSource& kind)
      : full_(full), language_(language), kind_(kind) {}

  void add(const simulation::ActiveEffect& effect) {
    const bool to_come = effect.effect->is_step && full_.order + 1 < effect.x.back();
    if (to_come) return;
    const EffectLines lines =
        effect_lines(effect, full_.robot(), curve_of(effect), [&](std::size_t k) {
          const std::string number = exactly(effect.x[k]);
          return number.front() == '-' ? "(" + number + ")" : number;
        });
    const std::string words = words_of(effect);
    append(joints_, words, lines.joints);
    if (std::ranges::any_of(lines.tool, [](const auto& each) { return uses(each, "was"); })) {
      tool_.emplace_back(language_.keep_place);
    }
    append(tool_, words, lines.tool);
  }

  [[nodiscard]] Body done() const {
    Body body;
    const auto any_uses = [&](std::string_view name) {
      const auto one = [&](const std::string& line) { return uses(line, name); };
      return std::ranges::any_of(joints_, one) || std::ranges::any_of(tool_, one);
    };
    body.with_weight = any_uses("weight");
    const auto put = [&](std::string& text, std::string_view lines) {
      for (const std::string& line : lines_of(lines)) {
        text.append(language_.indent).append(line).append("\n");
      }
    };
    for (const DeclaredName& each : language_.names) {
      const bool needed = each.name == "v" ? kind_.has_parameters : any_uses(each.name);
      if (!needed) continue;
      std::string declaration(each.declaration);
      replace_all(declaration, "{stands}", stands());
      put(body.before, declaration);
    }
    for (const std::string& line : joints_) put(body.before, line);
    for (const std::string& line : tool_) put(body.after, line);
    if (any_uses("turn")) put(body.after, language_.turn_tool);
    body.curves = curves_;
    return body;
  }

 private:
  void append(
      std::vector<std::string>& to, const std::string& words,
      const std::vector<std::string>& lines) const {
    if (lines.empty()) return;
    const std::string comment = commented({words}, language_.is_python ? "# " : "/* ");
    to.push_back(comment.substr(0, comment.size() - 1) + (language_.is_python ? "" : " */"));
    for (const std::string& line : lines) to.push_back(line + std::string(language_.end));
  }
  /// The name of the curve's numbers, and how many there are.
  std::string curve_of(const simulation::ActiveEffect& effect) {
    if (!effect.effect->is_curve) return "";
    if (curves_.empty()) curves_ = language_.smooth;
    const std::string name =
        fmt::format("{}_{}", language_.is_python ? "CURVE" : "sixdial_curve", count_++);
    curves_ += fmt::format(
        "\n{}{}{} = {}{}\n", language_.is_python ? "" : "static const double ", name,
        language_.is_python ? "" : "[]", list_of(language_, effect.x), language_.end);
    return fmt::format("{}, {}", name, effect.x.size());
  }
  /// Where the base is, as the model has it.
  [[nodiscard]] std::string stands() const {
    std::array<double, 3> at{};
    std::size_t found = 0;
    const auto& parameters = full_.robot().parameters;
    for (std::size_t k = 0; k < parameters.size() && found < at.size(); ++k) {
      const bool place = parameters[k].stands && parameters[k].unit == "mm";
      if (place) at[found++] = full_.model[static_cast<Eigen::Index>(k)];
    }
    return list_of(language_, at);
  }

  const studies::ExportedModel& full_;
  const SourceLanguage& language_;
  const KindSource& kind_;
  std::vector<std::string> joints_, tool_;
  std::string curves_;
  int count_ = 0;
};

void fill_frame(
    const studies::ExportedModel& full, const SourceLanguage& language, bool has_parameters,
    Marks& marks) {
  constexpr int kPoseJoints = 6;
  const geometry::RobotModel& robot = full.robot();
  const bool solves_turn = robot.axes == 3 && robot.joint_count() >= kPoseJoints;
  std::vector<std::string> joints, assemblies, slides;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    joints.push_back(
        fmt::format("q[{}]: {} [{}]", i, robot.joints[i].name, robot.joints[i].unit()));
    slides.emplace_back(robot.joints[i].kind == geometry::JointKind::kPrismatic ? "1" : "0");
  }
  for (const geometry::BranchInfo& each : robot.assemblies) {
    assemblies.push_back(fmt::format("{}: {}", each.number, each.name));
  }
  marks["JOINTS"] = std::to_string(robot.joint_count());
  marks["JOINT_WORDS"] = commented(joints, language.mark);
  marks["ASSEMBLIES"] = fmt::format("{}", fmt::join(assemblies, ", "));
  marks["ASSEMBLY"] = std::to_string(static_cast<int>(full.base->rig().robot.assembly));
  marks["TEMPERATURE"] = exactly(full.temperature_degC);
  marks["TIME"] = exactly(full.time_h);
  marks["SLIDES"] = fmt::format("{}", fmt::join(slides, ", "));
  marks["PLACE_ROWS"] = std::to_string(robot.axes);
  marks["SOLVES_TURN"] = solves_turn ? "1" : "0";
  marks["TURN_WORDS"] = solves_turn ? (language.is_python ? "R None: turned as it comes."
                                                          : "R NULL: turned as it comes.")
                                    : "R is not looked at: its joints reach places alone.";
  marks["PARAMETERS"] = has_parameters ? std::string(language.parameters) : "";
}

}  // namespace

std::string write_source(
    const studies::ExportedModel& full, const HeldModel& held, std::string_view format,
    const SourceLanguage& language) {
  const KindSource& kind = *find_kind_source(full.robot().kind->name);
  BodyWriter writer(full, language, kind);
  for (const simulation::ActiveEffect& each : held.model.effects) writer.add(each);
  const Body body = writer.done();
  Marks marks;
  fill_frame(full, language, kind.has_parameters, marks);
  marks["HEADER"] = commented(heading(full, held, format), language.mark);
  if (language.is_python) marks["HEADER"].pop_back();  // the docstring's first line
  kind.fill(held.model, language, body.with_weight, marks);
  marks["KIND"] = filled(language.is_python ? kind.python() : kind.c(), marks);
  marks["CURVES"] = body.curves;
  marks["BEFORE"] = body.before;
  marks["AFTER"] = body.after;
  marks["SOLVE"] = filled(language.solve, marks);
  return filled(language.model, marks);
}

}  // namespace sixdial::report
