// Fits that a search comes back to: of an explanation less one of its parts, which is asked for
// by one rule after the other. The same question has the same answer, to the last bit.
#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

class KnownFits {
 public:
  /// fit_jointly, or what it answered before. `readings` are the same in every call, and have
  /// not changed. Several threads may ask at once.
  [[nodiscard]] JointFit fit(
      const Readings& readings, const simulation::ModelVector& start,
      std::vector<simulation::ActiveEffect> effects, const JointFit* near,
      const Eigen::MatrixXd& random);
  /// How often somebody asked, and how often that took a fit.
  [[nodiscard]] std::int64_t asked() const { return asked_; }
  [[nodiscard]] std::int64_t fitted() const { return fitted_; }

 private:
  /// All that an answer depends on beside the readings.
  struct Question {
    simulation::ModelVector start;
    std::vector<simulation::ActiveEffect> effects;
    bool near = false;
    double near_s_mm = 0.0, near_gross_share = 0.0, near_shared_ratio = 0.0;
    std::shared_ptr<const ScatterColumns> near_shared;
    Eigen::MatrixXd random;
    [[nodiscard]] bool operator==(const Question& other) const;
  };
  struct Known {
    Question question;
    JointFit fit;
    double bytes;
  };

  [[nodiscard]] static double bytes_of(const Question& question, const JointFit& fit);

  std::mutex using_;
  std::list<Known> known_;  // newest first
  double bytes_ = 0.0;
  std::atomic<std::int64_t> asked_ = 0, fitted_ = 0;
};

}  // namespace sixdial::diagnosis
