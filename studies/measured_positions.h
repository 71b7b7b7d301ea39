// Where the tool was when a validation measured it. A diagnosis that names something wrong with
// the instrument (a dial's scale, the cuboid's size) says that positions computed from the rig
// file are off: then they are computed with it, for every way of commanding alike.
#pragma once

#include <optional>
#include <vector>

#include "session/session.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

/// True if a named cause changes what the instrument reads of the same pose.
[[nodiscard]] bool names_the_instrument(
    const DiagnosisResult& diagnosis, const geometry::Rig& rig);

/// By sample of `validation`; empty where its readings give no position. `diagnosis`: of
/// `calibrated`, or null. What depends on order or time goes on from the calibrated session.
[[nodiscard]] std::vector<std::optional<Eigen::VectorXd>> measured_positions(
    const session::Session& calibrated, const session::Session& validation,
    const DiagnosisResult* diagnosis);

}  // namespace sixdial::studies
