// How much the readings scatter by themselves, and whether what is left is more than that.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/uncertainty.h"
#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

using calibration::NoiseSource;

struct Noise {
  NoiseSource source = NoiseSource::kRigFile;
  double sigma_mm = 0.0;
  int degrees_of_freedom = 0;  // 0: taken as known
};

/// Noise from repeated points, gross readings left out, if there are enough; else from the rig
/// file. Of all dials together, or of one.
[[nodiscard]] Noise noise_of(
    const Readings& readings, const JointFit& fit, std::optional<std::size_t> only = {});

/// A dial that scatters more than it should, and more than the others.
struct NoisyDial {
  std::string dial;
  double sigma_mm = 0.0;
  double expected_mm = 0.0;  // by its repeats, else by the rig file
};

/// Scatter without structure: of each arrival of the tool, of the recorded joint values, or of
/// each reading alone.
enum class ScatterIn { kTool, kJoints, kReadings };
/// Its size: a standard deviation with a 95 % interval. In the tool: of x and of y; in joints:
/// what it moves the tool by, likewise; in readings: what is there besides the noise.
struct ScatterFound {
  ScatterIn in = ScatterIn::kTool;
  double sd_mm = 0.0, low_mm = 0.0, high_mm = 0.0;
};

struct Scatter {
  bool of_all = false;                // of the dials that do not stand out, together
  std::optional<ScatterFound> found;  // the size of it, or of what arrivals share
  std::vector<NoisyDial> dials;       // that stand out
};
/// Compares what the fit leaves with the noise. What readings of an arrival share is scatter
/// whatever the noise is: the fit has weighed it against none.
[[nodiscard]] Scatter scatter_of(
    const Readings& readings, const JointFit& fit, const Noise& noise);

}  // namespace sixdial::diagnosis
