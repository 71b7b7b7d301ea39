#include "service/session_choices.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "report/documents/warnings_document.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "simulation/forward_model.h"
#include "studies/plausibility.h"

namespace sixdial::service {
namespace {

// As calibration/pipeline.cpp and diagnosis/diagnosis.cpp ask for.
constexpr std::size_t kLeastOfG1 = 3;
constexpr std::size_t kLeastReadingsMore = 10;  // than the model has parameters

struct Counts {
  std::size_t positions_g1 = 0;
  std::size_t readings = 0;
};

Counts counts_of(const session::Session& session) {
  Counts counts;
  for (const session::Sample& sample : session.samples) {
    const bool placed = session::trial_of(session.rig, sample).position_mm.has_value();
    if (placed && sample.set == "G1") ++counts.positions_g1;
    // A position counts where there are no dials to count.
    const std::span channels(sample.channels);
    const std::size_t dials = session.rig.dials.size();
    counts.readings += static_cast<std::size_t>(std::ranges::count_if(
        dials > 0 ? channels.first(std::min(dials, channels.size())) : channels,
        [](const session::ChannelValue& each) { return each.value.has_value(); }));
  }
  return counts;
}

/// The newest result of this kind: is there one, and is it of these very samples?
struct Newest {
  bool there = false;
  bool current = false;
};
Newest newest(
    db::Store& reader, db::SessionId id, const char* kind, const std::string& data_sha256) {
  const std::vector<db::ResultRecord> all = reader.load_results(id, kind);
  if (all.empty()) return {};
  return {.there = true, .current = all.back().data_sha256 == data_sha256};
}

}  // namespace

Json session_choices(Service& service, const std::string& name) {
  db::Store& reader = service.reader();
  const db::SessionId id = reader.find_session(name);
  const session::Session session = reader.load_session(id);
  const std::string data = session::data_sha256(session);
  const Counts counts = counts_of(session);
  const bool active = service.collection().active();
  const auto collected = service.collection().status()["session"].get<std::string>();
  const bool here = active && collected == name;
  std::string job;
  for (const Job& each : service.jobs().list()) {
    if (each.session == name && !is_final(each.state)) {
      job = fmt::format("job {} ({}) is under way", each.id, each.kind);
    }
  }

  std::string start, undo, calibrate, diagnose, report;
  if (active) {
    start = here ? "it is being collected" : fmt::format("{} is being collected", collected);
  } else if (!reader.load_plan(id)) {
    start = "there is no plan yet";
  } else if (reader.open_points(id).empty()) {
    start = "every point of the plan is measured";
  }
  if (here) {
    undo = "it is being collected: retake instead";
  } else if (session.samples.empty()) {
    undo = "nothing is measured yet";
  }
  if (here) {
    calibrate = diagnose = "it is being collected";
  } else if (session.samples.empty()) {
    calibrate = diagnose = "nothing is measured yet";
  } else if (!job.empty()) {
    calibrate = diagnose = job;
  } else {
    if (counts.positions_g1 < kLeastOfG1) {
      calibrate = fmt::format(
          "{} positions of set G1, at least {} are needed", counts.positions_g1, kLeastOfG1);
    }
    const std::size_t least =
        simulation::parameters_of(session.rig).size() + kLeastReadingsMore;
    if (counts.readings < least) {
      diagnose = fmt::format("{} readings, at least {} are needed", counts.readings, least);
    }
  }
  const Newest calibration = newest(reader, id, "calibration", data);
  const Newest diagnosis = newest(reader, id, "diagnosis", data);
  Json report_of = nullptr;
  if (calibration.current) {
    report_of = "calibration";
  } else if (diagnosis.current) {
    report_of = "diagnosis";
  } else if (calibration.there || diagnosis.there) {
    report = "samples have changed since: calibrate or diagnose again";
  } else {
    report = "calibrate or diagnose first";
  }
  const auto why_not = [](std::string why) {
    return why.empty() ? Json(nullptr) : Json(std::move(why));
  };
  return {
      {"session", name},
      {"report_of", std::move(report_of)},
      {"warnings", report::warnings_json(studies::plausible(session).warnings)},
      {"choices",
       {{"start", why_not(start)},
        {"undo", why_not(undo)},
        {"calibrate", why_not(calibrate)},
        {"diagnose", why_not(diagnose)},
        {"report", why_not(report)}}}};
}

}  // namespace sixdial::service
