// What one collection owns while it runs, and what is kept of it until the next. Only for the
// sources of Collection.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "acquisition/clock_watch.h"
#include "service/collection.h"
#include "studies/live_estimate.h"

namespace sixdial::service {

struct Collection::Run {
  explicit Run(const acquisition::Clock& clock) : clock_watch(clock) {}

  db::SessionId id;
  geometry::Rig rig;
  geometry::Rig seen_rig;  // as its instrument is: without dials that are channels of another
  session::Plan plan;
  std::set<db::PointKey> done;
  acquisition::CollectorSettings settings;
  std::optional<double> stop_below_mm;
  std::optional<int> speed_percent;
  bool first_pass = false;
  std::string before_first_move;       // what a person looks at; empty: nobody is asked
  std::optional<std::size_t> doubted;  // the first pass halted here, for a person to look at
  Caller caller;
  std::optional<studies::LiveEstimate> estimate;  // in the collection's thread alone
  std::stop_token stop;                           // of that thread
  acquisition::ClockWatch clock_watch;
  /// Shared: halt_robot() may still be telling it to stop while the collection ends.
  std::shared_ptr<acquisition::RobotPort> robot;
  std::unique_ptr<acquisition::DialBank> dials;
  std::unique_ptr<acquisition::Collector> collector;
  std::jthread live;  // last: it looks at the dials
};

}  // namespace sixdial::service
