// Which shifts the readings of an arrival could share: of the tool, whose place a robot does
// not repeat, or of the joints, whose recorded values are not where they stood.
#pragma once

#include <memory>
#include <vector>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

/// All that this session could tell, with the robot at `at`. Without dials a shift of the tool
/// is not to be told from each reading's own noise, which is as large in all poses; scatter of
/// the joint values is, as it moves the tool more in some poses and directions than in others.
/// Empty where too few readings are left over.
[[nodiscard]] std::vector<std::shared_ptr<const ScatterColumns>> shareable_columns(
    const Readings& readings, const simulation::ModelVector& at);

/// Whether two rows were read at one pose: joint values alike, come to from the same sides.
[[nodiscard]] bool at_same_pose(const Readings& readings, Eigen::Index a, Eigen::Index b);

/// What a fit leaves, shared part and all, with the weight of each reading and its noise over
/// the common one.
struct LeftAtRepeats {
  const Eigen::VectorXd& residual_mm;
  const Eigen::VectorXd& weight;
  const Eigen::VectorXd& noise;
};
/// True if repeats of a pose that came by themselves differ by much less than other readings
/// do: most of what is left comes back at each visit, and is no scatter.
[[nodiscard]] bool comes_back(
    const Readings& readings, const ScatterColumns& columns, const LeftAtRepeats& left);

/// What a shift of one unit in each shared direction moves the tool by, root mean square of one
/// coordinate [mm].
[[nodiscard]] double tool_motion_mm(
    const Readings& readings, const simulation::ModelVector& at, ScatterOf of);

}  // namespace sixdial::diagnosis
