// Where the axes of a mock machine stand: straight moves one behind the other, each at its
// feed. Degrees or millimetres, seconds.
#pragma once

#include <deque>
#include <vector>

namespace sixdial::mock_devices {

class AxisTrack {
 public:
  explicit AxisTrack(std::vector<double> at) : at_(std::move(at)) {}

  /// Behind what is there already, not before `time_s`; `speed` per second along the way.
  void append(const std::vector<double>& to, double speed, double time_s);
  /// The axes stand where they are; moves behind are dropped.
  void stop(double time_s);
  [[nodiscard]] std::vector<double> position(double time_s) const;
  /// Where all moves end.
  [[nodiscard]] const std::vector<double>& end() const {
    return legs_.empty() ? at_ : legs_.back().to;
  }
  [[nodiscard]] double end_s() const { return legs_.empty() ? 0.0 : legs_.back().end_s; }
  [[nodiscard]] bool moves(double time_s) const;
  /// Per second; 0: it stands.
  [[nodiscard]] double speed(double time_s) const;

 private:
  struct Leg {
    std::vector<double> from, to;
    double start_s = 0.0, end_s = 0.0, speed = 0.0;
  };
  std::vector<double> at_;  // where the legs begin
  std::deque<Leg> legs_;
};

}  // namespace sixdial::mock_devices
