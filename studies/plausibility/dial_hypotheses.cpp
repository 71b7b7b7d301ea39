#include "studies/plausibility/dial_hypotheses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "geometry/registration.h"
#include "simulation/forward_model.h"
#include "studies/plausibility/tool_seen.h"

namespace sixdial::studies::plausibility {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kMostSamples = 250;
constexpr Index kFewestReadings = 6;   // of a column
constexpr std::size_t kAllOrders = 7;  // so many dials are tried in every order
constexpr std::size_t kTried = 16;     // orders that are fitted
constexpr int kReweighted = 6;
/// Below this no column is told from another: the fit is linear, the robot is not.
constexpr double kFloor_mm = 0.08;
/// What a column must miss by as it is before anything is said of it.
constexpr double kOff_mm = 0.5;
/// So many times better must a column fit that is said to be another one, or in another unit.
constexpr double kClearly = 4.0;
constexpr double kPlausibleChanges = 4.0;  // of a parameter, in ParameterInfo::change
constexpr double kMount_mm = 2.0;          // how well a dial's place is known
constexpr double kNoContact_mm = 0.03;
constexpr double kToSigma = 1.4826;
/// Two dials on opposite faces that are exchanged look almost as if both counted the other way,
/// which is less likely.
constexpr double kLessLikely = 1.0;  // of the logarithm
constexpr int kTurnSteps = 4;
constexpr double kMostTurned_rad = 0.6;

struct Unit {
  double mm;
  std::string_view name;
};
constexpr std::array kUnits{Unit{1.0, "millimetres"},  Unit{25.4, "inches"},
                            Unit{10.0, "centimetres"}, Unit{1e3, "metres"},
                            Unit{1e-3, "micrometres"}, Unit{0.0254, "thousandths of an inch"}};

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What the nominal robot would show at one sample.
struct Expected {
  VectorXd reading;   // by dial
  MatrixXd slope;     // dials x parameters, in plausible changes
  VectorXd by_gamma;  // of a freely held cuboid; else empty
};

/// Readings and what the nominal robot would show, samples x dials; NaN: none.
struct Table {
  std::shared_ptr<const simulation::ForwardModel> model;
  VectorXd scale;     // of the parameters
  bool free = false;  // the cuboid's turn is an unknown of each sample
  std::vector<geometry::JointPose> pose;
  MatrixXd shown, nominal;
  std::vector<Expected> expected;  // by sample, of a free cuboid not turned
  [[nodiscard]] Index dials() const { return shown.cols(); }
  [[nodiscard]] Index samples() const { return shown.rows(); }
};

/// Empty where the pose does not exist.
std::optional<Expected> expected_at(
    const Table& table, const geometry::JointPose& pose, std::optional<double> gamma_rad) {
  const simulation::ForwardModel& model = *table.model;
  const auto at = model.predict(model.nominal(), pose.q, pose.assembly, gamma_rad, false);
  if (!at) return std::nullopt;
  Expected expected{at->reading, at->reading_J * table.scale.asDiagonal(), {}};
  if (table.free) expected.by_gamma = at->reading_J_gamma;
  return expected;
}

/// Below this a column's readings are those of a plunger that does not touch, by column: in
/// metres all of them are small.
VectorXd no_contact(const session::Session& session, Index dials) {
  constexpr double kOfLargest = 1e-3;
  VectorXd largest = VectorXd::Zero(dials);
  for (const session::Sample& sample : session.samples) {
    for (Index k = 0; k < dials && k < std::ssize(sample.channels); ++k) {
      const auto& value = sample.channels[static_cast<std::size_t>(k)].value;
      if (value && std::isfinite(*value)) {
        largest[k] = std::max(largest[k], std::abs(*value));
      }
    }
  }
  return (kOfLargest * largest).cwiseMin(kNoContact_mm);
}

/// The readings that a plunger in contact may have shown; NaN: none.
VectorXd shown_by(const session::Sample& sample, const VectorXd& no_contact) {
  const Index dials = no_contact.size();
  VectorXd values = VectorXd::Constant(dials, kNone);
  for (Index k = 0; k < dials && k < std::ssize(sample.channels); ++k) {
    const session::ChannelValue& each = sample.channels[static_cast<std::size_t>(k)];
    const bool good = each.value && std::isfinite(*each.value) &&
                      each.quality != session::Quality::kBad &&
                      std::abs(*each.value) > no_contact[k];
    if (good) values[k] = *each.value;
  }
  return values;
}

Table table_of(const session::Session& session, geometry::Assembly assembly) {
  geometry::Rig rig = session.rig;
  rig.instrument.kind = "dials_on_cuboid";
  Table table;
  table.model = std::make_shared<const simulation::ForwardModel>(rig);
  table.free = !table.model->instrument().unknowns.empty();
  table.scale.resize(table.model->parameter_count());
  for (Index i = 0; i < table.scale.size(); ++i) {
    const auto& parameter = table.model->parameters()[static_cast<std::size_t>(i)];
    table.scale[i] = kPlausibleChanges * parameter.change;
  }
  const auto dials = static_cast<Index>(rig.dials.size());
  const VectorXd least = no_contact(session, dials);
  std::vector<VectorXd> shown;
  for (const std::size_t row : looked_rows(session, kMostSamples)) {
    const session::Sample& sample = session.samples[row];
    VectorXd values = shown_by(sample, least);
    if ((values.array() == values.array()).count() < 2) continue;
    const geometry::JointPose pose{
        sample.q, assembly_by_target(rig, sample).value_or(assembly)};
    auto expected =
        expected_at(table, pose, table.free ? std::optional<double>(0.0) : std::nullopt);
    if (!expected) continue;
    shown.push_back(std::move(values));
    table.pose.push_back(pose);
    table.expected.push_back(*std::move(expected));
  }
  table.shown.resize(std::ssize(shown), dials);
  table.nominal.resize(std::ssize(shown), dials);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    table.shown.row(static_cast<Index>(i)) = shown[i].transpose();
    table.nominal.row(static_cast<Index>(i)) = table.expected[i].reading.transpose();
  }
  return table;
}

/// Middle distance from the middle; of too few values nothing.
double spread_of(std::vector<double> values) {
  if (std::ssize(values) < kFewestReadings) return kNone;
  const double middle = geometry::median_of(values);
  for (double& each : values) each = std::abs(each - middle);
  return kToSigma * geometry::median_of(std::move(values));
}

/// How a column in a unit differs from what a dial should show, apart from a constant.
double unlike(const Table& table, Index column, Index dial, double mm_per_unit) {
  std::vector<double> differences;
  for (Index i = 0; i < table.samples(); ++i) {
    const double d = mm_per_unit * table.shown(i, column) - table.nominal(i, dial);
    if (std::isfinite(d)) differences.push_back(d);
  }
  return spread_of(std::move(differences));
}

struct Pairing {
  double spread_mm = kNone;
  double mm_per_unit = 1.0;
  double offset_mm = 0.0;
};

/// Where a dial that counts the other way begins; empty: this one reads below zero, which is
/// another matter.
std::optional<double> reversed_from(const Table& table, Index column, Index dial) {
  std::vector<double> sums, shown;
  for (Index i = 0; i < table.samples(); ++i) {
    if (!std::isfinite(table.shown(i, column))) continue;
    shown.push_back(table.shown(i, column));
    sums.push_back(table.shown(i, column) + table.nominal(i, dial));
  }
  if (shown.empty() || geometry::median_of(shown) < 0.0) return std::nullopt;
  return geometry::median_of(std::move(sums));
}

/// The unit that lets a column be this dial best; millimetres unless another is clearly better.
Pairing pairing_of(const Table& table, Index column, Index dial) {
  Pairing best{unlike(table, column, dial, 1.0), 1.0};
  for (const Unit& unit : kUnits) {
    const double spread_mm = unlike(table, column, dial, unit.mm);
    if (kClearly * std::max(spread_mm, kFloor_mm) < unlike(table, column, dial, 1.0) &&
        spread_mm < best.spread_mm) {
      best = {spread_mm, unit.mm};
    }
  }
  const double reversed_mm = unlike(table, column, dial, kReversed);
  if (kClearly * std::max(reversed_mm, kFloor_mm) < best.spread_mm) {
    const auto from = reversed_from(table, column, dial);
    if (from) best = {reversed_mm, kReversed, *from};
  }
  return best;
}

using Orders = std::vector<std::vector<int>>;

/// Orders of n dials: all, or, of many dials, pairs and threes exchanged.
Orders orders_of(std::size_t n) {
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  Orders orders{order};
  if (n <= kAllOrders) {
    while (std::ranges::next_permutation(order).found) orders.push_back(order);
    return orders;
  }
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      std::vector<int> pair = order;
      std::swap(pair[a], pair[b]);
      orders.push_back(pair);
      for (std::size_t c = b + 1; c < n; ++c) {
        std::vector<int> three = pair;
        std::swap(three[b], three[c]);
        orders.push_back(three);
        three = pair;
        std::swap(three[a], three[c]);
        orders.push_back(three);
      }
    }
  }
  return orders;
}

/// The fit's rows of one sample: what is left, and the slope of it.
struct Equations {
  MatrixXd A;
  VectorXd b;
  std::vector<int> column;  // of each row
};

/// One sample under a hypothesis: which columns have a reading, what each is in millimetres and
/// which dial it is said to be.
struct Said {
  std::vector<int> columns, dials;
  VectorXd mm;
};
Said said_at(const Table& table, Index sample, const DialHypothesis& is) {
  Said said;
  std::vector<double> mm;
  for (Index k = 0; k < table.dials(); ++k) {
    if (!std::isfinite(table.shown(sample, k))) continue;
    const auto column = static_cast<std::size_t>(k);
    said.columns.push_back(static_cast<int>(k));
    said.dials.push_back(is.shows[column]);
    mm.push_back(is.mm_per_unit[column] * table.shown(sample, k) + is.offset_mm[column]);
  }
  said.mm = Eigen::Map<const VectorXd>(mm.data(), std::ssize(mm));
  return said;
}

/// A freely held cuboid at the turn that suits what is said best, which then goes out of this
/// sample's rows: it is nobody's error.
Expected turned_to(const Table& table, std::size_t sample, const Said& said) {
  Expected at = table.expected[sample];
  double gamma_rad = 0.0;
  for (int step = 0; step < kTurnSteps; ++step) {
    const VectorXd g = at.by_gamma(said.dials);
    const double change = g.dot(said.mm - at.reading(said.dials)) / g.squaredNorm();
    if (!std::isfinite(change)) break;
    gamma_rad = std::clamp(gamma_rad + change, -kMostTurned_rad, kMostTurned_rad);
    const auto next = expected_at(table, table.pose[sample], gamma_rad);
    if (!next) break;
    at = *next;
  }
  return at;
}

/// All parameters of the robot, the mounts of the columns, from nominal.
Equations equations_of(const Table& table, const DialHypothesis& is) {
  const Index parameters = table.scale.size();
  const Index rows = (table.shown.array() == table.shown.array()).count();
  Equations all{MatrixXd::Zero(rows, parameters + table.dials()), VectorXd::Zero(rows), {}};
  Index row = 0;
  for (Index i = 0; i < table.samples(); ++i) {
    const auto sample = static_cast<std::size_t>(i);
    const Said said = said_at(table, i, is);
    const Expected at = table.free ? turned_to(table, sample, said) : table.expected[sample];
    auto A = all.A.middleRows(row, said.mm.size());
    auto b = all.b.segment(row, said.mm.size());
    b = said.mm - at.reading(said.dials);
    A.leftCols(parameters) = at.slope(said.dials, Eigen::all);
    for (Index k = 0; k < b.size(); ++k) {
      A(k, parameters + said.columns[static_cast<std::size_t>(k)]) = kMount_mm;
    }
    all.column.insert(all.column.end(), said.columns.begin(), said.columns.end());
    row += b.size();
    if (!table.free) continue;
    const VectorXd g = at.by_gamma(said.dials).normalized();
    if (!g.allFinite()) continue;
    A -= (g * (g.transpose() * A)).eval();
    b -= (g * g.dot(b)).eval();
  }
  return all;
}

/// What a hypothesis leaves of each column [mm], after a fit in which few wrong columns do not
/// drag the others along.
std::vector<double> left_by(const Table& table, const DialHypothesis& is) {
  const Equations all = equations_of(table, is);
  const Index n = all.A.cols();
  VectorXd weight = VectorXd::Ones(all.b.size());
  VectorXd left = all.b;
  for (int round = 0; round < kReweighted; ++round) {
    // Every unknown is known to one plausible change, every reading to the floor.
    MatrixXd N = kFloor_mm * kFloor_mm * MatrixXd::Identity(n, n);
    N += all.A.transpose() * weight.asDiagonal() * all.A;
    const VectorXd x = N.ldlt().solve(all.A.transpose() * weight.cwiseProduct(all.b));
    left = all.b - all.A * x;
    weight = (left.array().abs() / kFloor_mm).max(1.0).inverse();
  }
  std::vector<double> by_column;
  for (int k = 0; k < table.dials(); ++k) {
    std::vector<double> sizes;
    for (Index row = 0; row < left.size(); ++row) {
      if (all.column[static_cast<std::size_t>(row)] == k) sizes.push_back(std::abs(left[row]));
    }
    by_column.push_back(
        std::ssize(sizes) < kFewestReadings ? kNone
                                            : kToSigma * geometry::median_of(std::move(sizes)));
  }
  return by_column;
}

double cost_of(const std::vector<double>& left_mm) {
  double sum = 0.0;
  for (const double each : left_mm) {
    if (std::isfinite(each)) sum += std::log(std::max(each, kFloor_mm));
  }
  return sum;
}

DialHypothesis as_the_file_says(Index dials) {
  DialHypothesis is{
      std::vector<int>(static_cast<std::size_t>(dials)),
      std::vector<double>(static_cast<std::size_t>(dials), 1.0),
      std::vector<double>(static_cast<std::size_t>(dials), 0.0)};
  std::iota(is.shows.begin(), is.shows.end(), 0);
  return is;
}

/// The orders that look best before any fit, each with the units that suit it.
std::vector<DialHypothesis> likely(const Table& table) {
  const auto n = static_cast<std::size_t>(table.dials());
  std::vector<std::vector<Pairing>> pairings(n);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      pairings[k].push_back(pairing_of(table, static_cast<Index>(k), static_cast<Index>(j)));
    }
  }
  std::vector<std::pair<double, DialHypothesis>> ranked;
  for (std::vector<int>& order : orders_of(n)) {
    double cost = 0.0;
    std::vector<double> units, offsets;
    for (std::size_t k = 0; k < n; ++k) {
      const Pairing& each = pairings[k][static_cast<std::size_t>(order[k])];
      if (std::isfinite(each.spread_mm)) cost += std::log(std::max(each.spread_mm, kFloor_mm));
      if (each.mm_per_unit == kReversed) cost += kLessLikely;
      units.push_back(each.mm_per_unit);
      offsets.push_back(each.offset_mm);
    }
    ranked.emplace_back(
        cost, DialHypothesis{std::move(order), std::move(units), std::move(offsets)});
  }
  std::ranges::stable_sort(ranked, {}, &std::pair<double, DialHypothesis>::first);
  std::vector<DialHypothesis> result{as_the_file_says(table.dials())};
  for (auto& [cost, hypothesis] : ranked) {
    if (result.size() > kTried) break;
    result.push_back(std::move(hypothesis));
  }
  return result;
}

/// Every column that is said to be something else fits so much better that nobody would doubt.
bool clear(const DialJudgement& judged, std::size_t columns) {
  bool changed = false;
  double gained = 0.0;
  double needed = 0.0;
  for (std::size_t k = 0; k < columns; ++k) {
    const double before = judged.as_is_mm[k];
    const double after = judged.best_mm[k];
    if (!std::isfinite(before) || !std::isfinite(after)) continue;
    gained += std::log(std::max(before, kFloor_mm) / std::max(after, kFloor_mm));
    const bool other =
        judged.best.shows[k] != static_cast<int>(k) || judged.best.mm_per_unit[k] != 1.0;
    if (!other) continue;
    if (after > kOff_mm) return false;
    // A unit that makes figures smaller makes what they miss by smaller too.
    const double mm = judged.best.mm_per_unit[k];
    if (mm > 0.0 && mm < 1.0 && before < kClearly * after / mm) return false;
    changed = changed || before > kOff_mm;
    needed += std::log(kClearly);
  }
  return changed && gained > needed;
}

}  // namespace

bool DialHypothesis::exchanged() const {
  for (std::size_t k = 0; k < shows.size(); ++k) {
    if (shows[k] != static_cast<int>(k)) return true;
  }
  return false;
}

std::string_view unit_of(double mm_per_unit) {
  for (const Unit& unit : kUnits) {
    if (unit.mm == mm_per_unit) return unit.name;
  }
  return "";
}

std::optional<DialJudgement> judge_dials(const session::Session& session) {
  if (session.rig.dials.size() < 2) return std::nullopt;
  std::optional<DialJudgement> best;
  double least = 0.0;
  for (const geometry::BranchInfo& branch : session.rig.robot.model->assemblies) {
    Table table;
    try {
      table = table_of(session, static_cast<geometry::Assembly>(branch.number));
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // this rig cannot have dials; whoever needs them says why
    }
    if (table.samples() < kFewestReadings) continue;
    std::vector<double> as_is;
    for (DialHypothesis& each : likely(table)) {
      std::vector<double> left = left_by(table, each);
      const double cost = cost_of(left) + kLessLikely * static_cast<double>(std::ranges::count(
                                                            each.mm_per_unit, kReversed));
      if (as_is.empty()) as_is = left;
      if (best && cost >= least) continue;
      least = cost;
      best = DialJudgement{std::move(each), as_is, std::move(left)};
    }
  }
  if (!best || !clear(*best, session.rig.dials.size())) return std::nullopt;
  return best;
}

}  // namespace sixdial::studies::plausibility
