// One pose after the other for a plan of a robot that works in space: tried against the nominal
// robot, its branch and the ranges of its joints. Shared by the planners (plan_in_space.h,
// plan_at_sockets.h).
#pragma once

#include <optional>
#include <string>

#include "geometry/tool.h"
#include "session/plan.h"
#include "session/plan_draw.h"
#include "session/plan_in_space.h"

namespace sixdial::session {

/// A pose or why it is none.
struct TriedPose {
  std::optional<PlanPose> pose;
  Position target_mm;
  std::string why;
  bool reached = false;  // the robot can put its tool there, whatever speaks against it
};

/// The nominal robot, its tool always with three coordinates. The rig must outlive it.
class PlannerInSpace {
 public:
  PlannerInSpace(const geometry::Rig& rig, geometry::WorkingMode mode);

  /// Uniform over the ranges of the joints.
  [[nodiscard]] Eigen::VectorXd drawn_joints(Uniform& random) const;
  [[nodiscard]] TriedPose of_joints(const Eigen::VectorXd& exact) const;
  /// With the tool turned as it comes from these joint values; empty: as it comes.
  [[nodiscard]] TriedPose as_it_comes(
      const Eigen::Vector3d& target, const Eigen::VectorXd& from) const;
  /// With the tool turned as at `near`.
  [[nodiscard]] TriedPose turned_as(
      const Eigen::Vector3d& target, const Eigen::VectorXd& near) const;
  /// With the tool there, of several ways to stand the one whose joints are farthest from the
  /// ends of their ranges.
  [[nodiscard]] TriedPose with_most_room(const Eigen::Vector3d& target) const;
  /// Whether rig.toml lists the joints (lists_its_joints).
  [[nodiscard]] bool listed() const { return listed_; }

 private:
  [[nodiscard]] const geometry::JointInfo& info(Eigen::Index k) const {
    return tool_.robot().joints[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] TriedPose refused(const Eigen::Vector3d& target, std::string why) const;
  /// The least share of its range that a joint has to the nearer end.
  [[nodiscard]] double room(const Eigen::VectorXd& q) const;
  [[nodiscard]] std::string beyond_range(const Eigen::VectorXd& q) const;

  const geometry::Rig& rig_;
  geometry::WorkingMode mode_;
  geometry::Tool tool_;
  int axes_;
  bool listed_;
};

}  // namespace sixdial::session
