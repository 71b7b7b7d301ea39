// A session of poses and its calibration, made once for all tests of a suite.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "session/bundle.h"
#include "studies/calibrate.h"
#include "tests/support/pose_session.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::testing {

/// Written as files and read again, as a user's are.
inline session::Session through_files(const session::Session& session) {
  const TempDirectory directory;
  const auto folder = directory.path() / "poses";
  session::write_bundle(session, folder);
  return session::read_bundle(folder.string());
}

class CalibratedPoses : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    poses = std::make_unique<PoseSession>(pose_session());
    poses->session = through_files(poses->session);
    calibrated = std::make_unique<studies::CalibrationResult>(
        studies::calibrate(poses->session, {.method = "lm"}));
  }
  static void TearDownTestSuite() {
    poses.reset();
    calibrated.reset();
  }

  static inline std::unique_ptr<PoseSession> poses;
  static inline std::unique_ptr<studies::CalibrationResult> calibrated;
};

}  // namespace sixdial::testing
