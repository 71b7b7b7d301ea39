// Threads that share the independent parts of one long job, however deep in it these stand.
// Whoever starts the job opens a Crew in the thread that does it; the loops inside call
// in_parallel(). Without a Crew, and inside of a part, the calling thread does all by itself:
// so the outermost loop is shared, and results do not depend on the number of threads.
//
// Example:
//   const Crew crew(2);
//   std::vector<int> squares(4);
//   in_parallel(4, [&](int i) { squares[static_cast<std::size_t>(i)] = i * i; });
//   squares;  // -> 0 1 4 9
#pragma once

#include <functional>

#include "calibration/workers.h"

namespace sixdial::calibration {

class Crew {
 public:
  /// `threads` in all, the caller included; for this thread, until the end of the scope. The
  /// one before counts again then.
  explicit Crew(int threads);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

 private:
  friend void in_parallel(int parts, const std::function<void(int)>& part);
  friend int crew_size();
  Workers workers_;
  Crew* const before_;
};

/// Calls part(i) once for each i in 0 .. parts-1, and returns when all are done. Parts must not
/// write what another one reads or writes. The stop of this thread's LongWork ends them on
/// every thread. An exception of a part is thrown here, that of the lowest one.
void in_parallel(int parts, const std::function<void(int)>& part);

/// How many threads in_parallel() would use here.
[[nodiscard]] int crew_size();

}  // namespace sixdial::calibration
