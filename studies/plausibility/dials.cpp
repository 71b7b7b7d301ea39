// Dials whose readings come under another's name, or in another unit. The fit would bend the
// robot until they agree: nothing is calibrated before the file says what the readings are.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "studies/plausibility/check.h"
#include "studies/plausibility/dial_hypotheses.h"

namespace sixdial::studies::plausibility {
namespace {

double worst_of(const std::vector<double>& by_column, const std::vector<std::size_t>& columns) {
  double worst = 0.0;
  for (const std::size_t k : columns) worst = std::max(worst, by_column[k]);
  return worst;
}

WarningPlace columns_place(const std::vector<std::string>& ids) {
  std::string fields;
  for (const std::string& id : ids) {
    fields += (fields.empty() ? "dial_" : ", dial_") + id + "_mm";
  }
  return {.file = "session.csv", .field = std::move(fields)};
}

struct Columns {
  std::vector<std::size_t> index;
  std::vector<std::string> ids;
};

/// "all dials", "dial C", "dials A and B".
std::string named(const Columns& columns, std::size_t dials) {
  if (columns.ids.size() == dials) return "all dials";
  return dials_in_words(columns.ids);
}

/// Where a dial that counts the other way begins: most likely at the end of its travel.
double begins_at(const geometry::Dial& dial, double offset_mm) {
  constexpr double kNearEnd_mm = 5.0;  // how well mount and robot are known
  const double travel_mm = dial.geometry.travel_mm;
  return std::abs(offset_mm - travel_mm) < kNearEnd_mm ? travel_mm : offset_mm;
}

void tell_units(Look& look, const DialJudgement& judged) {
  std::map<double, Columns> by_unit;
  const auto& dials = look.used.rig.dials;
  for (std::size_t k = 0; k < dials.size(); ++k) {
    const double mm = judged.best.mm_per_unit[k];
    if (mm == 1.0) continue;
    by_unit[mm].index.push_back(k);
    by_unit[mm].ids.push_back(dials[k].id);
  }
  for (const auto& [mm, columns] : by_unit) {
    WarningParts parts{
        {"dials", named(columns, dials.size())},
        {"now", worst_of(judged.as_is_mm, columns.index)},
        {"miss", worst_of(judged.best_mm, columns.index)}};
    if (mm != kReversed) {
      parts["unit"] = std::string(unit_of(mm));
      parts["factor"] = mm;
      parts["scale_in_words"] =
          mm > 1.0 ? fmt::format("1/{:g}", mm) : fmt::format("{:g}", 1.0 / mm);
    }
    look.tell(
        mm == kReversed ? "dial_reversed" : "dial_unit", Severity::kWrong,
        columns_place(columns.ids), std::move(parts));
  }
  // What follows is fitted to millimetres, so that it can be read at all.
  for (session::Sample& sample : look.used.samples) {
    for (std::size_t k = 0; k < dials.size() && k < sample.channels.size(); ++k) {
      auto& value = sample.channels[k].value;
      if (!value) continue;
      const double mm = judged.best.mm_per_unit[k];
      const auto dial = static_cast<std::size_t>(judged.best.shows[k]);
      *value *= mm;
      if (mm == kReversed) *value += begins_at(dials[dial], judged.best.offset_mm[k]);
    }
  }
}

void tell_exchange(Look& look, const DialJudgement& judged) {
  const auto& dials = look.used.rig.dials;
  Columns columns;
  std::string how;
  for (std::size_t k = 0; k < dials.size(); ++k) {
    const auto dial = static_cast<std::size_t>(judged.best.shows[k]);
    if (dial == k) continue;
    columns.index.push_back(k);
    columns.ids.push_back(dials[k].id);
    how += (how.empty() ? "" : ", ") + dials[k].id + " shows " + dials[dial].id;
  }
  look.tell(
      "dials_exchanged", Severity::kWrong, columns_place(columns.ids),
      {{"dials", listed(columns.ids)},
       {"how", how},
       {"now", worst_of(judged.as_is_mm, columns.index)},
       {"miss", worst_of(judged.best_mm, columns.index)}});
  look.dial_of_column = judged.best.shows;
  for (session::Sample& sample : look.used.samples) {
    const std::vector<session::ChannelValue> as_is = sample.channels;
    for (std::size_t k = 0; k < dials.size() && k < as_is.size(); ++k) {
      const auto dial = static_cast<std::size_t>(judged.best.shows[k]);
      if (dial < as_is.size()) sample.channels[dial] = as_is[k];
    }
  }
}

}  // namespace

void look_at_dials(Look& look) {
  const auto judged = judge_dials(look.used);
  if (!judged) return;
  tell_units(look, *judged);
  if (judged->best.exchanged()) tell_exchange(look, *judged);
}

}  // namespace sixdial::studies::plausibility

namespace sixdial::studies {

std::optional<std::pair<std::size_t, std::size_t>> exchanged_pair(
    const PlausibleSession& judged) {
  std::vector<std::size_t> moved;
  for (std::size_t k = 0; k < judged.dial_of_column.size(); ++k) {
    if (judged.dial_of_column[k] != static_cast<int>(k)) moved.push_back(k);
  }
  if (moved.size() != 2) return std::nullopt;
  return std::pair{moved[0], moved[1]};
}

}  // namespace sixdial::studies
