#include "calibration/logarithms.h"

#include "calibration/lanes.h"

// Highway compiles what lies between its marks once for every vector unit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/logarithms.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, kLanes>;

HWY_ATTR void logarithms(double* u, std::size_t count) {
  const D d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::StoreU(hn::Neg(hn::CallLog(d, hn::LoadU(d, u + i))), d, u + i);
  }
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(logarithms);

void minus_logarithms(double* u, Eigen::Index count) {
  HWY_DYNAMIC_DISPATCH(logarithms)(u, static_cast<std::size_t>(count));
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
