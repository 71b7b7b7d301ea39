// "uncertainty_budgets" of a calibration's document.
#pragma once

#include "report/documents/fields.h"
#include "report/words/budget_words.h"
#include "studies/uncertainty_budget.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::BudgetRow>& row) {
  at.named("source", row.source, budget_source_name, budget_source_from);
  at("of", row.of);
  at("not_stated", row.not_stated);
  at.named("state", row.state, budget_state_name, budget_state_from);
  one_of_two(at, "evaluated", row.by_statistics, true, "A", false, "B");
  at("unit", row.unit);
  at("standard", row.standard);
  at("sensitivity", row.sensitivity);
  at("contribution_mm", row.contribution_mm);
  at("share", row.share);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::UncertaintyBudget>& budget) {
  at.named("measurand", budget.measurand, measurand_name, measurand_from);
  at("rows", budget.rows);
  at("places", budget.places);
  at("combined_mm", budget.combined_mm);
  at("expanded_mm", budget.expanded_mm);
  at("complete", budget.complete);
}

}  // namespace sixdial::report
