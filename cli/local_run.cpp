#include "cli/local_run.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "report/words/warning_words.h"
#include "service/socket/client.h"
#include "studies/error.h"
#include "studies/plausibility.h"

namespace sixdial::cli {

void run_with_progress(const Console& console, const std::string& what, const LocalWork& work) {
  constexpr auto kLookForSignal = std::chrono::milliseconds(100);
  ProgressLine line(console);
  std::stop_source interruption;
  bool interrupted = false;
  // A signal's handler must not ask for the stop itself, and stages may be long.
  std::jthread watch([&](const std::stop_token& over) {
    std::mutex mutex;
    std::condition_variable_any ended;
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, over, kLookForSignal, [&] { return over.stop_requested(); })) {
      if (!service::take_interruption()) continue;
      interrupted = true;
      service::end_soon("\ninterrupted; nothing of it is kept\n");
      interruption.request_stop();
      return;
    }
  });
  const auto end_watch = [&] {
    watch.request_stop();
    if (watch.joinable()) watch.join();
    line.clear();
  };
  const auto give_up = [&] {
    console.note(fmt::format("{} was interrupted; nothing of it is kept", what));
    throw service::Interrupted();
  };
  try {
    work(
        [&](const studies::Progress& progress) { line.show(progress); },
        interruption.get_token());
  } catch (const studies::StudyError& error) {
    end_watch();
    if (error.code() == studies::StudyErrorCode::kCancelled && interrupted) give_up();
    throw;
  }
  end_watch();
  if (interrupted) give_up();
}

void tell_why(const Console& console, const session::Session& session) {
  for (const std::string& line : report::warning_lines(studies::plausible(session).warnings)) {
    console.warn(line);
  }
}

}  // namespace sixdial::cli
