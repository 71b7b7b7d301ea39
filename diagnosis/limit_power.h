// How often an effect of a given size would be found, and named rightly, over drawn noise and
// directions (limits.h).
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/drawn_noise.h"
#include "diagnosis/evidence.h"
#include "diagnosis/naming.h"
#include "diagnosis/unnamed_rival.h"

namespace sixdial::diagnosis {

inline constexpr int kLimitDraws = 160;  // near 80 % a power has a standard deviation of 3 %

/// A hypothesis' weighted columns at one searched value. P takes off what the fit explains; the
/// product of two hypotheses' columns C and D is C'PD, which is weighted' x projected. Not
/// projected' x projected: random columns of the fit have priors, so that P P is not P.
struct LimitColumns {
  Eigen::MatrixXd weighted;
  Eigen::MatrixXd projected;
  Eigen::MatrixXd noise;    // weighted' x noise, one column a draw
  Eigen::VectorXd sizes;    // a plausible size of each column's parameter
  bool one_sided = false;   // none of them can be negative
  Eigen::MatrixXd normal;   // weighted' x projected
  Eigen::MatrixXd inverse;  // of it
  MarginalEvidence evidence;
  [[nodiscard]] Eigen::VectorXd squares_of_plausible() const {
    return (normal.diagonal().array() * sizes.array().square()).max(0.0).matrix();
  }
};

/// A hypothesis at a few searched values.
struct SeenEffect {
  Hypothesis hypothesis;
  std::vector<LimitColumns> values;
  double surviving = 1.0;
  double searched = 1.0;  // values, of which a few are here
  double tries = 1.0;     // of its search
  Eigen::VectorXd raw;    // first parameter's column, weighted, not projected
};

/// A rival at the searched value that takes most of the signal over.
struct LimitRival {
  const SeenEffect* seen;
  std::vector<const LimitColumns*> at;  // for each value of the one that is there
  std::vector<Eigen::MatrixXd> cross;   // its columns' x those of the one that is there
  std::vector<double> cost;             // of its search
  double evidence = 0.0;                // of a signal that is well seen, at most
};

/// What does best of its kind, without a name, what one value of an effect does.
struct BestUnnamed {
  const UnnamedRival* of = nullptr;
  UnnamedRival::Shared shared;
  double score = 0.0;
};
/// One effect against its rivals, by the linear evidence that the search starts from. What only
/// one of the questions needs is not worked out for the others.
class LimitPower {
 public:
  /// What all effects of a session share.
  struct Study {
    const Projector& projector;
    const DrawnNoise& noise;
    const NamingSettings& settings;
    double catalogue;   // hypotheses that the search tries
    double prior_cost;  // of one among so many
  };
  /// `unnamed`: by value of the effect, the best of each kind.
  struct Against {
    std::vector<double> own_cost;  // of its search, by value
    std::vector<LimitRival> rivals;
    std::vector<std::vector<BestUnnamed>> unnamed;
  };
  LimitPower(const Study& study, const SeenEffect& own, Against against)
      : study_(study), own_(own), against_(std::move(against)) {}

  /// How often something is found where it is, so many plausible sizes large.
  [[nodiscard]] double detected(double times) const;
  /// How often it is named for certain, and rightly.
  [[nodiscard]] double named(double times) const;
  /// The rival that is as good in most draws; null without rivals.
  [[nodiscard]] const LimitRival* worst_rival(double times) const;

 private:
  /// An effect as large as asked, in one draw of noise and direction.
  struct Draw {
    int number;
    std::size_t value;  // number of the searched value
    Eigen::VectorXd x;
    Eigen::VectorXd right;  // what its own columns see
    double sse;
    double evidence;  // of the effect itself
  };
  /// What a rival makes of a draw.
  struct RivalSeen {
    Eigen::VectorXd right;
    double evidence;
  };
  using AllSeen = std::vector<std::optional<RivalSeen>>;

  [[nodiscard]] Draw drawn(double times, int number) const;
  /// Empty where its size could not be.
  [[nodiscard]] std::optional<RivalSeen> seen_by(const LimitRival& rival, const Draw& of) const;
  [[nodiscard]] double evidence_of(const BestUnnamed& each, const Draw& of) const;
  /// Whether chance alone rarely does as well as these columns at the best value of their
  /// search, anywhere in the catalogue.
  [[nodiscard]] bool is_rare(
      const SeenEffect& of, const LimitColumns& at, const Eigen::VectorXd& right,
      double sse) const;
  /// Whether the search would take a draw up (growing.cpp), where no reading is gross: it is
  /// worth something, and by chance alone rarely the best of the whole catalogue. `best`: the
  /// most evidence of all.
  [[nodiscard]] bool is_told(const Draw& of, const AllSeen& seen, double best) const;

  const Study& study_;
  const SeenEffect& own_;
  Against against_;
};

}  // namespace sixdial::diagnosis
