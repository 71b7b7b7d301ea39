// The causes and gross readings of a verdict, with ids instead of pointers into the catalogue.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "session/session.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

[[nodiscard]] HypothesisId id_of(const diagnosis::Hypothesis& hypothesis);

/// The id of a dial by its number in the rig; "x" and "y" where a session has positions only.
[[nodiscard]] std::string dial_name(const diagnosis::Readings& readings, int dial);

/// In the order of found.causes, without their curves.
[[nodiscard]] std::vector<FoundCause> causes_of(
    const diagnosis::Diagnosis& found, const diagnosis::Readings& readings);

/// A reading is called stale only if so many equal the reading before that it cannot be chance.
[[nodiscard]] std::vector<GrossReading> gross_readings_of(
    const diagnosis::Diagnosis& found, const diagnosis::Readings& readings,
    const session::Session& session);

/// The rig's geometry as one cause, where the file claims what the readings contradict.
void add_rig_geometry(std::vector<FoundCause>& causes, const diagnosis::Diagnosis& found);
/// One for each dial whose own curve goes beyond accuracy_mm, and for each joint that errs by
/// its own value.
void add_curve_causes(std::vector<FoundCause>& causes, const diagnosis::Diagnosis& found);

/// Outliers and stale readings as causes of their own, where there are such. Of so many
/// readings in all: more than a few gross ones are not certain to be just that.
void add_data_faults(
    std::vector<FoundCause>& causes, const std::vector<GrossReading>& gross,
    std::size_t readings);

}  // namespace sixdial::studies
