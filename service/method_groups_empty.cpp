#include "service/method.h"
namespace sixdial::service {
std::span<const Method> session_methods() { return {}; }
std::span<const Method> collect_methods() { return {}; }
std::span<const Method> result_methods() { return {}; }
}
