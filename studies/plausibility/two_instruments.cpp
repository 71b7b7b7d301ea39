// A session that has positions and dial readings of the same samples, and the two disagree. One
// of them is believed, by all commands: the one that is nearer to the nominal robot.
#include <algorithm>
#include <cmath>

#include "geometry/tool.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kLeastDifference_mm = 0.05;
constexpr double kTimesNoise = 6.0;

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return values[values.size() / 2];
}

struct Compared {
  std::vector<std::size_t> rows;
  std::vector<double> apart_mm, noise_mm;
  std::vector<double> position_off_mm, dials_off_mm;  // from the nominal robot
};

Compared compared(const session::Session& session) {
  Compared both;
  const std::size_t dials = session.rig.dials.size();
  const geometry::Tool tool(session.rig);
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    session::Sample sample = session.samples[i];
    const auto position = session::position_of(sample, dials);
    if (sample.left_out || !position) continue;
    const geometry::Assembly assembly = session::assembly_of(session.rig, sample);
    session::set_position(sample, dials, std::nullopt);
    const simulation::Trial trial = session::trial_of(session.rig, sample);
    const auto nominal = tool.position(session.rig.robot.nominal, sample.q, assembly);
    if (!trial.position_mm || !nominal) continue;
    both.rows.push_back(i);
    both.apart_mm.push_back((*position - *trial.position_mm).norm());
    both.noise_mm.push_back(std::sqrt(trial.covariance_or_zero().trace()));
    both.position_off_mm.push_back((*position - *nominal).norm());
    both.dials_off_mm.push_back((*trial.position_mm - *nominal).norm());
  }
  return both;
}

}  // namespace

void look_at_two_instruments(Look& look) {
  const std::size_t dials = look.used.rig.dials.size();
  if (dials == 0) return;
  const Compared both = compared(look.used);
  if (both.rows.empty()) return;
  const double apart_mm = median(both.apart_mm);
  const double noise_mm = std::hypot(median(both.noise_mm), look.used.rig.instrument.sd_mm);
  if (apart_mm < std::max(kLeastDifference_mm, kTimesNoise * noise_mm)) return;
  const bool by_dials = median(both.dials_off_mm) <= median(both.position_off_mm);
  look.tell(
      "positions_and_dials_differ", Severity::kDoubt, look.rows(both.rows),
      {{"apart", apart_mm},
       {"used", std::string(by_dials ? "the dials" : "the positions")},
       {"not_used", std::string(by_dials ? "the positions" : "the dials")}});
  for (session::Sample& sample : look.used.samples) {
    if (by_dials) {
      session::set_position(sample, dials, std::nullopt);
      continue;
    }
    for (std::size_t i = 0; i < dials && i < sample.channels.size(); ++i) {
      sample.channels[i].quality = session::Quality::kBad;
      sample.channels[i].reason = "the position is used";
    }
  }
}

}  // namespace sixdial::studies::plausibility
