#include "report/words/budget_words.h"

#include <fmt/format.h>

#include <utility>

#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

using studies::BudgetSource;
using studies::BudgetState;
using studies::Measurand;

constexpr std::pair<BudgetSource, std::string_view> kSources[] = {
    {BudgetSource::kRepeatability, "repeatability"},
    {BudgetSource::kResolution, "resolution"},
    {BudgetSource::kInstrument, "instrument"},
    {BudgetSource::kDialCurve, "dial_curve"},
    {BudgetSource::kRig, "rig"},
    {BudgetSource::kFittedAlong, "fitted_along"},
    {BudgetSource::kOpen, "open_directions"},
    {BudgetSource::kFit, "fit"},
    {BudgetSource::kArrival, "arrival"},
    {BudgetSource::kTemperature, "temperature"}};
constexpr std::pair<BudgetState, std::string_view> kStates[] = {
    {BudgetState::kCounted, "counted"},
    {BudgetState::kExact, "exact"},
    {BudgetState::kNotStated, "not_stated"},
    {BudgetState::kContained, "contained"},
    {BudgetState::kPart, "part"}};
constexpr std::pair<Measurand, std::string_view> kMeasurands[] = {
    {Measurand::kMeasured, "measured"}, {Measurand::kCommanded, "commanded"}};

template <class List, class Value>
std::string_view name_in(const List& list, Value value) {
  for (const auto& [each, name] : list) {
    if (each == value) return name;
  }
  return "";
}

template <class Value, class List>
std::optional<Value> value_in(const List& list, std::string_view wanted) {
  for (const auto& [each, name] : list) {
    if (name == wanted) return each;
  }
  return std::nullopt;
}

std::string plain_words(const studies::BudgetRow& row, Measurand measurand) {
  switch (row.source) {
    case BudgetSource::kRepeatability:
      return "repeatability of the dials";
    case BudgetSource::kResolution:
      return "resolution of the dials";
    case BudgetSource::kInstrument:
      return "scatter of the instrument";
    case BudgetSource::kDialCurve:
      return fmt::format("error curve of dial {}", row.of);
    case BudgetSource::kRig:
      return row.of;
    case BudgetSource::kFittedAlong:
      return "what is left open of the rig and of the dials' curves";
    case BudgetSource::kOpen:
      return "what the poses leave open, held at nominal";
    case BudgetSource::kFit:
      return "fit of the robot's parameters: what it leaves beyond the readings' own";
    case BudgetSource::kArrival:
      return "the tool's arrival, by repeats of the same poses";
    case BudgetSource::kTemperature:
      return measurand == Measurand::kMeasured
                 ? "growth of the cuboid or target, and of what carries the instrument"
                 : "what went with the temperature of the session";
  }
  return "";
}

}  // namespace

std::string_view budget_source_name(BudgetSource source) { return name_in(kSources, source); }
std::optional<BudgetSource> budget_source_from(std::string_view name) {
  return value_in<BudgetSource>(kSources, name);
}
std::string_view budget_state_name(BudgetState state) { return name_in(kStates, state); }
std::optional<BudgetState> budget_state_from(std::string_view name) {
  return value_in<BudgetState>(kStates, name);
}
std::string_view measurand_name(Measurand measurand) { return name_in(kMeasurands, measurand); }
std::optional<Measurand> measurand_from(std::string_view name) {
  return value_in<Measurand>(kMeasurands, name);
}

std::string source_in_words(const studies::BudgetRow& row, Measurand measurand) {
  std::string words = capital(plain_words(row, measurand));
  if (!row.not_stated.empty()) words += fmt::format(" (of {})", row.not_stated);
  return words;
}

std::string_view measurand_in_words(Measurand measurand) {
  return measurand == Measurand::kMeasured ? "A position, measured once"
                                           : "The tool, commanded by the identified parameters";
}

}  // namespace sixdial::report
