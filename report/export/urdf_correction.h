// A URDF that an arm came from with the origins of its joints set right: links, shapes, masses,
// limits and comments stay, and so do joints that are no part of the arm.
#pragma once

#include <string>

#include "report/export/joint_chain.h"

namespace sixdial::report {

/// `nominal`: the arm as the file has it; `comment`: what is put at its head. Throws StudyError
/// invalid_params where the text is no URDF, lacks a joint, or has one elsewhere than the
/// nominal arm.
[[nodiscard]] std::string corrected_urdf(
    const std::string& text, const JointChain& nominal, const JointChain& calibrated,
    const std::string& comment);

}  // namespace sixdial::report
