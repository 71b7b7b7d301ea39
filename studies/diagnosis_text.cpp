// A diagnosis on the terminal.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "studies/diagnosis_words.h"

namespace sixdial::studies {
namespace {

constexpr std::size_t kWidth = 96;

/// Words in lines of at most kWidth characters (UTF-8 continuation bytes take no room).
std::string wrapped(const std::string& text, const std::string& indent = "") {
  std::string out = indent;
  std::size_t used = indent.size();
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const auto width = static_cast<std::size_t>(std::ranges::count_if(
        word, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
    if (used > indent.size() && used + 1 + width > kWidth) {
      out += "\n" + indent;
      used = indent.size();
    } else if (used > indent.size()) {
      out += ' ';
      ++used;
    }
    out += word;
    used += width;
    begin = end + 1;
  }
  return out + "\n";
}

std::string cell(const Json& value, int decimals = 4) {
  return value.is_number() ? fmt::format("{:10.{}f}", value.get<double>(), decimals)
                           : fmt::format("{:>10}", "-");
}

std::string lines(const std::string& heading, const Json& items) {
  if (items.empty()) return "";
  std::string text = "\n" + heading + "\n";
  for (const Json& item : items) text += wrapped(item.get<std::string>(), "  ");
  return text;
}

std::string gain_table(const Json& document) {
  if (document["gain"].empty()) return "";
  std::string text = fmt::format(
      "\n{:<44}{:>10}{:>10}{:>10}{:>10}   {}\n", "held out, position error, mm", "mean", "std",
      "max", "rms*", "change of the mean, 95 %");
  for (const Json& row : document["gain"]) {
    text += fmt::format(
        "{:<44}{}{}{}{}   ", row["name"].get<std::string>(), cell(row["mean_mm"]),
        cell(row["std_mm"]), cell(row["max_mm"]), cell(row["rms_mm"]));
    if (row["low_mm"].is_number() && row["high_mm"].is_number()) {
      text += fmt::format(
          "{:+.4f} to {:+.4f}", row["low_mm"].get<double>(), row["high_mm"].get<double>());
    }
    text += '\n';
  }
  return text + "* of the readings\n";
}

/// Parameters that stand elsewhere once the causes are fitted with them.
std::string moved_table(const Json& document) {
  std::string text;
  for (const Json& each : document["extended"]["parameters"]) {
    if (!each["moved_sigma"].is_number()) continue;
    const double moved = each["moved_sigma"].get<double>();
    constexpr double kWorthTelling = 1.0;
    if (std::abs(moved) < kWorthTelling) continue;
    text += fmt::format(
        "  {:<8} {}, {:.1f} of its standard deviations\n", each["name"].get<std::string>(),
        quantity_in_words(
            each["moved"].get<double>(), std::nan(""), each["unit"].get<std::string>()),
        std::abs(moved));
  }
  if (text.empty()) return "";
  return "\nFitted robot parameters that move when the cause is taken into account\n" + text;
}

std::size_t shown_width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// "0.00150 to 0.00167 mm" over the places of a cause; null counts as "at no size".
std::string range_of(const std::vector<const Json*>& places, const char* key) {
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  bool never = false;
  for (const Json* each : places) {
    if (!(*each)[key].is_number()) {
      never = true;
      continue;
    }
    low = std::min(low, (*each)[key].get<double>());
    high = std::max(high, (*each)[key].get<double>());
  }
  if (!(high >= low)) return "at no size";
  const auto unit = (*places.front())["unit"].get<std::string>();
  const auto size = [&](double value) { return quantity_in_words(value, std::nan(""), unit); };
  std::string text = size(low);
  if (size(low) != size(high)) text += " to " + size(high);
  if (never) text += " or never";
  return text;
}

/// One line a cause and unit: its places together.
std::string limits_table(const Json& document) {
  if (document["detection_limits"].empty()) return "";
  std::string text = fmt::format(
      "\n{:<42}{:<30}{}\n", "this session would have seen", "detected from",
      "named rightly from");
  std::vector<std::vector<const Json*>> groups;
  for (const Json& each : document["detection_limits"]) {
    const auto same = [&](const std::vector<const Json*>& group) {
      return (*group.front())["cause"] == each["cause"] &&
             (*group.front())["unit"] == each["unit"];
    };
    auto found = std::ranges::find_if(groups, same);
    if (found == groups.end()) {
      groups.push_back({&each});
    } else {
      found->push_back(&each);
    }
  }
  for (const auto& group : groups) {
    std::string name = named(*group.front());
    if (group.size() > 1) {
      name = cause_in_words((*group.front())["cause"].get<std::string>(), "");
      std::string where;
      for (const Json* each : group) {
        where += (where.empty() ? "" : " ") + (*each)["where"].get<std::string>();
      }
      name += fmt::format(" ({})", where);
    }
    std::string detect = range_of(group, "detect");
    const auto padded = [](std::string cell_text, std::size_t width) {
      const std::size_t shown = shown_width(cell_text);
      return cell_text + std::string(width > shown ? width - shown : 1, ' ');
    };
    text += padded(name, 42) + padded(std::move(detect), 30) + range_of(group, "name") + "\n";
  }
  return text;
}

}  // namespace

std::string diagnosis_text(const Json& document) {
  const Json& verdict = document.at("verdict");
  std::string text = wrapped(verdict["title"].get<std::string>() + ".");
  text += wrapped(verdict["headline"].get<std::string>());
  text += lines("What to do", verdict["to_do"]);
  text += lines("How sure", verdict["trust"]);
  text += lines("What could not be judged", verdict["not_judged"]);
  text += gain_table(document);
  text += moved_table(document);
  text += limits_table(document);
  if (!document["gross_readings"].empty()) {
    text += fmt::format(
        "\n{:<8}{:>6}{:>7}{:>7}{:>12}\n", "gross", "point", "repeat", "dial", "size, mm");
    for (const Json& each : document["gross_readings"]) {
      const std::string remark = remark_on_gross(each);
      text += fmt::format(
          "{:<8}{:>6}{:>7}{:>7}{:>12.3f}{}{}\n", each["set"].get<std::string>(),
          each["point"].get<int>(), each["repeat"].get<int>(), each["dial"].get<std::string>(),
          each["size_mm"].get<double>(), remark.empty() ? "" : "  ", remark);
    }
  }
  return text;
}

}  // namespace sixdial::studies
