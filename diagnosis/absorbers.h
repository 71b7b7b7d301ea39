// Which fitted parameters take an effect over.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "geometry/parameter.h"

namespace sixdial::diagnosis {

/// Up to four parameters that imitate `raw`, the effect's weighted column, best; largest share
/// first. `J`: weighted columns of the fit, those of `parameters` first.
[[nodiscard]] std::vector<std::string> absorbers(
    std::span<const geometry::ParameterInfo> parameters, const Eigen::VectorXd& raw,
    const Eigen::MatrixXd& J);

}  // namespace sixdial::diagnosis
