// What a terminal shows of a running collection: samples roll by; below them stay the six dials
// in large digits with their state, the estimate, and the progress line. Off a terminal: lines.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/collect_keys.h"
#include "cli/console.h"
#include "cli/plan_map.h"
#include "service/error.h"
#include "studies/live_estimate.h"

namespace sixdial::cli {

/// "G1 12.0  x 23.412  y 37.871 mm  A 10.490 ...; remarks".
[[nodiscard]] std::string sample_line(const Json& sample);
/// The data of a live event in large digits, three dials a row, and the pose; in plain ones, as
/// many a row as fit, where the terminal is too narrow for that. Each line has at most `width`
/// letters.
[[nodiscard]] std::vector<std::string> dial_lines(const Json& live, std::size_t width);
/// Live readings only where they can be shown in place.
[[nodiscard]] std::vector<std::string> screen_topics(const Console& console);

/// Lines above the progress line that are rewritten in place on a terminal.
class ScreenBlock {
 public:
  explicit ScreenBlock(const Console& console) : console_(console) {}
  void set(std::vector<std::string> lines) { lines_ = std::move(lines); }
  /// What to send so that the terminal shows the lines; empty if it shows them already.
  [[nodiscard]] std::string drawn();
  /// What takes them away again while the cursor stands in the line below them.
  [[nodiscard]] std::string erased();

 private:
  const Console& console_;
  std::vector<std::string> lines_;
  std::vector<std::size_t> on_screen_;  // letters of each line
};

/// Each change of the screen is one write between the marks of synchronized output (DEC private
/// mode 2026). A large one still reaches the terminal in pieces of 4 kB; a terminal that knows
/// the marks shows nothing of it before its end, others ignore them.
class Screen {
 public:
  explicit Screen(const Console& console)
      : console_(console), block_(console), line_(console) {}

  void show_state(const Json& state);
  void show_sample(const Json& sample);
  void show_dials(const Json& live);
  /// Rows of session.plan, for the map.
  void show_plan(const Json& points) { map_.add(points); }
  /// What stands above the progress line in a terminal of this size.
  [[nodiscard]] std::vector<std::string> lines(std::size_t width, std::size_t height) const;
  void note(const std::string& text);
  void end();

 private:
  void redraw();
  void send(const std::string& bytes) const;
  void show_block();
  [[nodiscard]] std::string drawn();
  [[nodiscard]] std::string erased();

  const Console& console_;
  ScreenBlock block_;
  ProgressLine line_;
  Json live_, state_;
  std::optional<studies::EstimateSummary> estimate_;
  PlanMap map_;
};

}  // namespace sixdial::cli
