#include "session/import_joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "session/csv.h"

namespace sixdial::session {
namespace {

using What = NameRole::What;
constexpr double kMostMetresOfJoint = 5.0;  // a slide beyond it is given in millimetres

/// Columns of one spelling ("joint # pos"), by which joint each says it is.
struct Spelling {
  std::string stem;
  bool certain = false;
  std::vector<const SeenColumn*> columns;
  [[nodiscard]] int least() const {
    int least = 99;
    for (const SeenColumn* each : columns)
      least = std::min(least, each->role.number.value_or(99));
    return least;
  }
};

class JointGuesser {
 public:
  JointGuesser(const std::vector<SeenColumn>& seen, const SampleLayout* layout, Guess& guess)
      : seen_(seen), layout_(layout), guess_(guess) {}

  void guess() {
    std::map<std::size_t, const SeenColumn*> stood = joints(false);
    std::map<std::size_t, const SeenColumn*> commanded = joints(true);
    if (stood.empty() && !commanded.empty()) {
      std::swap(stood, commanded);
      guess_.open.emplace_back(
          "only commanded values of the joints are in the file: they are taken for where the "
          "joints stood");
    }
    leave_other_kinds(stood);
    leave_other_kinds(commanded);
    take(stood, false);
    leave_part_of_commands(stood, commanded);
    take(commanded, true);
  }

 private:
  using ByJoint = std::map<std::size_t, const SeenColumn*>;

  void leave_other_kinds(ByJoint& at) {
    std::erase_if(at, [&](const auto& one) {
      const auto& [joint, each] = one;
      const bool length = slides(joint, *each);
      if (each->unit == nullptr || each->is_in(length ? UnitKind::kLength : UnitKind::kAngle)) {
        return false;
      }
      guess_.left_out.emplace(
          each->column, fmt::format(
                            "{}, but joint {} of the rig {}", each->unit_from, joint + 1,
                            length ? "slides" : "turns"));
      return true;
    });
  }

  /// A session has commands of all its joints, or of none.
  void leave_part_of_commands(const ByJoint& stood, ByJoint& commanded) {
    const std::size_t joints = layout_ == nullptr ? stood.size() : layout_->joints.size();
    const auto both = static_cast<std::size_t>(std::ranges::count_if(
        commanded, [&](const auto& one) { return stood.contains(one.first); }));
    if (both == joints && commanded.size() == joints) return;
    for (const auto& [joint, each] : commanded) {
      guess_.left_out.emplace(
          each->column, fmt::format(
                            "commands of {} of {} joints, beside where they stood: a session "
                            "has them of all joints, or of none",
                            both, joints));
    }
    commanded.clear();
  }

  [[nodiscard]] bool is_used(const SeenColumn& each) const {
    return std::ranges::find(guess_.columns, each.column, &GuessedColumn::column) !=
               guess_.columns.end() ||
           guess_.left_out.contains(each.column);
  }

  /// The joint whose own name in the rig file the column has.
  [[nodiscard]] std::optional<std::size_t> by_own_name(const SeenColumn& each) const {
    if (layout_ == nullptr) return std::nullopt;
    // A slide called "x" is told from the measured x only where both are there.
    const auto same_place = std::ranges::count_if(seen_, [&](const SeenColumn& other) {
      return other.role.what == each.role.what && other.role.key == each.role.key;
    });
    if (each.role.what == What::kPlace && same_place < 2) return std::nullopt;
    const auto words = words_of(unit_in_name(each.name).base);
    for (std::size_t i = 0; i < layout_->joints.size(); ++i) {
      auto own = words_of(layout_->joints[i].name);
      if (words == own) return i;
      own.emplace_back("command");
      if (words == own) return i;
    }
    return std::nullopt;
  }

  std::map<std::size_t, const SeenColumn*> joints(bool commanded) {
    std::map<std::size_t, const SeenColumn*> at;
    std::vector<const SeenColumn*> rest;
    for (const SeenColumn& each : seen_) {
      if (is_used(each) || each.role.commanded != commanded || each.values.numbers == 0)
        continue;
      const auto joint = by_own_name(each);
      const bool may_be =
          each.unit == nullptr || each.is_in(UnitKind::kAngle) || each.is_in(UnitKind::kLength);
      if (!may_be && (joint || each.role.what == What::kJoint)) {
        guess_.left_out.emplace(each.column, each.unit_from + ", which is no unit of a joint");
        continue;
      }
      if (joint && at.emplace(*joint, &each).second) continue;
      if (each.role.what == What::kJoint) rest.push_back(&each);
    }
    if (layout_ != nullptr && at.size() == layout_->joints.size()) {
      for (const SeenColumn* each : rest) {
        guess_.left_out.emplace(each->column, "every joint is given by its own name already");
      }
      return at;
    }
    const bool unnumbered = std::ranges::any_of(
        rest, [](const SeenColumn* each) { return !each->role.number.has_value(); });
    if (unnumbered && at.empty()) {
      in_order(rest, at);
    } else {
      numbered(rest, at);
    }
    return at;
  }

  /// "shoulder_pan_joint, elbow_joint, wrist_1_joint": nothing but their order tells them.
  void in_order(
      const std::vector<const SeenColumn*>& all, std::map<std::size_t, const SeenColumn*>& at) {
    std::vector<const SeenColumn*> certain;
    std::ranges::copy_if(all, std::back_inserter(certain), [](const SeenColumn* each) {
      return each->role.certain;
    });
    if (layout_ != nullptr && certain.size() != layout_->joints.size()) {
      guess_.open.push_back(fmt::format(
          "{} columns speak of joints without numbering them, the rig has {} joints: say which "
          "is which",
          certain.size(), layout_->joints.size()));
      for (const SeenColumn* each : certain) {
        guess_.left_out.emplace(each->column, "a joint, but nothing says which");
      }
      return;
    }
    for (const SeenColumn* each : certain) at.emplace(at.size(), each);
    guess_.open.emplace_back(
        "names do not number the joints: they are taken in the order of the file");
  }

  void numbered(
      const std::vector<const SeenColumn*>& all, std::map<std::size_t, const SeenColumn*>& at) {
    std::vector<Spelling> spellings;
    for (const SeenColumn* each : all) {
      if (!each->role.number) continue;
      auto found = std::ranges::find(spellings, each->role.stem, &Spelling::stem);
      if (found == spellings.end()) {
        spellings.push_back({each->role.stem, each->role.certain, {}});
        found = std::prev(spellings.end());
      }
      found->columns.push_back(each);
    }
    std::ranges::stable_sort(spellings, [](const Spelling& a, const Spelling& b) {
      return std::pair(a.certain, a.columns.size()) > std::pair(b.certain, b.columns.size());
    });
    for (const Spelling& spelling : spellings) {
      // "A1" alone, beside nothing else that is a joint, may be anything.
      if (!spelling.certain && at.empty() && spelling.columns.size() < 2) continue;
      const bool from_zero = spelling.least() == 0;
      if (from_zero) {
        guess_.open.push_back(fmt::format(
            "joints {} are counted from 0: {} is joint 1", shown(spelling.stem),
            shown(spelling.columns.front()->name)));
      }
      for (const SeenColumn* each : spelling.columns) place(*each, from_zero, at);
    }
  }

  void place(
      const SeenColumn& each, bool from_zero, std::map<std::size_t, const SeenColumn*>& at) {
    const int number = *each.role.number + (from_zero ? 1 : 0);
    const auto joint = static_cast<std::size_t>(number - 1);
    if (layout_ != nullptr && joint >= layout_->joints.size()) {
      guess_.left_out.emplace(
          each.column, fmt::format("the rig has {} joints", layout_->joints.size()));
      return;
    }
    const auto [taken, is_new] = at.emplace(joint, &each);
    if (is_new) return;
    guess_.left_out.emplace(
        each.column,
        fmt::format("joint {} is taken from {}", number, shown(taken->second->name)));
    guess_.open.push_back(fmt::format(
        "{} and {} may both be joint {}: the first was taken", shown(taken->second->name),
        shown(each.name), number));
  }

  void take(const std::map<std::size_t, const SeenColumn*>& at, bool commanded) {
    double angles = 0.0;
    double lengths = 0.0;
    for (const auto& [joint, each] : at) {
      if (each->unit != nullptr) continue;
      double& most = slides(joint, *each) ? lengths : angles;
      most = std::max(most, each->values.most());
    }
    bool radians = false;
    bool metres = false;
    for (const auto& [joint, each] : at) {
      const bool length = slides(joint, *each);
      std::string to = joint_target(layout_, joint, commanded).to;
      if (length) to = to.substr(0, to.rfind('_')) + "_mm";
      AngleUnit unit = length ? length_unit(*each, lengths) : angle_unit(*each, angles);
      radians = radians || (!length && unit.guessed_radians);
      metres = metres || (length && each->unit == nullptr && lengths < kMostMetresOfJoint);
      guess_.columns.push_back(
          {.column = each->column,
           .to = std::move(to),
           .unit = std::move(unit.name),
           .why = fmt::format(
               "its name speaks of joint {}{}; {}", joint + 1, commanded ? ", commanded" : "",
               unit.why)});
    }
    if (radians) guess_.open.push_back(radians_or_degrees("joint values", angles));
    if (!metres) return;
    guess_.open.push_back(fmt::format(
        "sliding joints up to {:.4g}: no unit is in the file; they are taken as metres, and "
        "could be millimetres: look at unit",
        lengths));
  }

  [[nodiscard]] bool slides(std::size_t joint, const SeenColumn& each) const {
    if (layout_ != nullptr) return layout_->joints[joint].unit == "mm";
    return each.unit != nullptr && each.unit->kind == UnitKind::kLength;
  }

  static AngleUnit length_unit(const SeenColumn& each, double most) {
    if (each.unit != nullptr) return {std::string(each.unit->name), each.unit_from};
    const bool metres = most < kMostMetresOfJoint;
    return {
        metres ? "m" : "mm",
        fmt::format("values up to {:.4g} are {}", most, metres ? "metres" : "millimetres")};
  }

  const std::vector<SeenColumn>& seen_;
  const SampleLayout* layout_;
  Guess& guess_;
};

}  // namespace

JointTarget joint_target(const SampleLayout* layout, std::size_t joint, bool commanded) {
  if (layout == nullptr) {
    return {fmt::format("q{}{}_rad", joint + 1, commanded ? "_command" : ""), "rad"};
  }
  const Joint& own = layout->joints[joint];
  if (commanded) return {own.command_column(), own.unit};
  const std::string name = own.known_by_name_only ? own.name : fmt::format("q{}", joint + 1);
  return {name + '_' + own.unit, own.unit};
}

void guess_joints(
    const std::vector<SeenColumn>& seen, const SampleLayout* layout, Guess& guess) {
  JointGuesser(seen, layout, guess).guess();
}

}  // namespace sixdial::session
