// The map of a plan in letters: which points are done, which are suspect, where the tool is
// next.
#pragma once

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "service/error.h"

namespace sixdial::cli {

class PlanMap {
 public:
  /// Rows of session.plan.
  void add(const Json& points);
  /// A sample event: done, or suspect where it has a doubt.
  void take_sample(const Json& sample);
  /// "open", "done", "suspect" or "left" (skipped), of {set, point, repeat}.
  void mark(const Json& point, const std::string& state);
  [[nodiscard]] bool empty() const { return points_.empty(); }

  /// `height` lines of at most `width` letters, the last ones the legend; `next`: the point
  /// in hand, or null. Empty where there is no room.
  [[nodiscard]] std::vector<std::string> lines(
      std::size_t width, std::size_t height, const Json& next) const;

 private:
  struct Point {
    double x_mm = 0.0, y_mm = 0.0;
    std::string state;
  };
  using Key = std::tuple<std::string, int, int>;
  static Key key_of(const Json& point);
  std::map<Key, Point> points_;
};

}  // namespace sixdial::cli
