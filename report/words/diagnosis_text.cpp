#include "report/words/diagnosis_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"
#include "report/words/warning_words.h"
#include "report/words/wrapped.h"

namespace sixdial::report {
namespace {

using studies::DiagnosisResult;
using studies::Limit;

std::string cell(double value, int decimals = 4) {
  return std::isfinite(value) ? fmt::format("{:10.{}f}", value, decimals)
                              : fmt::format("{:>10}", "-");
}

std::string lines(const std::string& heading, const std::vector<std::string>& items) {
  if (items.empty()) return "";
  std::string text = "\n" + heading + "\n";
  for (const std::string& item : items) text += wrapped(item, "  ");
  return text;
}

std::string gain_table(const DiagnosisResult& result) {
  if (result.gain.empty()) return "";
  std::string text = fmt::format(
      "\n{:<44}{:>10}{:>10}{:>10}{:>10}   {}\n", "tool shift on points not fitted, mm", "mean",
      "std", "max", "rms*", "change of the mean, 95 %");
  for (const studies::GainRow& row : result.gain) {
    text += fmt::format(
        "{:<44}{}{}{}{}   ", gain_row_in_words(row), cell(row.mean_mm), cell(row.std_mm),
        cell(row.max_mm), cell(row.rms_mm));
    if (std::isfinite(row.low_mm) && std::isfinite(row.high_mm)) {
      text += fmt::format("{:+.4f} to {:+.4f}", row.low_mm, row.high_mm);
    }
    text += '\n';
  }
  return text + "* of the readings\n";
}

/// Parameters that stand elsewhere once the causes are fitted with them.
std::string moved_table(const DiagnosisResult& result) {
  std::string text;
  for (const diagnosis::ParameterChange& each : result.parameters) {
    const double sigmas = std::abs(studies::moved_sigma(each));
    constexpr double kWorthTelling = 1.0;
    if (!(sigmas >= kWorthTelling) || !std::isfinite(sigmas)) continue;
    text += fmt::format(
        "  {:<8} {}, {:.1f} of its standard deviations\n", each.name,
        quantity_in_words(studies::moved(each), std::nan(""), each.unit), sigmas);
  }
  if (text.empty()) return "";
  return "\nFitted robot parameters that move when the cause is taken into account\n" + text;
}

std::size_t shown_width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// "0.00150 to 0.00167 mm" over the places of a cause; what is not finite, or larger than
/// anything plausible, is not seen there.
std::string range_of(const std::vector<const Limit*>& places, double Limit::*size) {
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  bool never = false;
  bool implausible = false;
  for (const Limit* each : places) {
    if (!std::isfinite(each->*size)) {
      never = true;
      continue;
    }
    if (is_beyond_plausible(*each, each->*size)) {
      never = true;
      implausible = true;
      continue;
    }
    low = std::min(low, each->*size);
    high = std::max(high, each->*size);
  }
  if (!(high >= low)) return std::string(implausible ? kAtNoPlausibleSize : "at no size");
  const auto shown = [&](double value) {
    return quantity_in_words(value, std::nan(""), places.front()->unit);
  };
  std::string text = shown(low);
  if (shown(low) != shown(high)) text += " to " + shown(high);
  if (never) text += " or never";
  return text;
}

/// Places of the same cause whose sizes have the same unit.
std::vector<std::vector<const Limit*>> by_cause(const std::vector<Limit>& limits) {
  std::vector<std::vector<const Limit*>> groups;
  for (const Limit& each : limits) {
    const auto found = std::ranges::find_if(groups, [&](const auto& group) {
      return group.front()->id.cause == each.id.cause && group.front()->unit == each.unit;
    });
    if (found == groups.end()) {
      groups.push_back({&each});
    } else {
      found->push_back(&each);
    }
  }
  return groups;
}

std::string padded(std::string text, std::size_t width) {
  const std::size_t shown = shown_width(text);
  return text.append(width > shown ? width - shown : 1, ' ');
}

/// One line a cause and unit: its places together.
std::string limits_table(const DiagnosisResult& result) {
  if (result.limits.empty()) return "";
  std::string text = fmt::format(
      "\n{:<42}{:<30}{}\n", "this session would have seen", "detected from",
      "named rightly from");
  bool beyond = false;
  for (const auto& group : by_cause(result.limits)) {
    std::string name = named(group.front()->id);
    if (group.size() > 1) {
      std::string where;
      for (const Limit* each : group) where += (where.empty() ? "" : " ") + each->id.where;
      name = fmt::format(
          "{} ({})", named(studies::HypothesisId{group.front()->id.cause, ""}), where);
    }
    const std::string detected = range_of(group, &Limit::detect);
    const std::string told = range_of(group, &Limit::name);
    beyond = beyond || detected == kAtNoPlausibleSize || told == kAtNoPlausibleSize;
    text += padded(std::move(name), 42) + padded(detected, 30) + told + "\n";
  }
  if (beyond) {
    text += wrapped(
        "At no plausible size: only one of more than 50 times the size to expect would show, "
        "so "
        "that this session cannot show it.",
        "  ");
  }
  return text;
}

std::string gross_table(const DiagnosisResult& result) {
  if (result.gross_readings.empty()) return "";
  std::string text = fmt::format(
      "\n{:<8}{:>6}{:>7}{:>7}{:>12}\n", "gross", "point", "repeat", "dial", "size, mm");
  for (const studies::GrossReading& each : result.gross_readings) {
    const std::string remark = remark_on_gross(each);
    text += fmt::format(
        "{:<8}{:>6}{:>7}{:>7}{:>12.3f}{}{}\n", each.set, each.point, each.repeat, each.dial,
        each.size_mm, remark.empty() ? "" : "  ", remark);
  }
  return text;
}

}  // namespace

std::string diagnosis_text(const DiagnosisResult& result) {
  const DiagnosisVerdict verdict = verdict_in_words(result);
  const std::string against = result.warnings ? warnings_text(*result.warnings) : std::string();
  return against + (against.empty() ? "" : "\n") + wrapped(verdict.title + ".") +
         wrapped(verdict.headline) + lines("What to do", texts_of(verdict.to_do)) +
         lines("How sure", verdict.trust) +
         lines("What could not be judged", verdict.not_judged) + gain_table(result) +
         moved_table(result) + limits_table(result) + gross_table(result);
}

}  // namespace sixdial::report
