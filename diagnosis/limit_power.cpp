#include "diagnosis/limit_power.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "calibration/random.h"
#include "diagnosis/limit_search.h"
#include "diagnosis/significance.h"

namespace sixdial::diagnosis {
namespace {

constexpr std::uint32_t kDirectionStream = 74;

/// Of a draw: a unit vector, any.
Eigen::VectorXd direction(Eigen::Index count, int draw) {
  Eigen::VectorXd result(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    result[i] = calibration::random_normal(
        1, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(draw), 0,
        kDirectionStream);
  }
  return result.normalized();
}

}  // namespace

LimitPower::Draw LimitPower::drawn(double times, int number) const {
  Draw result{number, static_cast<std::size_t>(number) % own_.values.size(), {}, {}, 0.0, 0.0};
  const LimitColumns& at = own_.values[result.value];
  Eigen::VectorXd& x = result.x;
  x = times * at.sizes.cwiseProduct(direction(at.sizes.size(), number));
  if (at.one_sided) x = x.cwiseAbs();
  const Eigen::VectorXd signal = at.normal * x;
  result.right = signal + at.noise.col(number);
  result.sse = study_.noise.squares[number] + 2 * x.dot(at.noise.col(number)) + x.dot(signal);
  result.evidence = at.evidence(result.right, result.sse, study_.projector.freedom()) -
                    against_.own_cost[result.value] - implausibility(times);
  return result;
}

std::optional<LimitPower::RivalSeen> LimitPower::seen_by(
    const LimitRival& rival, const Draw& of) const {
  const LimitColumns& other = *rival.at[of.value];
  Eigen::VectorXd theirs = rival.cross[of.value] * of.x + other.noise.col(of.number);
  const Eigen::VectorXd sizes = other.inverse * theirs;
  if (other.one_sided && sizes[0] < 0) return std::nullopt;
  const double evidence = other.evidence(theirs, of.sse, study_.projector.freedom()) -
                          rival.cost[of.value] -
                          implausibility(sizes.cwiseQuotient(other.sizes).norm());
  return RivalSeen{std::move(theirs), evidence};
}

double LimitPower::evidence_of(const BestUnnamed& each, const Draw& of) const {
  return each.of->evidence(each.shared, of.x, of.number, of.sse, study_.projector.freedom());
}

bool LimitPower::is_rare(
    const SeenEffect& of, const LimitColumns& at, const Eigen::VectorXd& right,
    double sse) const {
  const double explained = std::clamp(right.dot(at.inverse * right), 0.0, sse * (1 - 1e-12));
  const double gain = -0.5 * study_.projector.freedom() * std::log1p(-explained / sse);
  const double p_value =
      p_value_of_best(p_value_of_gain(gain, static_cast<int>(right.size())), of.tries);
  return p_value_of_best(p_value, study_.catalogue) <= study_.settings.false_alarm_level;
}

bool LimitPower::is_told(const Draw& of, const AllSeen& seen, double best) const {
  if (!(best - study_.prior_cost >= study_.settings.least_log_odds)) return false;
  if (is_rare(own_, own_.values[of.value], of.right, of.sse)) return true;
  for (std::size_t r = 0; r < seen.size(); ++r) {
    const LimitRival& rival = against_.rivals[r];
    if (seen[r] && is_rare(*rival.seen, *rival.at[of.value], seen[r]->right, of.sse)) {
      return true;
    }
  }
  return false;
}

double LimitPower::detected(double times) const {
  int count = 0;
  for (int draw = 0; draw < kLimitDraws; ++draw) {
    const Draw of = drawn(times, draw);
    AllSeen seen;
    double best = of.evidence;
    for (const LimitRival& each : against_.rivals) {
      seen.push_back(seen_by(each, of));
      if (seen.back()) best = std::max(best, seen.back()->evidence);
    }
    if (!is_told(of, seen, best)) continue;
    // As likely as what dials do by themselves, which is no finding, is enough (growing.cpp).
    double background = 0.0;
    for (const BestUnnamed& each : against_.unnamed[of.value]) {
      if (is_background(each.of->kind())) {
        background = std::max(background, evidence_of(each, of));
      }
    }
    count += best - study_.prior_cost >= background ? 1 : 0;
  }
  return static_cast<double>(count) / kLimitDraws;
}

double LimitPower::named(double times) const {
  const double tie = study_.settings.tie_log_odds;
  int count = 0;
  for (int draw = 0; draw < kLimitDraws; ++draw) {
    const Draw of = drawn(times, draw);
    if (of.evidence - study_.prior_cost < tie) continue;
    AllSeen seen;
    double best = of.evidence;
    bool tied = false;
    for (const LimitRival& each : against_.rivals) {
      seen.push_back(seen_by(each, of));
      if (!seen.back()) continue;
      best = std::max(best, seen.back()->evidence);
      tied = !(of.evidence - seen.back()->evidence >= tie);
      if (tied) break;
    }
    if (tied || !is_told(of, seen, best)) continue;
    count += std::ranges::none_of(
                 against_.unnamed[of.value],
                 [&](const BestUnnamed& each) {
                   return of.evidence - study_.prior_cost - evidence_of(each, of) < tie;
                 })
                 ? 1
                 : 0;
  }
  return static_cast<double>(count) / kLimitDraws;
}

const LimitRival* LimitPower::worst_rival(double times) const {
  const std::vector<LimitRival>& rivals = against_.rivals;
  std::vector<int> lost(rivals.size());
  for (int draw = 0; draw < kLimitDraws; ++draw) {
    const Draw of = drawn(times, draw);
    for (std::size_t r = 0; r < rivals.size(); ++r) {
      const auto seen = seen_by(rivals[r], of);
      const bool as_good =
          seen && !(of.evidence - seen->evidence >= study_.settings.tie_log_odds);
      lost[r] += as_good ? 1 : 0;
    }
  }
  const auto worst = std::ranges::max_element(lost);
  return worst == lost.end() ? nullptr
                             : &rivals[static_cast<std::size_t>(worst - lost.begin())];
}

}  // namespace sixdial::diagnosis
