// One epoch of a 2-hidden-2 network with tanh hidden and linear output, vectorised over
// samples.
#pragma once

namespace sixdial::calibration {

/// Weights of one hidden unit: w1, w2, bias, output weights to x and y.
inline constexpr int kUnitWeights = 5;

/// Sum of squared errors of the network, and unless null its gradient. Sample arrays are
/// `padded` long (a multiple of 8) with use[a] = 0 in the padding. weights: hidden * 5, then
/// the two output biases. scratch: (2 + hidden) * padded.
[[nodiscard]] double bpnn_error(
    int hidden, int padded, const double* x1, const double* x2, const double* yx,
    const double* yy, const double* use, const double* weights, double* gradient,
    double* scratch);

}  // namespace sixdial::calibration
