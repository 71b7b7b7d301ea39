#include "calibration/bpnn_kernel.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/bpnn_kernel.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

HWY_INLINE HWY_ATTR V tanh_of(D d, V z) {
  // 1 - 2 / (exp(2 z) + 1)
  const V twice = hn::Min(hn::Max(hn::Add(z, z), hn::Set(d, -80.0)), hn::Set(d, 80.0));
  const V e = hn::CallExp(d, twice);
  const V one = hn::Set(d, 1.0);
  return hn::Sub(one, hn::Div(hn::Set(d, 2.0), hn::Add(e, one)));
}

HWY_INLINE HWY_ATTR double total(D d, V v) { return hn::GetLane(hn::SumOfLanes(d, v)); }

/// A shape whose numbers the compiler knows, or (0, 0) one that is known at run time only.
template <int Inputs, int Outputs>
struct Network {
  static constexpr std::size_t kMostOutputs = Outputs > 0 ? Outputs : kMostBpnnColumns;
  static constexpr std::size_t kMostWeights =
      Inputs > 0 ? Inputs + 1 + Outputs : 2 * kMostBpnnColumns + 1;
  BpnnShape shape;
  std::ptrdiff_t n;  // padded samples
  const double* x;
  const double* y;
  const double* use;
  const double* weights;
  [[nodiscard]] int inputs() const { return Inputs > 0 ? Inputs : shape.inputs; }
  [[nodiscard]] int outputs() const { return Outputs > 0 ? Outputs : shape.outputs; }
  [[nodiscard]] const double* unit(std::ptrdiff_t h) const {
    return weights + h * (inputs() + 1 + outputs());
  }
};

/// Outputs minus targets into `error` (outputs x n), tanh of the hidden units into `activation`
/// (hidden x n); returns the sum of squares lane by lane.
template <int Inputs, int Outputs>
HWY_INLINE HWY_ATTR V
forward(D d, const Network<Inputs, Outputs>& net, double* error, double* activation) {
  const auto step = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  const int ins = net.inputs();
  const int outs = net.outputs();
  const double* bias = net.unit(net.shape.hidden);
  V squares = hn::Zero(d);
  for (std::ptrdiff_t a = 0; a < net.n; a += step) {
    V sum[Network<Inputs, Outputs>::kMostOutputs];
    for (int o = 0; o < outs; ++o) sum[o] = hn::Set(d, bias[o]);
    for (std::ptrdiff_t h = 0; h < net.shape.hidden; ++h) {
      const double* w = net.unit(h);
      V z = hn::Set(d, w[ins]);
      for (int i = ins - 1; i >= 0; --i) {
        z = hn::MulAdd(hn::Set(d, w[i]), hn::LoadU(d, net.x + i * net.n + a), z);
      }
      const V t = tanh_of(d, z);
      hn::StoreU(t, d, activation + h * net.n + a);
      for (int o = 0; o < outs; ++o) {
        sum[o] = hn::MulAdd(hn::Set(d, w[ins + 1 + o]), t, sum[o]);
      }
    }
    const V used = hn::LoadU(d, net.use + a);
    for (int o = outs - 1; o >= 0; --o) {
      const V e = hn::Mul(hn::Sub(sum[o], hn::LoadU(d, net.y + o * net.n + a)), used);
      hn::StoreU(e, d, error + o * net.n + a);
      squares = hn::MulAdd(e, e, squares);
    }
  }
  return squares;
}

/// The gradient of the sum of squares.
template <int Inputs, int Outputs>
HWY_INLINE HWY_ATTR void backward(
    D d, const Network<Inputs, Outputs>& net, const double* error, const double* activation,
    double* gradient) {
  const auto step = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  const int ins = net.inputs();
  const int outs = net.outputs();
  const V one = hn::Set(d, 1.0);
  for (std::ptrdiff_t h = 0; h < net.shape.hidden; ++h) {
    const double* w = net.unit(h) + ins + 1;
    V g[Network<Inputs, Outputs>::kMostWeights];
    for (int k = 0; k < ins + 1 + outs; ++k) g[k] = hn::Zero(d);
    for (std::ptrdiff_t a = 0; a < net.n; a += step) {
      const V t = hn::LoadU(d, activation + h * net.n + a);
      V back = hn::Mul(hn::Set(d, w[outs - 1]), hn::LoadU(d, error + (outs - 1) * net.n + a));
      for (int o = outs - 2; o >= 0; --o) {
        back = hn::MulAdd(hn::Set(d, w[o]), hn::LoadU(d, error + o * net.n + a), back);
      }
      back = hn::Mul(back, hn::NegMulAdd(t, t, one));
      for (int i = 0; i < ins; ++i) {
        g[i] = hn::MulAdd(back, hn::LoadU(d, net.x + i * net.n + a), g[i]);
      }
      g[ins] = hn::Add(back, g[ins]);
      for (int o = 0; o < outs; ++o) {
        g[ins + 1 + o] = hn::MulAdd(t, hn::LoadU(d, error + o * net.n + a), g[ins + 1 + o]);
      }
    }
    double* of_unit = gradient + h * (ins + 1 + outs);
    for (int k = 0; k < ins + 1 + outs; ++k) of_unit[k] = 2.0 * total(d, g[k]);
  }
  double* of_bias = gradient + static_cast<std::ptrdiff_t>(net.shape.hidden) * (ins + 1 + outs);
  for (int o = 0; o < outs; ++o) {
    V sum = hn::Zero(d);
    for (std::ptrdiff_t a = 0; a < net.n; a += step) {
      sum = hn::Add(sum, hn::LoadU(d, error + o * net.n + a));
    }
    of_bias[o] = 2.0 * total(d, sum);
  }
}

template <int Inputs, int Outputs>
HWY_INLINE HWY_ATTR double epoch(
    const Network<Inputs, Outputs>& net, double* gradient, double* scratch) {
  const D d;
  double* activation = scratch + net.outputs() * net.n;
  const V squares = forward(d, net, scratch, activation);
  if (gradient != nullptr) backward(d, net, scratch, activation, gradient);
  return total(d, squares);
}

HWY_ATTR double error(
    const BpnnShape& shape, int padded, const double* x, const double* y, const double* use,
    const double* weights, double* gradient, double* scratch) {
  if (shape.inputs == 2 && shape.outputs == 2) {
    return epoch(Network<2, 2>{shape, padded, x, y, use, weights}, gradient, scratch);
  }
  return epoch(Network<0, 0>{shape, padded, x, y, use, weights}, gradient, scratch);
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(error);

double bpnn_error(
    const BpnnShape& shape, int padded, const double* x, const double* y, const double* use,
    const double* weights, double* gradient, double* scratch) {
  return HWY_DYNAMIC_DISPATCH(error)(shape, padded, x, y, use, weights, gradient, scratch);
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
