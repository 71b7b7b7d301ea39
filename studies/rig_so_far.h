// The rig as the samples of a session that still grows see it: the fit that `calibrate` makes
// before anything else (diagnosis/rig_fit.h), made anew whenever there are a fifth more of
// them, and what it leaves open of the rig. Where the rig file states nothing of itself, or the
// samples are too few or contradict it, the rig stays the file's; what is stated counts in
// full.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "diagnosis/rig_fit.h"
#include "session/session.h"
#include "simulation/trial.h"

namespace sixdial::studies {

class RigSoFar {
 public:
  explicit RigSoFar(const geometry::Rig& file);

  /// Keeps a sample of G1; one of the same point and repeat takes the place of an earlier one.
  void add(const session::Sample& sample);
  /// In the order in which they came.
  [[nodiscard]] const std::vector<session::Sample>& samples() const { return samples_; }
  /// Enough samples are new since the last fit.
  [[nodiscard]] bool is_due() const;
  /// Fits the rig to the samples so far; true if rig() is another one now. Throws
  /// geometry::WorkEnded, and leaves all as it was.
  bool fit();
  /// The same by samples of all sets that are added only later.
  bool fit(std::span<const session::Sample> samples);

  [[nodiscard]] const geometry::Rig& rig() const { return seen_ ? seen_->rig : file_; }
  /// Empty: rig() is the file's.
  [[nodiscard]] const std::optional<diagnosis::RigFit>& seen() const { return seen_; }

  struct Measured {
    simulation::Trial trial;  // by rig()
    /// Change of its position [mm] where each thing that is not known of the rig is off by a
    /// standard deviation: axes x things, the same ones for all samples. Empty: all is known.
    Eigen::MatrixXd shared{};
  };
  [[nodiscard]] std::vector<Measured> measured(std::span<const session::Sample> samples) const;

 private:
  geometry::Rig file_;
  bool states_;  // something of itself
  std::vector<session::Sample> samples_;
  std::optional<diagnosis::RigFit> seen_;
  Eigen::MatrixXd open_root_;  // of seen_
  std::size_t next_;           // number of samples
};

}  // namespace sixdial::studies
