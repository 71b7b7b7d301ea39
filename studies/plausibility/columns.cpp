// Whole columns of readings that are none: a dial that shows the same number wherever the tool
// is, and two dials that agree to the last digit, of which one is a copy of the other.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "session/trials.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr std::size_t kFewestPoses = 6;  // by accident nothing stays or agrees so often

/// Rows in which a dial (or two) gave a reading, and at how many poses.
struct Seen {
  std::vector<std::size_t> rows;
  std::set<std::vector<double>> poses;
  void add(std::size_t row, const session::Sample& sample) {
    rows.push_back(row);
    if (poses.size() < kFewestPoses) poses.emplace(sample.q.begin(), sample.q.end());
  }
};

std::optional<double> reading_of(const session::Sample& sample, std::size_t dial) {
  if (sample.left_out || dial >= sample.channels.size()) return std::nullopt;
  const session::ChannelValue& reading = sample.channels[dial];
  return reading.quality == session::Quality::kBad ? std::nullopt : reading.value;
}

void take_away(Look& look, const std::vector<std::size_t>& rows, std::size_t dial) {
  for (const std::size_t row : rows) {
    session::ChannelValue& reading = look.used.samples[row].channels[dial];
    reading.quality = session::Quality::kBad;
    reading.reason = "no reading of this dial";
  }
}

void look_for_stuck(Look& look, std::size_t dial) {
  Seen seen;
  std::optional<double> value;
  for (std::size_t row = 0; row < look.used.samples.size(); ++row) {
    const auto here = reading_of(look.used.samples[row], dial);
    if (!here) continue;
    if (value && *here != *value) return;
    value = here;
    seen.add(row, look.used.samples[row]);
  }
  const geometry::Dial& type = look.used.rig.dials[dial];
  // At its stop a plunger stays wherever the tool is: it does not touch.
  if (seen.poses.size() < kFewestPoses || !session::in_contact(type, *value)) return;
  look.tell(
      "stuck_column", Severity::kDoubt, look.rows(seen.rows, "dial_" + type.id + "_mm"),
      {{"dial", type.id}, {"value", *value}});
  take_away(look, seen.rows, dial);
}

void look_for_copy(Look& look, std::size_t dial, std::size_t other) {
  Seen seen;
  for (std::size_t row = 0; row < look.used.samples.size(); ++row) {
    const auto here = reading_of(look.used.samples[row], dial);
    const auto there = reading_of(look.used.samples[row], other);
    if (!here && !there) continue;
    if (here != there) return;
    seen.add(row, look.used.samples[row]);
  }
  if (seen.poses.size() < kFewestPoses) return;
  const auto& dials = look.used.rig.dials;
  // Two dials that both stay at their stops are alike too.
  bool touches = false;
  for (const std::size_t row : seen.rows) {
    touches =
        touches || session::in_contact(dials[dial], *reading_of(look.used.samples[row], dial));
  }
  if (!touches) return;
  const std::string ids = dials[dial].id + " and " + dials[other].id;
  look.tell(
      "copied_columns", Severity::kDoubt,
      look.rows(seen.rows, "dial_" + dials[dial].id + "_mm, dial_" + dials[other].id + "_mm"),
      {{"dials", ids}});
  take_away(look, seen.rows, dial);
  take_away(look, seen.rows, other);
}

/// Of a session that others were read in.
void look_for_silent(Look& look) {
  const auto& dials = look.used.rig.dials;
  std::vector<char> read(dials.size(), 0);
  for (const session::Sample& sample : look.measured.samples) {
    for (std::size_t k = 0; k < std::min(dials.size(), sample.channels.size()); ++k) {
      if (sample.channels[k].value) read[k] = 1;
    }
  }
  if (std::ranges::count(read, 1) == 0) return;
  std::vector<std::string> silent;
  for (std::size_t k = 0; k < dials.size(); ++k) {
    if (read[k] == 0) silent.push_back(dials[k].id);
  }
  if (silent.empty()) return;
  look.tell(
      "silent_dial", Severity::kNote, {.file = "session.csv"},
      {{"dials", dials_in_words(silent)}});
}

}  // namespace

void look_at_columns(Look& look) {
  look_for_silent(look);
  const std::size_t dials = look.used.rig.dials.size();
  for (std::size_t dial = 0; dial < dials; ++dial) look_for_stuck(look, dial);
  for (std::size_t dial = 0; dial < dials; ++dial) {
    for (std::size_t other = dial + 1; other < dials; ++other) look_for_copy(look, dial, other);
  }
}

}  // namespace sixdial::studies::plausibility
