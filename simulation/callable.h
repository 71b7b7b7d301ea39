// A function that a row of a registry names. A row written as a constant names an ordinary
// function; a row made at run time names an object with data of its own (an interpreter's
// function, say). Several threads may call it at once. Unlike std::function it can stand in a
// constinit row and never allocates.
//
//   constinit const Effect effect{.after_kinematics = shift};  // an ordinary function
//
//   row.after_kinematics = Effect::Hook::of(object);  // calls object(x, place, ...)
#pragma once

#include <concepts>
#include <cstddef>
#include <utility>

namespace sixdial::simulation {

template <typename Signature>
class Callable;

template <typename Result, typename... Arguments>
class Callable<Result(Arguments...)> {
 public:
  using Function = Result (*)(Arguments...);

  constexpr Callable() = default;
  constexpr Callable(std::nullptr_t) {}
  constexpr Callable(Function function) : function_(function) {}
  /// A lambda that captures nothing.
  template <std::convertible_to<Function> Lambda>
  constexpr Callable(Lambda lambda) : function_(lambda) {}
  /// `object` must live as long as the row does.
  template <typename Object>
  [[nodiscard]] static Callable of(const Object& object) {
    Callable result;
    result.object_ = &object;
    result.call_ = [](const void* it, Arguments... arguments) -> Result {
      return (*static_cast<const Object*>(it))(std::forward<Arguments>(arguments)...);
    };
    return result;
  }

  constexpr explicit operator bool() const { return function_ || call_; }
  Result operator()(Arguments... arguments) const {
    return function_ ? function_(std::forward<Arguments>(arguments)...)
                     : call_(object_, std::forward<Arguments>(arguments)...);
  }

 private:
  Function function_ = nullptr;
  Result (*call_)(const void*, Arguments...) = nullptr;
  const void* object_ = nullptr;
};

}  // namespace sixdial::simulation
