// What a command prints: data on stdout, everything else on stderr, JSON with a schema version
// on request, colour and progress bars only where a person looks.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "service/error.h"
#include "studies/progress.h"

namespace sixdial::cli {

struct Console {
  std::ostream& out;
  std::ostream& err;
  bool json = false;          // --json
  bool quiet = false;         // --quiet: no progress
  bool terminal = false;      // stderr is one
  bool colour = false;        // ... and NO_COLOR is not set
  bool out_terminal = false;  // stdout is one

  /// --json: {"schema": name, "schema_version": 1, ...document} on one line.
  void print_json(std::string_view schema, const Json& document) const;
  /// Writes the whole text to stderr in one write, so that nobody sees half of it. As it is:
  /// what files say goes through for_terminal() first, as it does in all others.
  void send(std::string_view text) const;
  /// The text (ended by a newline) in the human form, the document with --json.
  void print(std::string_view schema, const Json& document, const std::string& text) const;
  /// What a program may read (a plan): byte by byte, but to a terminal as text.
  void print_data(std::string_view text) const;
  void note(const std::string& text) const;
  void warn(const std::string& text) const;
  /// An error object as a person wants it: what, where, what to do. With --json also as JSON.
  void error(const Json& error_object) const;
};

/// Columns padded to their widest cell; numbers to the right.
[[nodiscard]] std::string text_table(
    const std::vector<std::string>& titles, const std::vector<std::vector<std::string>>& rows);

/// "1:05", "2:03:04".
[[nodiscard]] std::string duration_text(double seconds);

/// Letters that fit into a line of the terminal at stderr, one less than it has; 79 elsewhere.
[[nodiscard]] std::size_t terminal_width();
/// Lines of the terminal at stderr; 24 elsewhere.
[[nodiscard]] std::size_t terminal_height();
/// The text in lines of at most `width` letters, broken at spaces; the later ones are indented.
[[nodiscard]] std::vector<std::string> wrapped(const std::string& text, std::size_t width);
/// Rows that a line takes in a terminal of `width` columns.
[[nodiscard]] std::size_t rows_of(std::size_t letters, std::size_t width);
/// "[######....] text  remark" in at most `width` letters: the bar shrinks, the remark goes
/// first, then the bar.
[[nodiscard]] std::string progress_text(
    double fraction, const std::string& text, std::size_t width, std::string_view remark);

/// A line that is rewritten on a terminal; elsewhere a plain line at each new stage and tenth.
class ProgressLine {
 public:
  explicit ProgressLine(const Console& console) : console_(console) {}
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  /// `eta_s` empty: not known yet.
  void show(
      std::string_view stage, std::int64_t done, std::int64_t total,
      std::optional<double> eta_s, std::string_view remark);
  /// Of a study or of a job.
  void show(const studies::Progress& progress);
  /// Takes the line off the terminal so that other text can be printed.
  void clear();
  /// What show() and clear() send, for a caller that sends it together with other text; the
  /// line counts as drawn, or as erased, from now on.
  [[nodiscard]] std::string drawn(
      std::string_view stage, std::int64_t done, std::int64_t total,
      std::optional<double> eta_s, std::string_view remark);
  [[nodiscard]] std::string erased();

 private:
  const Console& console_;
  std::string shown_stage_;
  std::int64_t shown_tenth_ = -1;
  std::size_t on_screen_ = 0;  // letters
};

}  // namespace sixdial::cli
