// One epoch of a network with one hidden layer, tanh hidden and linear output, vectorised over
// samples: any number of inputs and outputs, fastest for the paper's two of each.
#pragma once

namespace sixdial::calibration {

struct BpnnShape {
  int inputs = 2;
  int hidden = 40;
  int outputs = 2;
  /// Weights of one hidden unit: of the inputs, bias, to the outputs.
  [[nodiscard]] int unit_weights() const { return inputs + 1 + outputs; }
  /// Of the units one after the other, then the biases of the outputs.
  [[nodiscard]] int weights() const { return hidden * unit_weights() + outputs; }
};
/// Most inputs, and most outputs, that the kernel takes.
inline constexpr int kMostBpnnColumns = 64;

/// Sum of squared errors of the network, and unless null its gradient. Sample arrays are
/// `padded` long (a multiple of 8), x one for each input and y one for each output, with use[a]
/// = 0 in the padding. scratch: (outputs + hidden) * padded.
[[nodiscard]] double bpnn_error(
    const BpnnShape& shape, int padded, const double* x, const double* y, const double* use,
    const double* weights, double* gradient, double* scratch);

}  // namespace sixdial::calibration
