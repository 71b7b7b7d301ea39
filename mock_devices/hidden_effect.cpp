#include "mock_devices/hidden_effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace sixdial::mock_devices {
namespace {

/// A size that is a turn at some places and a shift at others is given for the shift.
std::pair<double, double> amplitude_range(const CauseRow& row, std::string_view where) {
  const bool by_place = std::ranges::any_of(row.numbers, &NumberName::unit_by_place);
  if (!by_place || !turns_at(where)) return {row.least, row.most};
  constexpr double kLeverPerMm = 1.0 / 60.0;  // a turn that moves the tool by about 1 mm
  return {row.least * kLeverPerMm, row.most * kLeverPerMm};
}

double drawn_amplitude(const CauseRow& row, std::string_view where, const Random& random) {
  const auto [least, most] = amplitude_range(row, where);
  const double size = least * std::pow(most / least, random.uniform(10));
  return row.both_signs && random.uniform(11) < 0.5 ? -size : size;
}

void refuse_other_places(
    const CauseRow& row, const geometry::Rig& rig, std::string_view where) {
  const std::vector<std::string> places = row.places(rig);
  if (std::ranges::find(places, where) != places.end()) return;
  std::string known;
  for (const std::string& place : places) known += " " + place;
  throw std::invalid_argument(
      fmt::format("{} cannot be at '{}' on this rig; its places are:{}", row.id, where, known));
}

}  // namespace

const CauseRow& cause_row(std::string_view id) {
  const auto found = std::ranges::find(causes(), id, &CauseRow::id);
  if (found != causes().end()) return **found;
  std::string known;
  for (const CauseRow* row : causes()) known += fmt::format(" {}", row->id);
  throw std::invalid_argument(fmt::format("no cause '{}'; known are:{}", id, known));
}

HiddenEffect make_effect(
    const geometry::Rig& rig, std::string_view cause, std::string_view where, double amplitude,
    std::uint64_t seed, int samples) {
  const CauseRow& row = cause_row(cause);
  refuse_other_places(row, rig, where);
  if (!std::isfinite(amplitude)) {
    throw std::invalid_argument(fmt::format("{} at {}: amplitude is not finite", cause, where));
  }
  const Random random(seed, Stream::kHide);
  const std::vector<double> numbers =
      row.draw({amplitude, where, random, samples, random.uniform(20, 0.0, kTwoPi)});
  HiddenEffect effect{std::string(cause), std::string(where), {}};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    effect.parameters[name_at(row.numbers[i], where)] = numbers[i];
  }
  return effect;
}

HiddenEffect parse_effect(
    const geometry::Rig& rig, std::string_view text, std::uint64_t seed, int samples) {
  const std::size_t first = text.find(':');
  const std::string_view cause = text.substr(0, first);
  if (first == std::string_view::npos) return draw_effect_of(rig, cause, seed, samples);
  const std::string_view rest = text.substr(first + 1);
  const std::size_t second = rest.find(':');
  const std::string_view where = rest.substr(0, second);
  if (second == std::string_view::npos) {
    const double amplitude =
        drawn_amplitude(cause_row(cause), where, Random(seed, Stream::kHide));
    return make_effect(rig, cause, where, amplitude, seed, samples);
  }
  const std::string_view number = rest.substr(second + 1);
  double amplitude = 0.0;
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), amplitude);
  if (error != std::errc{} || end != number.data() + number.size()) {
    throw std::invalid_argument(fmt::format(
        "'{}': the amplitude '{}' is not a number; write cause:where:amplitude", text, number));
  }
  return make_effect(rig, cause, where, amplitude, seed, samples);
}

HiddenEffect draw_effect_of(
    const geometry::Rig& rig, std::string_view cause, std::uint64_t seed, int samples) {
  const CauseRow& row = cause_row(cause);
  const Random random(seed, Stream::kHide);
  const std::vector<std::string> places = row.places(rig);
  if (places.empty()) {
    throw std::invalid_argument(fmt::format("{}: this rig has no place for it", cause));
  }
  const auto pick =
      static_cast<std::size_t>(random.uniform(1) * static_cast<double>(places.size()));
  const std::string& where = places[pick];
  return make_effect(rig, row.id, where, drawn_amplitude(row, where, random), seed, samples);
}

HiddenEffect draw_effect(const geometry::Rig& rig, std::uint64_t seed, Pool pool, int samples) {
  std::vector<const CauseRow*> choice;
  for (const CauseRow* row : causes()) {
    if (pool == Pool::kAll || row->in_catalogue == (pool == Pool::kCatalogue)) {
      choice.push_back(row);
    }
  }
  const double pick = Random(seed, Stream::kHide).uniform(0);
  const auto index = static_cast<std::size_t>(pick * static_cast<double>(choice.size()));
  return draw_effect_of(rig, choice[index]->id, seed, samples);
}

HiddenEffect enlarged(HiddenEffect effect, double times) {
  for (const NumberName& number : cause_row(effect.cause).numbers) {
    const auto found = effect.parameters.find(name_at(number, effect.where));
    if (found == effect.parameters.end() || number.scaling == Scaling::kNot) continue;
    found->second *= number.scaling == Scaling::kAlike ? times : 1 / times;
  }
  return effect;
}

ReadyEffect made_ready(
    const HiddenEffect& effect, const geometry::Rig& rig, const Eigen::Vector2d& q_reference) {
  const CauseRow& row = cause_row(effect.cause);
  refuse_other_places(row, rig, effect.where);
  ReadyEffect ready;
  ready.where = effect.where;
  const auto dial_index = [&](const std::string& id) {
    const auto found = rig.find_dial(id);
    return found ? static_cast<int>(*found) : -1;
  };
  const std::vector<std::string> joints = each_joint(rig);
  const auto joint = std::ranges::find(joints, effect.where);
  if (joint != joints.end()) ready.joint = static_cast<int>(joint - joints.begin());
  const std::size_t comma = effect.where.find(',');
  ready.dial = dial_index(effect.where.substr(0, comma));
  if (comma != std::string::npos) ready.other_dial = dial_index(effect.where.substr(comma + 1));
  for (std::size_t i = 0; i < row.numbers.size(); ++i) {
    const NumberName& number = row.numbers[i];
    const std::string name = name_at(number, effect.where);
    const auto found = effect.parameters.find(name);
    if (found == effect.parameters.end() && !number.otherwise) {
      throw std::invalid_argument(
          fmt::format("{} at {} lacks its parameter '{}'", effect.cause, effect.where, name));
    }
    ready.p[i] = found == effect.parameters.end() ? *number.otherwise : found->second;
  }
  if (row.prepare) row.prepare(ready, q_reference);
  return ready;
}

}  // namespace sixdial::mock_devices
