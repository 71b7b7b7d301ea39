// Where the tool was when a validation measured it. A diagnosis that names something wrong with
// the instrument (a dial's scale, the cuboid's size) says that positions computed from the rig
// file are off: then they are computed with it, for every way of commanding alike. What it
// found of the rig within what the file states is the frame that it commands in.
#pragma once

#include <optional>
#include <vector>

#include "session/session.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

/// True if a named cause changes what the instrument reads of the same pose.
[[nodiscard]] bool names_the_instrument(
    const DiagnosisResult& diagnosis, const geometry::Rig& rig);

/// By sample of `validation`; empty where its readings give no position.
using PositionOfSample = std::vector<std::optional<Eigen::VectorXd>>;
/// By the rig as it stands in the session.
[[nodiscard]] PositionOfSample measured_positions(const session::Session& validation);
/// By all that `diagnosis`, of `calibrated`, says of instrument and rig. What depends on order
/// or time goes on from the calibrated session.
[[nodiscard]] PositionOfSample explained_positions(
    const session::Session& calibrated, const session::Session& validation,
    const DiagnosisResult& diagnosis);

}  // namespace sixdial::studies
