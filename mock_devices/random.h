// Random numbers that depend on seed, stream and counter alone (Philox), never on who asked
// first: a dial's noise at a given tick is the same however often and by how many threads it is
// read.
#pragma once

#include <cstdint>

namespace sixdial::mock_devices {

/// What a number is drawn for; numbers of different streams are independent.
enum class Stream : std::uint32_t {
  kRobot,
  kClamp,
  kCurve,
  kEndStop,
  kSettling,
  kRate,
  kNoise,
  kOutlier,
  kStale,
  kField,
  kWalk,
  kHide,
  kNoiseByte,
  kBefore,   // where things stood before the first move
  kScatter,  // how far an arrival is off
  kWorkshop,
};

class Random {
 public:
  Random(std::uint64_t seed, Stream stream, std::uint32_t place = 0)
      : seed_(seed), stream_(static_cast<std::uint32_t>(stream)), place_(place) {}

  /// In (0, 1).
  [[nodiscard]] double uniform(std::uint64_t counter) const;
  [[nodiscard]] double uniform(std::uint64_t counter, double low, double high) const;
  /// Mean 0, standard deviation 1.
  [[nodiscard]] double normal(std::uint64_t counter) const;

 private:
  std::uint64_t seed_;
  std::uint32_t stream_;
  std::uint32_t place_;
};

}  // namespace sixdial::mock_devices
