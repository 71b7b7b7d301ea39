// Rows that repeat another to the last digit: joint values and every reading. Copied in a
// table, or handed over twice; repeats at rest of which a coarse dial shows nothing look the
// same. They tell nothing new: each is counted once, or the noise would seem to vanish. A row
// of G2 that repeats one of G1 validates nothing.
#include <algorithm>
#include <map>
#include <optional>

#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr std::size_t kLeastReadings = 2;  // one equal number is an accident

/// All that was measured; empty: too little to tell rows apart.
std::vector<double> fingerprint(const session::Sample& sample) {
  constexpr double kNoReading = -1e300;
  std::vector<double> values(sample.q.begin(), sample.q.end());
  std::size_t readings = 0;
  for (const session::ChannelValue& each : sample.channels) {
    values.push_back(each.value.value_or(kNoReading));
    if (each.value) ++readings;
  }
  if (readings < kLeastReadings) values.clear();
  return values;
}

/// Joint values within this are the same pose: a controller comes back so well.
constexpr double kSamePose = 1e-4;  // rad; of a prismatic joint mm
constexpr double kMostAtOld = 0.5;  // of the rows of G2
constexpr int kFewValidating = 5;   // fewer say little of how large errors are elsewhere

/// How much G2 can say: how many rows, and how many of them at places that were not fitted.
void look_at_validation(Look& look) {
  std::vector<const Eigen::VectorXd*> fitted;
  std::vector<std::size_t> validating;
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out || sample.q.size() == 0 || !sample.q.allFinite()) continue;
    if (sample.set == "G1") fitted.push_back(&sample.q);
    if (sample.set == "G2") validating.push_back(i);
  }
  if (validating.empty()) return;
  if (std::ssize(validating) < kFewValidating) {
    look.tell(
        "few_validating", Severity::kNote, {.file = "session.csv", .field = "set"},
        {{"samples", static_cast<double>(validating.size())}});
  }
  const auto first = [](const Eigen::VectorXd* q) { return (*q)[0]; };
  std::ranges::sort(fitted, {}, first);
  std::vector<std::size_t> old;
  for (const std::size_t row : validating) {
    const Eigen::VectorXd& q = look.used.samples[row].q;
    auto near = std::ranges::lower_bound(fitted, q[0] - kSamePose, {}, first);
    for (; near != fitted.end() && (**near)[0] <= q[0] + kSamePose; ++near) {
      if ((**near - q).cwiseAbs().maxCoeff() > kSamePose) continue;
      old.push_back(row);
      break;
    }
  }
  if (static_cast<double>(old.size()) <= kMostAtOld * static_cast<double>(validating.size())) {
    return;
  }
  look.tell(
      "g2_at_poses_of_g1", Severity::kNote, look.rows(old),
      {{"validating", static_cast<double>(validating.size())}});
}

}  // namespace

void look_for_copies(Look& look) {
  std::map<std::vector<double>, std::size_t> first_of;
  std::vector<std::size_t> copies;
  std::vector<std::size_t> validating;
  int repeats = 0;
  int g2 = 0;
  // Rows of G1 first: a copy of them in G2 is the one that does not count.
  for (const bool fitted : {true, false}) {
    for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
      session::Sample& sample = look.used.samples[i];
      if (sample.left_out || (sample.set == "G1") != fitted) continue;
      if (sample.set == "G2") ++g2;
      const std::vector<double> print = fingerprint(sample);
      if (print.empty()) continue;
      const auto [known, is_new] = first_of.emplace(print, i);
      if (is_new) continue;
      const session::Sample& original = look.used.samples[known->second];
      const bool across = sample.set == "G2" && original.set == "G1";
      (across ? validating : copies).push_back(i);
      if (!across && sample.set == original.set && sample.point == original.point) ++repeats;
      sample.left_out = true;
    }
  }
  if (!copies.empty()) {
    const bool all_repeats = repeats == static_cast<int>(copies.size());
    look.tell(
        all_repeats ? "copied_repeats" : "copied_rows", Severity::kNote, look.rows(copies));
  }
  if (!validating.empty()) {
    look.tell(
        "g2_repeats_g1", Severity::kNote, look.rows(validating),
        {{"validating", static_cast<double>(g2)},
         {"left", static_cast<double>(g2) - static_cast<double>(validating.size())}});
  }
  look_at_validation(look);
}

}  // namespace sixdial::studies::plausibility
