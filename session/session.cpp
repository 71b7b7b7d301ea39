#include "session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace sixdial::session {
namespace {

std::optional<int> digits(std::string_view text, std::size_t from, std::size_t count) {
  if (from + count > text.size()) return std::nullopt;
  int value = 0;
  for (const char c : text.substr(from, count)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + (c - '0');
  }
  return value;
}

}  // namespace

std::string to_iso8601(TimePoint time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  return fmt::format(
      "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
      static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
      clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
      clock.subseconds().count());
}

// Years 0000..9999, "Z" only; the fraction may be absent or have 1 to 9 digits, of which three
// count.
std::optional<TimePoint> from_iso8601(std::string_view text) {
  const auto year = digits(text, 0, 4);
  const auto month = digits(text, 5, 2);
  const auto day = digits(text, 8, 2);
  const auto hour = digits(text, 11, 2);
  const auto minute = digits(text, 14, 2);
  const auto second = digits(text, 17, 2);
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  if (text[4] != '-' || text[7] != '-' || text[10] != 'T' || text[13] != ':' ||
      text[16] != ':' || text.back() != 'Z') {
    return std::nullopt;
  }
  int milliseconds = 0;
  if (text.size() > 20) {
    const std::size_t count = text.size() - 21;
    if (text[19] != '.' || count < 1 || count > 9 || !digits(text, 20, count)) {
      return std::nullopt;
    }
    int place = 100;
    for (std::size_t i = 20; i < 20 + std::min<std::size_t>(count, 3); ++i) {
      milliseconds += (text[i] - '0') * place;
      place /= 10;
    }
  }
  const std::chrono::year_month_day date(
      std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
      std::chrono::day(static_cast<unsigned>(*day)));
  if (!date.ok() || *hour > 23 || *minute > 59 || *second > 59) return std::nullopt;
  return std::chrono::sys_days(date) + std::chrono::hours(*hour) +
         std::chrono::minutes(*minute) + std::chrono::seconds(*second) +
         std::chrono::milliseconds(milliseconds);
}

std::string_view to_string(Quality quality) {
  switch (quality) {
    case Quality::kGood:
      return "good";
    case Quality::kUncertain:
      return "uncertain";
    case Quality::kBad:
      return "bad";
  }
  return "bad";
}

std::optional<Quality> quality_from(std::string_view text) {
  for (const Quality quality : {Quality::kGood, Quality::kUncertain, Quality::kBad}) {
    if (to_string(quality) == text) return quality;
  }
  return std::nullopt;
}

std::optional<int> approach_of(const Sample& sample, std::size_t joint) {
  return joint < sample.approach.size() ? sample.approach[joint] : std::nullopt;
}

std::optional<double> readings_within_ms(const Sample& sample) {
  std::optional<TimePoint> first;
  std::optional<TimePoint> last;
  int times = 0;
  for (const ChannelValue& value : sample.channels) {
    if (!value.time_utc) continue;
    ++times;
    if (!first || *value.time_utc < *first) first = value.time_utc;
    if (!last || *value.time_utc > *last) last = value.time_utc;
  }
  if (times < 2) return std::nullopt;
  return std::chrono::duration<double, std::milli>(*last - *first).count();
}

std::optional<ReadingsWithin> readings_within(const Session& session) {
  std::vector<double> within_ms;
  for (const Sample& sample : session.samples) {
    if (const auto each = readings_within_ms(sample)) within_ms.push_back(*each);
  }
  if (within_ms.empty()) return std::nullopt;
  std::ranges::sort(within_ms);
  return ReadingsWithin{
      .median_ms = within_ms[within_ms.size() / 2], .max_ms = within_ms.back()};
}

}  // namespace sixdial::session
