#include "simulation/effect.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "simulation/catalogue.h"

namespace sixdial::simulation {
namespace {

using Rows = std::vector<const Effect*>;

/// Readers take the newest list without a lock; a list that somebody may still read is kept
/// until the program ends, which is cheap as rows are added a few times at most.
class Catalogue {
 public:
  Catalogue() {
    const auto built_in = built_in_effects();
    Rows rows(built_in.begin(), built_in.end());
    std::ranges::sort(rows, {}, &Effect::cause);
    publish(std::move(rows));
  }
  [[nodiscard]] const Rows& rows() const { return *newest_.load(std::memory_order_acquire); }
  void add(const Effect& row) {
    const std::scoped_lock lock(changing_);
    Rows next = rows();
    const auto at = std::ranges::lower_bound(next, row.cause, {}, &Effect::cause);
    if (at != next.end() && (*at)->cause == row.cause) {
      throw std::invalid_argument(
          "there is an effect '" + std::string(row.cause) + "' already");
    }
    next.insert(at, &row);
    publish(std::move(next));
  }
  void remove(const Effect& row) {
    const std::scoped_lock lock(changing_);
    Rows next = rows();
    std::erase(next, &row);
    publish(std::move(next));
  }

 private:
  void publish(Rows next) {
    lists_.push_back(std::make_unique<const Rows>(std::move(next)));
    newest_.store(lists_.back().get(), std::memory_order_release);
  }

  std::mutex changing_;
  std::vector<std::unique_ptr<const Rows>> lists_;
  std::atomic<const Rows*> newest_ = nullptr;
};

Catalogue& catalogue() {
  static Catalogue all;
  return all;
}

/// "joint 1" for "joint1", "A and B" for "A,B", "the base" for "base", "dial A" for "A".
std::string place_in_words(std::string_view name) {
  static constexpr std::array<std::string_view, 9> kOfTheirOwn{
      "base", "cuboid", "dials", "elbows", "frame", "instrument", "joints", "links", "samples"};
  const std::string text(name);
  if (std::ranges::find(kOfTheirOwn, name) != kOfTheirOwn.end()) return "the " + text;
  if (const auto comma = text.find(','); comma != std::string::npos) {
    const std::string second = text.substr(comma + 1);
    if (name.starts_with("joint")) {
      return place_in_words(text.substr(0, comma)) + " with " + place_in_words(second);
    }
    return text.substr(0, comma) + " and " + second;
  }
  if (name.starts_with("joint")) return "joint " + text.substr(5);
  return "dial " + text;
}

}  // namespace

std::span<const Effect* const> all_effects() { return catalogue().rows(); }

const Effect* find_effect(std::string_view cause) {
  const auto rows = all_effects();
  const auto found = std::ranges::lower_bound(rows, cause, {}, &Effect::cause);
  return found != rows.end() && (*found)->cause == cause ? *found : nullptr;
}

const Effect* curve_of_joints() {
  const auto rows = all_effects();
  const auto found = std::ranges::find_if(rows, [](const Effect* each) {
    return each->is_curve && each->plot.shows == Shows::kJointAngle;
  });
  return *found;
}

AddedEffect::AddedEffect(const Effect& row) : row_(&row) {
  const bool acts =
      row.before_kinematics || row.after_kinematics || row.before_contact || row.after_reading;
  if (row.cause.empty() || row.in_words.empty() || !row.places || !acts) {
    throw std::invalid_argument(
        "effect '" + std::string(row.cause) +
        "' needs a cause, words, places and at least one hook");
  }
  catalogue().add(row);
}

AddedEffect::~AddedEffect() { catalogue().remove(*row_); }

std::optional<EffectParameter> parameter_at(const Effect& effect, const Place& place, int k) {
  if (k >= static_cast<int>(effect.parameters.size())) return std::nullopt;
  if (effect.parameter_of_place) return effect.parameter_of_place(place, k);
  return effect.parameters[static_cast<std::size_t>(k)];
}

SignaturePlot plot_at(const Effect& effect, const Place& place) {
  return effect.plot_of_place ? effect.plot_of_place(place) : effect.plot;
}

std::string in_words_at(const Effect& effect, std::string_view place_name) {
  constexpr std::string_view kPlace = "{place}";
  std::string words(effect.in_words_with_place);
  const std::size_t at = words.find(kPlace);
  if (words.empty() || place_name.empty()) return std::string(effect.in_words);
  return at == std::string::npos ? words
                                 : words.replace(at, kPlace.size(), place_in_words(place_name));
}

std::vector<Place> at_each_joint(const geometry::Rig& rig) {
  std::vector<Place> result;
  const auto& joints = rig.robot.model->joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    result.push_back(
        {.name = "joint" + std::to_string(j + 1),
         .joint = static_cast<int>(j),
         .slides = joints[j].kind == geometry::JointKind::kPrismatic,
         .axes = rig.robot.model->axes});
  }
  return result;
}

std::vector<Place> at_each_turning_joint(const geometry::Rig& rig) {
  std::vector<Place> result = at_each_joint(rig);
  std::erase_if(result, [](const Place& each) { return each.slides; });
  return result;
}

std::vector<double> samples_of_a_step(
    const geometry::Rig&, std::span<const Circumstance> all, const Place&) {
  // A step needs a few samples on each side to be one.
  constexpr int kFewestOnASide = 3;
  // In long sessions not every sample is asked whether the step is there.
  constexpr int kMostAsked = 1000;
  std::vector<double> result;
  const int every = 1 + (static_cast<int>(all.size()) - 1) / kMostAsked;
  for (int k = kFewestOnASide; k + kFewestOnASide <= static_cast<int>(all.size()); k += every) {
    result.push_back(k);
  }
  return result;
}

EffectParameter of_joint(const EffectParameter& parameter, const Place& place) {
  constexpr double kLever_mm = 60.0;
  if (!place.slides) return parameter;
  return {parameter.name, "mm", parameter.sigma * kLever_mm, parameter.never_negative};
}

std::vector<Place> at_each_dial(const geometry::Rig& rig) {
  std::vector<Place> result;
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    result.push_back({.name = rig.dials[i].id, .dial = static_cast<int>(i)});
  }
  return result;
}

std::vector<Place> at_each_pair_of_dials(const geometry::Rig& rig) {
  std::vector<Place> result;
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    for (std::size_t j = i + 1; j < rig.dials.size(); ++j) {
      result.push_back(
          {.name = rig.dials[i].id + "," + rig.dials[j].id,
           .dial = static_cast<int>(i),
           .other_dial = static_cast<int>(j)});
    }
  }
  return result;
}

std::vector<Place> at_one_place(const geometry::Rig& rig, std::string_view name) {
  return {Place{.name = std::string(name), .axes = rig.robot.model->axes}};
}

std::vector<Place> on_the_cuboid(const geometry::Rig& rig, std::string_view name) {
  if (!rig.on_cuboid()) return {};
  return at_one_place(rig, name);
}

std::vector<Place> at_the_instrument(const geometry::Rig& rig) {
  if (rig.on_cuboid()) return {};
  return at_one_place(rig, "instrument");
}

}  // namespace sixdial::simulation
