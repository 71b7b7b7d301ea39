// A study as long work: ended from outside it is a StudyError like any other.
#pragma once

#include <stop_token>
#include <string>
#include <utility>

#include "geometry/long_work.h"
#include "studies/error.h"

namespace sixdial::studies {

/// What `work` returns. Throws StudyError cancelled ("the diagnosis was cancelled") where it
/// was ended as asked.
template <class Work>
auto cancellable(
    const std::string& what, const std::string& session, std::stop_token stop,
    geometry::StepListener steps, const Work& work) {
  const geometry::LongWork here(std::move(stop), std::move(steps));
  try {
    return work();
  } catch (const geometry::WorkEnded&) {
    throw StudyError(
        StudyErrorCode::kCancelled, what + " was cancelled", {{"session", session}});
  }
}

}  // namespace sixdial::studies
