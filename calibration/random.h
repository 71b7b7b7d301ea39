// Random numbers by counter (Philox, Salmon et al. 2011): the number at a place is a pure
// function of seed and place, whoever asks for it, in whatever order, on however many threads.
#pragma once

#include <Random123/philox.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace sixdial::calibration {

/// Four 32-bit words that belong to (seed; a, b, c, stream).
[[nodiscard]] inline std::array<std::uint32_t, 4> random_words(
    std::uint64_t seed, std::uint32_t a, std::uint32_t b, std::uint32_t c,
    std::uint32_t stream) {
  const r123::Philox4x32 generator;
  const r123::Philox4x32::key_type key{
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  const auto words = generator(r123::Philox4x32::ctr_type{{a, b, c, stream}}, key);
  return {words[0], words[1], words[2], words[3]};
}

/// In the open interval (0, 1), 53 bits.
[[nodiscard]] inline double open_unit(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 12;
  return (static_cast<double>(bits) + 0.5) * 0x1p-52;
}

/// In the open interval (0, 1), 32 bits.
[[nodiscard]] inline double open_unit(std::uint32_t word) {
  return (static_cast<double>(word) + 0.5) * 0x1p-32;
}

/// Standard normal (Box-Muller), belonging to (seed; a, b, c, stream).
[[nodiscard]] inline double random_normal(
    std::uint64_t seed, std::uint32_t a, std::uint32_t b, std::uint32_t c,
    std::uint32_t stream) {
  const auto w = random_words(seed, a, b, c, stream);
  return std::sqrt(-2.0 * std::log(open_unit(w[0], w[1]))) *
         std::cos(2.0 * std::numbers::pi * open_unit(w[2], w[3]));
}

/// Numbers in order from one seed, for code that draws them one after the other.
class RandomSequence {
 public:
  explicit RandomSequence(std::uint64_t seed, std::uint32_t stream = 0)
      : seed_(seed), stream_(stream) {}
  [[nodiscard]] double uniform() {
    const auto w = next();
    return open_unit(w[0], w[1]);
  }
  [[nodiscard]] double uniform(double low, double high) {
    return low + (high - low) * uniform();
  }
  [[nodiscard]] double normal() {
    const std::uint64_t k = count_++;
    return random_normal(
        seed_, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(k >> 32), 1, stream_);
  }
  /// 0 .. n-1.
  [[nodiscard]] int below(int n) {
    const int k = static_cast<int>(uniform() * n);
    return k < n ? k : n - 1;
  }

 private:
  [[nodiscard]] std::array<std::uint32_t, 4> next() {
    const std::uint64_t k = count_++;
    return random_words(
        seed_, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(k >> 32), 0, stream_);
  }

  std::uint64_t seed_;
  std::uint32_t stream_;
  std::uint64_t count_ = 0;
};

}  // namespace sixdial::calibration
