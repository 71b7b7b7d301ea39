#include "studies/diagnosis_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "simulation/effect.h"

namespace sixdial::studies {
namespace {

constexpr double kDeg = 180.0 / std::numbers::pi;

double number_of(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string text_of(const Json& json) {
  return json.is_string() ? json.get<std::string>() : std::string();
}

bool one_dial(std::string_view where) {
  return where != "dials" && where != "base" && where != "frame" && where != "cuboid" &&
         where != "links" && where != "elbows" && where != "joints" && where != "samples" &&
         !where.starts_with("joint") && !where.empty();
}

/// A value in the unit that people read, and that unit.
struct Shown {
  double factor;
  std::string unit;  // with a space before it where one belongs
};
Shown shown_unit(std::string_view unit) {
  if (unit == "rad") return {kDeg, "\u00B0"};
  if (unit == "1/K") return {1e6, " \u00B5m/(m\u00B7K)"};
  if (unit == "rad/(N mm)") return {1e6, " \u00B5rad/(N\u00B7mm)"};
  if (unit == "1") return {100.0, " %"};
  return {1.0, unit.empty() ? std::string() : fmt::format(" {}", unit)};
}

int decimals_of(double resolved) {
  if (!(resolved > 0.0) || !std::isfinite(resolved)) return 4;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(resolved))), 0, 7);
}

std::string list_of(const std::vector<std::string>& items, std::string_view last = "and") {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? fmt::format(" {} ", last) : ", ";
    text += items[i];
  }
  return text;
}

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

std::string joint_words(std::string_view where) {
  return fmt::format("joint {}", where.substr(std::string_view("joint").size()));
}

/// The estimate's entry of that name; null if there is none.
Json estimate_of(const Json& cause, std::string_view name) {
  for (const Json& each : cause.at("estimate")) {
    if (each["name"] == name) return each;
  }
  return nullptr;
}

std::string quantity(const Json& estimate) {
  return quantity_in_words(
      number_of(estimate["value"]), number_of(estimate["sd"]), text_of(estimate["unit"]));
}

/// Length of two entries as one quantity.
std::string together(const Json& a, const Json& b) {
  const double x = number_of(a["value"]);
  const double y = number_of(b["value"]);
  const double size = std::hypot(x, y);
  const double sd = size > 0.0
                        ? std::hypot(x * number_of(a["sd"]), y * number_of(b["sd"])) / size
                        : number_of(a["sd"]);
  return quantity_in_words(size, sd, text_of(a["unit"]));
}

/// "2.3", "12", "1000".
std::string odds_text(double log_odds) {
  const double odds = std::exp(std::clamp(log_odds, 0.0, 20.0));
  return odds < 10.0 ? fmt::format("{:.1f}", odds) : fmt::format("{:.0f}", odds);
}

const Json* row_of(const Json& document, std::string_view name) {
  for (const Json& row : document.at("gain")) {
    if (row["name"] == name) return &row;
  }
  return nullptr;
}

/// "dial E reading" -> "the reading of dial E".
std::string covariate_in_words(const std::string& name) {
  constexpr std::string_view kReading = " reading";
  if (name.starts_with("dial ") && name.ends_with(kReading)) {
    return "the reading of " + name.substr(0, name.size() - kReading.size());
  }
  if (name == "gamma") return "the cuboid's angle";
  if (name == "approach1" || name == "approach2") {
    return fmt::format("the side that joint {} arrives from", name.back());
  }
  return name;
}

std::string covariates_in_words(const Json& document, std::string_view last = "and") {
  std::vector<std::string> names;
  for (const Json& each : document.at("unexplained").at("depends_on")) {
    names.push_back(covariate_in_words(each.get<std::string>()));
  }
  return list_of(names, last);
}

bool is_data_fault(const Json& cause) {
  return cause["cause"] == "outliers" || cause["cause"] == "stale_reading";
}

/// Tied with "nothing at all" only.
bool is_doubtful(const Json& cause) {
  return cause["tied_with"].size() == 1 && cause["tied_with"][0]["cause"] == "none";
}

std::string found_line(const Json& cause) {
  const std::string size = size_in_words(cause);
  if (is_doubtful(cause)) {
    return fmt::format(
        "Perhaps {}: {}; too weak to be sure that there is anything (odds {} to 1).",
        named(cause), size, odds_text(number_of(cause["tied_with"][0]["log_odds"])));
  }
  std::string line = capital(named(cause));
  if (!size.empty()) line += ": " + size;
  if (cause["certainty"] == "tied") {
    std::vector<std::string> rivals;
    for (const Json& rival : cause["tied_with"]) {
      rivals.push_back(
          rival["cause"] == "none" ? std::string("nothing at all")
                                   : fmt::format(
                                         "{} (odds {} to 1)", named(rival),
                                         odds_text(number_of(rival["log_odds"]))));
    }
    line += fmt::format("; these data cannot tell it from {}", list_of(rivals, "or"));
  }
  if (is_data_fault(cause)) return line + ".";
  return line + fmt::format("; {}.", text_of(cause["standing"]));
}

/// Something was named that a model of the session has and the calibrated robot has not.
bool explains_readings(const Json& document) {
  return std::any_of(
      document["causes"].begin(), document["causes"].end(),
      [](const Json& cause) { return !is_data_fault(cause); });
}

std::string gain_sentence(const Json& document) {
  const Json* calibrated = row_of(document, "calibrated");
  const Json* extended = row_of(document, "extended");
  if (calibrated == nullptr) return "";
  const Json& on = document["judged_on"];
  const std::string where = fmt::format(
      "on {} {} that were not fitted", on["samples"].get<int>(),
      on["held_out_by_program"].get<bool>() ? "samples set aside by the program"
                                            : "samples of G2");
  const Json* network = row_of(document, "calibrated + ANFIS");
  const std::string by_network = network == nullptr
                                     ? std::string()
                                     : fmt::format(
                                           "; a network on joint angles instead (ANFIS): {}",
                                           millimetres((*network)["mean_mm"]));
  if (extended == nullptr || !explains_readings(document)) {
    return fmt::format(
        "The mean position error {} is {} after calibration{}.", where,
        millimetres((*calibrated)["mean_mm"]), by_network);
  }
  return fmt::format(
      "The mean position error {} falls from {} (calibrated) to {} (95 % interval of the "
      "change: "
      "{:+.4f} to {:+.4f} mm){}.",
      where, millimetres((*calibrated)["mean_mm"]), millimetres((*extended)["mean_mm"]),
      number_of((*extended)["low_mm"]), number_of((*extended)["high_mm"]), by_network);
}

std::string kind_of(const Json& document) {
  if (document["unexplained"]["significant"].get<bool>()) {
    return document["unexplained"]["depends_on"].empty() ? "scatter" : "unknown";
  }
  bool tied = false;
  for (const Json& cause : document["causes"]) tied = tied || cause["certainty"] == "tied";
  return document["causes"].empty() ? "nothing" : tied ? "tied" : "named";
}

/// "dial C that scatters too much".
std::string noisy_dials_in_words(const Json& document) {
  std::vector<std::string> dials;
  for (const Json& each : document["unexplained"]["noisy_dials"]) {
    dials.push_back("dial " + text_of(each["dial"]));
  }
  return fmt::format(
      "{} that {} too much", list_of(dials), dials.size() > 1 ? "scatter" : "scatters");
}

std::string title_of(const Json& document, const std::string& kind) {
  std::vector<std::string> names;
  for (const Json& cause : document["causes"]) {
    if (is_data_fault(cause)) continue;
    if (is_doubtful(cause)) {
      names.push_back("perhaps " + named(cause));
      continue;
    }
    std::vector<std::string> either{named(cause)};
    for (const Json& rival : cause["tied_with"]) {
      either.push_back(rival["cause"] == "none" ? "nothing" : named(rival));
    }
    constexpr std::size_t kMost = 2;
    if (either.size() > kMost + 1) {
      const std::size_t more = either.size() - kMost;
      either.resize(kMost);
      either.push_back(fmt::format("one of {} more", more));
    }
    names.push_back((either.size() > 1 ? "either " : "") + list_of(either, "or"));
  }
  const Json& noisy = document["unexplained"]["noisy_dials"];
  if (!noisy.empty()) {
    names.push_back(noisy_dials_in_words(document));
  } else if (kind == "scatter") {
    names.emplace_back("scatter above the noise");
  }
  if (kind == "unknown") {
    names.push_back("something unknown that depends on " + covariates_in_words(document));
  }
  // What readings went wrong comes last: it says nothing of the robot.
  std::string title = list_of(names);
  for (const Json& cause : document["causes"]) {
    if (is_data_fault(cause)) title += (title.empty() ? "" : "; ") + named(cause);
  }
  return title.empty() ? "Nothing found" : capital(title);
}

/// "Dial C scatters by 0.0080 mm, where the rig file says 0.0020 mm."
std::string noisy_dials_sentence(const Json& document) {
  std::string said;
  const bool repeats = document["noise"]["source"] == "repeats";
  for (const Json& each : document["unexplained"]["noisy_dials"]) {
    said += fmt::format(
        " Dial {} scatters by {}, where {} {}.", text_of(each["dial"]),
        millimetres(each["sigma_mm"]), repeats ? "its repeats say" : "the rig file says",
        millimetres(each["expected_mm"]));
  }
  return said;
}

std::string remainder_sentence(const Json& document) {
  const Json& left = document["unexplained"];
  const std::string rms = millimetres(left["rms_mm"]);
  const std::string noise = text_of(document["noise"]["in_words"]);
  if (!(number_of(left["noise_mm"]) > 0.0)) {
    return fmt::format("What is left: {} rms. The noise is {}.", rms, noise);
  }
  if (!left["significant"].get<bool>()) {
    return fmt::format("What is left ({} rms) is the dials' noise ({}).", rms, noise);
  }
  if (left["depends_on"].empty() && !left["noisy_dials"].empty()) {
    return fmt::format("What is left: {} rms.{}", rms, noisy_dials_sentence(document));
  }
  if (left["depends_on"].empty()) {
    return fmt::format(
        "What is left ({} rms) scatters more than the noise allows ({}), without structure.",
        rms, noise);
  }
  return fmt::format(
      "What is left ({} rms) is more than the noise ({}) and depends on {}; no known cause "
      "explains it, so none is named for it.{}",
      rms, noise, covariates_in_words(document), noisy_dials_sentence(document));
}

/// not_testable by reason: "4 places: ...".
std::vector<std::string> not_judged(const Json& document) {
  std::map<std::string, std::vector<std::string>> by_reason;
  for (const Json& each : document["not_testable"]) {
    // The share in percent differs from place to place; the reason is the same.
    const bool absorbed = std::ranges::any_of(document["detection_limits"], [&](const Json& l) {
      return l["cause"] == each["cause"] && l["where"] == each["where"];
    });
    by_reason
        [absorbed ? std::string("the fitted robot takes them over on these poses")
                  : text_of(each["reason"])]
            .push_back(named(each));
  }
  std::vector<std::string> lines;
  for (auto& [reason, names] : by_reason) {
    constexpr std::size_t kMost = 6;
    const std::size_t all = names.size();
    if (all > kMost) {
      names.resize(kMost);
      names.push_back(fmt::format("{} more", all - kMost));
    }
    lines.push_back(capital(fmt::format("{}: {}.", list_of(names), reason)));
  }
  return lines;
}

std::vector<std::string> to_do(const Json& document) {
  std::vector<std::string> lines;
  for (const Json& cause : document["causes"]) {
    const std::string advice = text_of(cause["advice"]);
    if (advice.empty()) continue;
    if (is_doubtful(cause)) {
      lines.push_back(capital(fmt::format(
          "{}: nothing yet; measure again, with more points, and see whether it comes back.",
          named(cause))));
      continue;
    }
    lines.push_back(fmt::format("{}: {}", capital(named(cause)), advice));
  }
  const std::string kind = kind_of(document);
  if (kind == "unknown") {
    lines.push_back(fmt::format(
        "Look for something that changes with {}; the charts of what is left show its course. "
        "Until it is found, a residual model (ANFIS) can be tried where it depends on the "
        "pose.",
        covariates_in_words(document, "or")));
  }
  for (const Json& each : document["unexplained"]["noisy_dials"]) {
    lines.push_back(fmt::format(
        "Dial {}: look at its clamping, cable and tip, and whether it moves freely; its "
        "readings "
        "count for less here.",
        text_of(each["dial"])));
  }
  if (kind == "scatter" && document["unexplained"]["noisy_dials"].empty()) {
    lines.emplace_back(
        "Repeat some poses with full re-approach: whether the dials or the robot scatter shows "
        "there.");
  }
  const bool rivals = std::any_of(
      document["causes"].begin(), document["causes"].end(),
      [](const Json& cause) { return !cause["tied_with"].empty() && !is_doubtful(cause); });
  if (rivals) {
    lines.emplace_back(
        "Before repairing what is tied, measure poses that separate the candidates: other "
        "working modes, a wider range of joint angles, both approach directions.");
  }
  if (lines.empty()) {
    lines.emplace_back("Nothing to repair. The limits below say what could have been seen.");
  }
  return lines;
}

std::vector<std::string> trust(const Json& document) {
  std::vector<std::string> lines;
  const double chance = number_of(document["false_alarm_probability"]);
  const auto draws = document["inputs"]["settings"]["null_draws"].get<int>();
  // The chance is of the effects' search: readings that are set right are left to it.
  const bool physical = !document["extended_model"]["effects"].empty();
  if (physical || document["unexplained"]["significant"].get<bool>()) {
    constexpr double kAboutOneDraw = 1.5;
    constexpr double kMillionth = 1e-6;
    if (draws > 0 && chance * (draws + 1) < kAboutOneDraw) {
      lines.push_back(fmt::format(
          "None of {} simulated sessions of pure noise looked as much like a cause as this "
          "one.",
          draws));
    } else if (chance < kMillionth) {
      lines.emplace_back(
          "Of sessions of pure noise fewer than one in a million looks as much like a cause "
          "(by formula, none were simulated).");
    } else {
      lines.push_back(fmt::format(
          "Of sessions of pure noise a share of {:.2g} looks as much like some cause.",
          chance));
    }
  }
  const auto standing = [&](const char* word) {
    std::vector<std::string> names;
    for (const Json& cause : document["causes"]) {
      if (!is_data_fault(cause) && cause["standing"] == word) names.push_back(named(cause));
    }
    return names;
  };
  if (const auto names = standing("confirmed"); !names.empty()) {
    lines.push_back(capital(fmt::format(
        "{}: confirmed, as the points that were fitted and the points that were not both show "
        "it.",
        list_of(names))));
  }
  if (const auto names = standing("suspected"); !names.empty()) {
    lines.push_back(capital(fmt::format(
        "{}: suspected only, {}", list_of(names),
        document["gain"].empty()
            ? "as the held-out points were not asked (no gain was computed)."
            : "as the fitted points or the held-out ones alone do not show it clearly; measure "
              "more before spending money on it.")));
  }
  if (!document["unexplained"]["significant"].get<bool>()) {
    lines.push_back(remainder_sentence(document));
  }
  return lines;
}

}  // namespace

std::string cause_in_words(std::string_view cause, std::string_view where) {
  if (cause == "outliers") return "gross reading errors";
  if (cause == "stale_reading") return "readings handed over twice";
  if (cause == "none") return "nothing";
  if (cause == "unknown") return fmt::format("something unnamed that depends on {}", where);
  const simulation::Effect* effect = simulation::find_effect(cause);
  std::string words(effect != nullptr ? effect->in_words : cause);
  if (cause == "dial_swap") {
    const std::size_t comma = where.find(',');
    if (comma == std::string_view::npos) return words;
    return fmt::format("{} {} and {}", words, where.substr(0, comma), where.substr(comma + 1));
  }
  if (where.starts_with("joint") && where != "joints") {
    return fmt::format("{} of {}", words, joint_words(where));
  }
  if (where == "joints") return words + " of the joints";
  if (where.empty()) return words;
  if (const std::size_t at = words.find(" a dial"); at != std::string::npos) {
    return words.replace(
        at, std::string_view(" a dial").size(), fmt::format(" dial {}", where));
  }
  if (cause == "step") {
    return one_dial(where) ? fmt::format("{} of dial {}", words, where)
                           : fmt::format("{} of the {}", words, where);
  }
  return words;
}

std::string named(const Json& cause) {
  return cause_in_words(text_of(cause.at("cause")), text_of(cause.at("where")));
}

std::string quantity_in_words(double value, double sd, std::string_view unit) {
  const Shown shown = shown_unit(unit);
  const double size = value * shown.factor;
  const double uncertain = sd * shown.factor;
  if (!std::isfinite(uncertain) || !(uncertain > 0.0)) {
    return fmt::format("{:.3g}{}", size, shown.unit);
  }
  const int decimals = decimals_of(uncertain);
  return fmt::format(
      "{:.{}f}{} \u00B1 {:.{}f}{}", size, decimals, shown.unit, uncertain, decimals,
      shown.unit);
}

std::string size_in_words(const Json& cause) {
  const Json& estimate = cause.at("estimate");
  if (estimate.empty()) return "";
  const std::string id = cause.at("cause");
  if (is_data_fault(cause)) {
    return fmt::format(
        "{} {}, {:.3f} mm rms", estimate[0]["value"].get<int>(),
        estimate[0]["value"].get<int>() == 1 ? "reading" : "readings",
        number_of(estimate[1]["value"]));
  }
  if (id == "dial_swap") {
    return fmt::format("they differ by {:.2f} mm rms", number_of(estimate[0]["value"]));
  }
  if (id == "step") {
    const Json x = estimate_of(cause, "shift");
    const Json y = estimate_of(cause, "shift_y");
    const std::string size = y.is_null() ? quantity(x) : together(x, y);
    return fmt::format(
        "{} from sample {:.0f} on", size, number_of(estimate_of(cause, "sample")["value"]));
  }
  if (id == "dial_cyclic") {
    return fmt::format(
        "amplitude {}, period {:.3g} mm", together(estimate[0], estimate[1]),
        number_of(estimate_of(cause, "period")["value"]));
  }
  if (id == "joint_eccentricity" || id == "joint_second_harmonic") {
    return "amplitude " + together(estimate[0], estimate[1]);
  }
  if (id == "base_drift" || id == "cuboid_offset") return together(estimate[0], estimate[1]);
  if (id == "joint_compliance") {
    return fmt::format("joint 1 {}, joint 2 {}", quantity(estimate[0]), quantity(estimate[1]));
  }
  return quantity(estimate[0]);
}

std::string remark_on_gross(const Json& reading) {
  if (reading["stale"].get<bool>()) return "the same as at the sample before";
  return reading["near_edge"].get<bool>() ? "touches at the edge of the face" : "";
}

std::string millimetres(const Json& value) {
  return value.is_number() ? fmt::format("{:.4f} mm", value.get<double>()) : "-";
}

Json verdict_in_words(const Json& document) {
  const std::string kind = kind_of(document);
  std::vector<std::string> found;
  for (const bool faults : {false, true}) {
    for (const Json& cause : document["causes"]) {
      if (is_data_fault(cause) == faults) found.push_back(found_line(cause));
    }
    if (!faults && document["unexplained"]["significant"].get<bool>()) {
      found.push_back(remainder_sentence(document));
    }
  }
  if (found.empty()) found.push_back("No cause of the catalogue shows itself in this session.");
  std::string headline;
  if (kind == "nothing") {
    headline = fmt::format(
        "Nothing was found that the simulation gets wrong. {}", remainder_sentence(document));
  } else {
    for (const std::string& line : found) headline += (headline.empty() ? "" : " ") + line;
  }
  const std::string gain = gain_sentence(document);
  if (!gain.empty()) headline += " " + gain;
  return {
      {"kind", kind},
      {"title", title_of(document, kind)},
      {"headline", headline},
      {"found", found},
      {"gain", gain},
      {"to_do", to_do(document)},
      {"trust", trust(document)},
      {"not_judged", not_judged(document)}};
}

}  // namespace sixdial::studies
