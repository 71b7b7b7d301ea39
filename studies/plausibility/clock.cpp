// Dates that cannot be: single rows (another year, day and month exchanged, a slip in the
// hour), and a clock that was set back while a session was measured. Rows are taken in the
// order in which they stand, which is the order of measuring: sorting by such times would mix
// two runs.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kUsualTimes = 10.0;    // a jump of so many usual steps is none between samples
constexpr double kLeastJump_s = 60.0;   // and at least that long
constexpr double kFarAway_s = 86400.0;  // the first or last row alone, that far from the others
constexpr double kMostWrong = 0.2;      // share of the rows that may be slips
constexpr int kMostSteps = 3;           // more ways back are an order of another kind

struct Timed {
  std::size_t row = 0;
  double time_s = 0.0;  // since the epoch
};

std::vector<Timed> timed_rows(const session::Session& session) {
  std::vector<Timed> rows;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const auto& time = session.samples[i].time_utc;
    if (!time || session.samples[i].left_out) continue;
    rows.push_back({i, std::chrono::duration<double>(time->time_since_epoch()).count()});
  }
  return rows;
}

double usual_step_s(const std::vector<Timed>& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step = rows[i].time_s - rows[i - 1].time_s;
    if (step > 0.0) steps.push_back(step);
  }
  if (steps.empty()) return 0.0;
  std::ranges::nth_element(steps, steps.begin() + std::ssize(steps) / 2);
  return steps[steps.size() / 2];
}

/// Rows whose date is far from both neighbours, which are near each other, or a few such rows
/// together; places in `rows`.
std::vector<std::size_t> wrong_dates(const std::vector<Timed>& rows, double usual_s) {
  std::vector<std::size_t> wrong;
  const double jump = std::max(kUsualTimes * usual_s, kLeastJump_s);
  const auto apart = [&](std::size_t a, std::size_t b) {
    return std::abs(rows[a].time_s - rows[b].time_s);
  };
  const std::size_t n = rows.size();
  std::size_t before = n;  // the last row that is right
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = before == n;
    const bool last = i + 1 == n;
    bool is_wrong = false;
    if (first && !last && i == 0) {
      is_wrong = apart(0, 1) > kFarAway_s && n > 2 && apart(1, 2) < jump;
    } else if (last) {
      is_wrong = apart(before, i) > kFarAway_s ||
                 (rows[i].time_s < rows[before].time_s && apart(before, i) > jump);
    } else if (!first) {
      constexpr std::size_t kMostTogether = 5;
      for (std::size_t after = i + 1; after < n && after <= i + kMostTogether; ++after) {
        const double across = apart(before, after);
        is_wrong =
            is_wrong || (apart(before, i) > jump + across && apart(i, after) > jump + across);
      }
    }
    if (is_wrong) {
      wrong.push_back(i);
    } else {
      before = i;
    }
  }
  return wrong;
}

/// Between the neighbours that have a time.
void fill_time(session::Session& used, const std::vector<Timed>& right, std::size_t row) {
  const auto after =
      std::ranges::find_if(right, [&](const Timed& each) { return each.row > row; });
  std::optional<double> time_s;
  if (after != right.end() && after != right.begin()) {
    const Timed& low = *std::prev(after);
    const double share =
        static_cast<double>(row - low.row) / static_cast<double>(after->row - low.row);
    time_s = low.time_s + share * (after->time_s - low.time_s);
  } else if (!right.empty()) {
    time_s = after == right.end() ? right.back().time_s : right.front().time_s;
  }
  auto& time = used.samples[row].time_utc;
  if (!time_s) {
    time.reset();
    return;
  }
  time = session::TimePoint(std::chrono::milliseconds(std::llround(1e3 * *time_s)));
}

/// Rows of another year than the middle of all: not a slip in one row, but of whoever typed
/// them or of a clock that had not been set yet. Places in `rows`.
std::vector<std::size_t> of_another_year(const std::vector<Timed>& rows) {
  constexpr double kFar_s = 200.0 * 86400.0;
  std::vector<double> times;
  for (const Timed& each : rows) times.push_back(each.time_s);
  std::ranges::nth_element(times, times.begin() + std::ssize(times) / 2);
  const double middle = times[times.size() / 2];
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (std::abs(rows[i].time_s - middle) > kFar_s) far.push_back(i);
  }
  return far;
}

std::string step_text(double seconds) {
  const double s = std::abs(seconds);
  const auto shown = [](double value, const char* unit) {
    const double rounded = std::round(10.0 * value) / 10.0;
    std::string number = std::to_string(rounded);
    number.erase(number.find('.') + 2);
    return number + " " + unit;
  };
  return s < 120.0    ? shown(s, "s")
         : s < 7200.0 ? shown(s / 60.0, "min")
                      : shown(s / 3600.0, "h");
}

/// Weeks without a row: two sessions in one file, or a clock that was set.
void tell_longest_pause(Look& look, const std::vector<Timed>& rows) {
  constexpr double kLong_s = 7.0 * 86400.0;
  std::size_t after = 0;
  double longest_s = kLong_s;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step_s = rows[i].time_s - rows[i - 1].time_s;
    if (step_s <= longest_s) continue;
    longest_s = step_s;
    after = i;
  }
  if (after == 0) return;
  look.tell(
      "long_pause", Severity::kNote, look.rows(std::array{rows[after].row}, "time_utc"),
      {{"days", std::round(longest_s / 86400.0)}});
}

}  // namespace

void look_at_clock(Look& look) {
  std::vector<Timed> rows = timed_rows(look.used);
  if (rows.size() < 3) return;
  constexpr std::size_t kFewestAlike = 6;
  const bool alike = std::ranges::all_of(
      rows, [&](const Timed& each) { return each.time_s == rows.front().time_s; });
  if (alike && rows.size() >= kFewestAlike) {
    look.tell("same_time", Severity::kNote, {.file = "session.csv", .field = "time_utc"});
    for (const Timed& each : rows) look.used.samples[each.row].time_utc.reset();
    return;
  }
  const double usual_s = usual_step_s(rows);
  const double most = std::max(1.0, kMostWrong * static_cast<double>(rows.size()));
  std::vector<std::size_t> named;
  const auto take_out = [&](const std::vector<std::size_t>& wrong) {
    if (static_cast<double>(wrong.size()) > most) return;
    for (const std::size_t i : wrong) named.push_back(rows[i].row);
    for (auto i = wrong.rbegin(); i != wrong.rend(); ++i) {
      rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(*i));
    }
  };
  take_out(of_another_year(rows));
  take_out(wrong_dates(rows, usual_s));
  std::ranges::sort(named);
  if (!named.empty()) {
    look.tell(
        "wrong_date", Severity::kNote, look.rows(named, "time_utc"),
        {{"date", session::to_iso8601(*look.measured.samples[named.front()].time_utc)},
         {"others", session::to_iso8601(*look.measured.samples[rows.front().row].time_utc)}});
    for (const std::size_t row : named) fill_time(look.used, rows, row);
  }
  tell_longest_pause(look, rows);
  std::vector<std::size_t> back;  // places in `rows` that are dated before the one above
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].time_s < rows[i - 1].time_s) back.push_back(i);
  }
  if (back.empty()) return;
  const bool sorted_by_set = std::ranges::all_of(back, [&](std::size_t i) {
    return look.used.samples[rows[i].row].set != look.used.samples[rows[i - 1].row].set;
  });
  named.clear();
  for (const std::size_t i : back) named.push_back(rows[i].row);
  if (sorted_by_set || back.size() > kMostSteps) {
    look.tell("not_in_order_of_time", Severity::kNote, look.rows(named, "time_utc"));
    return;
  }
  const double first_step_s = rows[back.front()].time_s - rows[back.front() - 1].time_s;
  look.tell(
      "clock_set_back", Severity::kNote, look.rows(named, "time_utc"),
      {{"set_back", step_text(first_step_s)}});
  // The run goes on where it was, one usual step after the row above.
  double shift_s = 0.0;
  std::size_t next = 0;
  for (std::size_t i = back.front(); i < rows.size(); ++i) {
    if (next < back.size() && back[next] == i) {
      shift_s += rows[i - 1].time_s - rows[i].time_s + usual_s;
      ++next;
    }
    auto& time = look.used.samples[rows[i].row].time_utc;
    *time += std::chrono::milliseconds(std::llround(1e3 * shift_s));
  }
}

}  // namespace sixdial::studies::plausibility
