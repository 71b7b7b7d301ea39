// A small bundle to bend: text of rig.toml and session.csv, and what a broken one says.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "session/bundle.h"
#include "session/rig_file.h"

namespace sixdial::session {

inline std::string small_rig() { return write_rig(geometry::default_rig()); }

inline const std::string kHeader =
    "set,point,repeat,time_utc,theta1_rad,theta2_rad,target_x_mm,target_y_mm,approach1,"
    "approach2,temperature_c,dial_A_mm,dial_B_mm,dial_C_mm,dial_D_mm,dial_E_mm,dial_F_mm";
inline const std::string kRow0 =
    "G1,0,0,2026-03-02T08:30:08.805Z,1.509623367,3.069803861,18.402564,54.249290,0,0,20.03,"
    "8.513,25.194,12.559,7.666,21.148,26.045";
inline const std::string kRow1 =
    "G1,1,0,2026-03-02T08:30:17.693Z,1.411917868,2.880616311,24.408706,62.417123,-1,-1,20.07,"
    "14.486,18.065,4.275,1.509,28.274,31.040";

inline Session parse(const std::string& csv, const ReadOptions& options = {}) {
  return parse_session(csv, "session.csv", small_rig(), "rig.toml", options);
}

/// Text with the first `old` replaced.
inline std::string with(std::string text, const std::string& old, const std::string& fresh) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  if (at != std::string::npos) text.replace(at, old.size(), fresh);
  return text;
}

template <typename Action>
DataError error_of(Action action) {
  try {
    action();
  } catch (const DataError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return DataError("nothing", Mistake{});
}

}  // namespace sixdial::session
