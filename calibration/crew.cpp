#include "calibration/crew.h"

#include <utility>

#include "geometry/long_work.h"

namespace sixdial::calibration {
namespace {

thread_local Crew* current = nullptr;

}  // namespace

Crew::Crew(int threads) : workers_(threads), before_(current) { current = this; }

Crew::~Crew() { current = before_; }

int crew_size() { return current == nullptr ? 1 : current->workers_.count(); }

void in_parallel(int parts, const std::function<void(int)>& part) {
  Crew* const crew = current;
  if (crew == nullptr || parts < 2) {
    for (int i = 0; i < parts; ++i) part(i);
    return;
  }
  struct Alone {  // parts of a part are done where it is done
    Crew* const crew = std::exchange(current, nullptr);
    Alone() = default;
    Alone(const Alone&) = delete;
    Alone& operator=(const Alone&) = delete;
    ~Alone() { current = crew; }
  };
  const Alone alone;
  const std::stop_token stop = geometry::stop_of_this_work();
  const std::thread::id caller = std::this_thread::get_id();
  crew->workers_.run(parts, [&](int i) {
    if (std::this_thread::get_id() == caller) {
      part(i);  // its LongWork also tells how far the work is
    } else {
      const geometry::LongWork work(stop);
      part(i);
    }
  });
}

}  // namespace sixdial::calibration
