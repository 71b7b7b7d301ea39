// Readings that no dial can show: outside of its travel. Values that instruments and programs
// write for "none" (-999, 9999), a sign that is the other way round, another unit. Such
// readings are never fitted; that they are there is always told.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "session/trials.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kMostOfAll = 0.5;  // of a dial's readings: its sign or unit, not an accident
constexpr double kForNone[] = {999.0, 9999.0, 99999.0, 999.9, 999.99, 999.999, 99.999};

bool is_for_none(double value) {
  constexpr double kSame = 1e-9;
  return std::ranges::any_of(
      kForNone, [&](double each) { return std::abs(std::abs(value) - each) < kSame; });
}

struct Outside {
  std::vector<std::size_t> rows;
  std::map<double, int> values;  // how often each occurs
  int inside_as_negative = 0;    // would be within the travel with the other sign
  int readings = 0;              // of the dial, all
};

Outside outside_of(const session::Session& session, std::size_t dial) {
  const geometry::Dial& type = session.rig.dials[dial];
  const double travel_mm = type.geometry.travel_mm;
  // As session::in_contact: within this of an end the plunger rests at its stop.
  const double band_mm = 3 * type.accuracy_mm + 3 * type.repeatability_mm;
  Outside outside;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const session::Sample& sample = session.samples[i];
    if (sample.left_out || dial >= sample.channels.size()) continue;
    const session::ChannelValue& reading = sample.channels[dial];
    if (!reading.value || reading.quality == session::Quality::kBad) continue;
    ++outside.readings;
    const double value = *reading.value;
    if (value >= -band_mm && value <= travel_mm + band_mm) continue;
    outside.rows.push_back(i);
    ++outside.values[value];
    if (-value > 0.0 && -value < travel_mm) ++outside.inside_as_negative;
  }
  return outside;
}

/// Dials whose readings are below zero: one slip, told once.
struct OtherSign {
  std::vector<std::string> ids;
  std::set<std::size_t> rows;
  double below = 0, readings = 0;
};

void tell_sign(Look& look, const OtherSign& other) {
  if (other.ids.empty()) return;
  std::string fields;
  std::string names;
  for (std::size_t i = 0; i < other.ids.size(); ++i) {
    const bool last = i + 1 == other.ids.size();
    names += (i == 0 ? "" : last ? " and " : ", ") + other.ids[i];
    fields += (i == 0 ? "dial_" : ", dial_") + other.ids[i] + "_mm";
  }
  const bool all = other.ids.size() == look.used.rig.dials.size() && other.ids.size() > 1;
  const char* kind = other.ids.size() == 1 ? "dial " : "dials ";
  const std::vector<std::size_t> rows(other.rows.begin(), other.rows.end());
  look.tell(
      "sign_of_dial", Severity::kDoubt, look.rows(rows, fields),
      {{"dials", all ? "all dials" : kind + names},
       {"below", other.below},
       {"readings", other.readings}});
}

/// A plunger that is pushed to its end says nothing more of the tool, and may be bent.
void tell_end_of_travel(Look& look, std::size_t dial) {
  const geometry::Dial& type = look.used.rig.dials[dial];
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out || dial >= sample.channels.size()) continue;
    const session::ChannelValue& reading = sample.channels[dial];
    if (!reading.value || reading.quality == session::Quality::kBad) continue;
    const bool upper = *reading.value > 0.5 * type.geometry.travel_mm;
    if (upper && !session::in_contact(type, *reading.value)) rows.push_back(i);
  }
  if (rows.empty()) return;
  look.tell(
      "end_of_travel", Severity::kNote, look.rows(rows, "dial_" + type.id + "_mm"),
      {{"dial", type.id}, {"travel", type.geometry.travel_mm}});
}

}  // namespace

void look_at_travel(Look& look) {
  OtherSign other;
  for (std::size_t dial = 0; dial < look.used.rig.dials.size(); ++dial) {
    const Outside outside = outside_of(look.used, dial);
    if (outside.rows.empty()) continue;
    const auto count = static_cast<double>(outside.rows.size());
    const auto most = std::ranges::max_element(
        outside.values, {}, [](const auto& each) { return each.second; });
    const auto none = std::ranges::find_if(
        outside.values, [](const auto& each) { return is_for_none(each.first); });
    const std::string& id = look.used.rig.dials[dial].id;
    WarningParts parts{
        {"dial", id},
        {"value", none != outside.values.end() ? none->first : most->first},
        {"travel", look.used.rig.dials[dial].geometry.travel_mm},
        {"readings", static_cast<double>(outside.readings)}};
    const WarningPlace where = look.rows(outside.rows, "dial_" + id + "_mm");
    const bool many = count > kMostOfAll * outside.readings;
    if (none != outside.values.end() || (most->second > 1 && most->second == count)) {
      look.tell("reading_for_none", many ? Severity::kDoubt : Severity::kNote, where, parts);
    } else if (outside.inside_as_negative == count && many) {
      other.ids.push_back(id);
      other.rows.insert(outside.rows.begin(), outside.rows.end());
      other.below += count;
      other.readings += outside.readings;
    } else {
      look.tell("outside_travel", many ? Severity::kDoubt : Severity::kNote, where, parts);
    }
    for (const std::size_t row : outside.rows) {
      session::ChannelValue& reading = look.used.samples[row].channels[dial];
      reading.quality = session::Quality::kBad;
      reading.reason = "outside the travel";
    }
  }
  for (std::size_t dial = 0; dial < look.used.rig.dials.size(); ++dial) {
    tell_end_of_travel(look, dial);
  }
  tell_sign(look, other);
}

}  // namespace sixdial::studies::plausibility
