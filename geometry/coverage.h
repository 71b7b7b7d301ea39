// How people are told an uncertainty: as the expanded one, U = k u, where u is the standard
// uncertainty (one standard deviation) and k the coverage factor (GUM 6.2). Files and documents
// carry u itself, under the name sd.
#pragma once

namespace sixdial::geometry {

inline constexpr double kCoverage = 2.0;  // about 95 % of a normal distribution

}  // namespace sixdial::geometry
