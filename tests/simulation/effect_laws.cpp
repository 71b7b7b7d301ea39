#include "tests/simulation/effect_laws.h"

#include <algorithm>
#include <set>

#include "simulation/effect_words.h"

namespace sixdial::simulation {
namespace {

constexpr double kSeen_mm = 1e-4;

std::size_t linear_count(const Effect& effect) {
  return effect.parameters.size() - (effect.searched ? 1 : 0);
}

void append(EffectLaws::Complaints& all, EffectLaws::Complaints more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

EffectLaws::EffectLaws(LawRig rig)
    : model_(law_rig(rig)), plain_(model_, {}), trials_(law_trials(model_, 40, 8.0)) {
  circumstances_ = circumstances_of(model_, model_.nominal(), trials_);
}

Eigen::VectorXd EffectLaws::seen(const std::optional<ActiveEffect>& active) const {
  std::vector<double> values;
  Scene scene;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    if (!plain_.run(
            model_.nominal(), trials_[t], circumstances_[t], scene,
            active ? &*active : nullptr)) {
      return {};
    }
    values.insert(values.end(), scene.reading.begin(), scene.reading.end());
    values.push_back(scene.p_WE.x());
    values.push_back(scene.p_WE.y());
    values.push_back(scene.p_WE.z());
  }
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

ActiveEffect EffectLaws::only(
    const Effect& effect, const Place& place, std::size_t i, double share,
    bool first_searched) const {
  std::vector<double> x(effect.parameters.size(), 0.0);
  if (effect.searched) {
    const auto values = effect.searched(model_.rig(), circumstances_, place);
    x.back() = values[first_searched ? 0 : values.size() / 2];
  }
  if (i < x.size()) x[i] = share * effect.parameters[i].sigma;
  return {&effect, place, std::move(x)};
}

EffectLaws::Complaints EffectLaws::does_nothing_at_zero(
    const Effect& effect, const Place& place) const {
  if (effect.exchanges_dials) return {};
  if ((seen(only(effect, place, 0, 0.0)) - seen({})).norm() == 0.0) return {};
  return {"something moves at size nought"};
}

EffectLaws::Complaints EffectLaws::every_parameter_acts(
    const Effect& effect, const Place& place) const {
  if (effect.exchanges_dials) return {};
  Complaints result;
  const Eigen::VectorXd plain = seen({});
  if (effect.is_curve) {
    const double most_mm =
        (seen(ActiveEffect{&effect, place, three_sizes(effect)}) - plain).cwiseAbs().maxCoeff();
    if (!(most_mm > kSeen_mm)) result.emplace_back("its curve moves nothing");
    return result;
  }
  if (linear_count(effect) == 0) result.emplace_back("it has neither a size nor two dials");
  bool search_acts = !effect.searched;
  for (std::size_t i = 0; i < linear_count(effect); ++i) {
    const std::string name(effect.parameters[i].name);
    const Eigen::VectorXd moved = seen(only(effect, place, i, 1.0));
    const double most_mm = (moved - plain).cwiseAbs().maxCoeff();
    const bool is_there = parameter_at(effect, place, static_cast<int>(i)).has_value();
    if (is_there && !(most_mm > kSeen_mm)) result.push_back(name + " moves nothing");
    if (!is_there && most_mm > 0)
      result.push_back(name + " acts where it is said to be missing");
    if (effect.searched) {
      const Eigen::VectorXd elsewhere = seen(only(effect, place, i, 1.0, true));
      search_acts = search_acts || (elsewhere - moved).cwiseAbs().maxCoeff() > kSeen_mm;
    }
  }
  if (!search_acts) {
    result.push_back(std::string(effect.parameters.back().name) + " moves nothing");
  }
  return result;
}

EffectLaws::Complaints EffectLaws::is_smooth(const Effect& effect, const Place& place) const {
  constexpr double kBend = 0.02;
  Complaints result;
  if (effect.is_curve) return result;  // linear in its coefficients
  const Eigen::VectorXd plain = seen({});
  for (std::size_t i = 0; i < linear_count(effect); ++i) {
    const Eigen::VectorXd whole = seen(only(effect, place, i, 1.0)) - plain;
    const Eigen::VectorXd half = 2 * (seen(only(effect, place, i, 0.5)) - plain);
    if ((whole - half).norm() > kBend * whole.norm()) {
      result.push_back(std::string(effect.parameters[i].name) + " is not smooth");
    }
  }
  return result;
}

EffectLaws::Complaints EffectLaws::exchanges_its_dials(
    const Effect& effect, const Place& place) const {
  if (!effect.exchanges_dials) return {};
  if (place.dial < 0 || place.other_dial < 0) return {"its place names no two dials"};
  if (!effect.parameters.empty()) return {"it has a size"};
  const auto width = static_cast<Eigen::Index>(model_.rig().dials.size()) + 3;
  const Eigen::VectorXd before = seen({});
  const Eigen::VectorXd after = seen(ActiveEffect{&effect, place, {}});
  for (Eigen::Index row = 0; row < before.size(); ++row) {
    const Eigen::Index dial = row % width;
    Eigen::Index from = row;
    if (dial == place.dial) from += place.other_dial - place.dial;
    if (dial == place.other_dial) from += place.dial - place.other_dial;
    if (after[row] != before[from]) return {"the readings are not exchanged"};
  }
  return {};
}

EffectLaws::Complaints EffectLaws::says_what_it_is(
    const Effect& effect, const Place& place) const {
  Complaints result;
  for (const auto text :
       {effect.cause, effect.in_words, effect.signature, effect.consequence, effect.advice,
        effect.told_apart, effect.helps, effect.twin}) {
    if (text.empty()) result.emplace_back("a name or a text is missing");
  }
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const EffectParameter& own = effect.parameters[i];
    const EffectParameter here = parameter_at(effect, place, static_cast<int>(i)).value_or(own);
    const std::string name(own.name);
    if (here.unit.empty() || !(here.sigma > 0)) result.push_back(name + " lacks unit or size");
    if (here.name != own.name) result.push_back(name + " changes its name by place");
    if (!names.insert(own.name).second) result.push_back(name + " is there twice");
  }
  if (effect.never_negative &&
      std::ranges::none_of(effect.parameters, &EffectParameter::never_negative)) {
    result.emplace_back("it is never negative, but none of its parameters is said to be so");
  }
  if ((effect.needs & kTime) && !effect.in_time) {
    result.emplace_back("it needs the time, but is not said to be in time");
  }
  if (effect.is_step && !effect.searched) result.emplace_back("a step without a search");
  if (find_effect(effect.cause) != &effect) result.emplace_back("it is not in the catalogue");
  return result;
}

std::string EffectLaws::example_of_size(
    const Effect& effect, const Place& place, int enlarged) {
  std::vector<FoundParameter> found;
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    const auto parameter = parameter_at(effect, place, k);
    if (!parameter) continue;
    const double value = (k == enlarged ? 3 : 1) * parameter->sigma;
    found.push_back({parameter->name, value, 0.1 * parameter->sigma, parameter->unit});
  }
  return size_in_words(effect, found);
}

EffectLaws::Complaints EffectLaws::says_its_size(
    const Effect& effect, const Place& place) const {
  Complaints result;
  const std::string words = example_of_size(effect, place);
  if (words.empty() || words.find('{') != std::string::npos) {
    result.push_back("its size is not said: '" + words + "'");
  }
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    const auto parameter = parameter_at(effect, place, k);
    if (parameter && example_of_size(effect, place, k) == words) {
      result.push_back(std::string(parameter->name) + " is not in the words of its size");
    }
  }
  return result;
}

EffectLaws::Complaints EffectLaws::all(const Effect& effect, const Place& place) const {
  Complaints result = says_what_it_is(effect, place);
  append(result, does_nothing_at_zero(effect, place));
  append(result, every_parameter_acts(effect, place));
  append(result, is_smooth(effect, place));
  append(result, exchanges_its_dials(effect, place));
  append(result, says_its_size(effect, place));
  return result;
}

}  // namespace sixdial::simulation
