// A machine that takes G-code, as its serial line sees it: Grbl, Marlin or Klipper, written
// from their own pages. Bytes in, bytes out, each when it is due; moves last as long as their
// feed says. Degrees or millimetres, seconds. One thread at a time.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::mock_devices {

enum class GcodeFirmware { kGrbl, kMarlin, kKlipper };

struct GcodeMachine {
  GcodeFirmware firmware = GcodeFirmware::kGrbl;
  std::string axes = "XYZ";           // of its motors
  double low = -180.0, high = 180.0;  // travel of each, in the coordinates of commands
  /// Grbl: machine less command coordinates of each axis; it reports the machine's.
  double work_offset = 0.0;
  /// A motor's step: positions are multiples of it. 0: none.
  double step = 0.0;
  double before_ok_s = 0.0;         // it thinks so long before it answers a line
  std::vector<double> begins_at{};  // where each axis stands when it is switched on; empty: 0
};

class GcodeController {
 public:
  explicit GcodeController(GcodeMachine machine);

  /// Bytes from the line at a time that does not run backwards.
  void receive(std::string_view bytes, double time_s);
  /// What is due to be sent by now.
  [[nodiscard]] std::string due(double time_s);
  [[nodiscard]] std::optional<double> next_due_s() const;

  /// Where the axes stand.
  [[nodiscard]] std::vector<double> position(double time_s) const;
  [[nodiscard]] int moves() const { return moves_; }
  /// As after switching it off and on.
  void restart(double time_s);
  /// What it would say of itself, whoever asks: a line of text.
  void say(std::string line, double time_s);

 private:
  struct Segment {
    std::vector<double> from, to;
    double start_s = 0.0, end_s = 0.0;
  };
  void line(std::string text, double time_s);
  void command(const std::string& text, double time_s);
  void move(const std::string& words, double time_s);
  void hold(double time_s);
  void reset(double time_s);
  void answer(std::string text, double time_s);
  [[nodiscard]] std::string status(double time_s) const;
  [[nodiscard]] std::string m114(double time_s) const;
  [[nodiscard]] bool moving(double time_s) const { return time_s < end_s(); }
  [[nodiscard]] double end_s() const;
  [[nodiscard]] bool is(GcodeFirmware firmware) const { return machine_.firmware == firmware; }
  void greet(double time_s);

  GcodeMachine machine_;
  std::string in_;
  struct Out {
    double due_s = 0.0;
    std::string bytes;
    bool of_wait =
        false;  // comes when the moves have ended: dropped by a reset, put off by a hold
  };
  std::deque<Out> out_;
  std::vector<double> at_;  // where the moves begin
  std::deque<Segment> segments_;
  std::vector<double> held_to_;  // the rest of a held move
  bool held_ = false;
  bool alarm_ = false;
  bool dead_ = false;  // Klipper after M112
  bool relative_ = false;
  double feed_ = 0.0;
  int moves_ = 0;
  mutable int reports_ = 0;
};

}  // namespace sixdial::mock_devices
