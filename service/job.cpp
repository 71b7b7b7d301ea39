#include "service/job.h"

#include "report/documents/fields.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::Progress>& progress) {
  at("stage", progress.stage);
  at("done", progress.done);
  at("total", progress.total);
  at("best_mm", progress.best_mm);
  at("eta_s", progress.eta_s);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, service::Job>& job) {
  at("job", job.id);
  at("kind", job.kind);
  at("session", job.session);
  at("operator", job.caller.operator_name);
  if constexpr (!Fields::kReads) at("params", job.params);
  at.named(
      "state", job.state, [](db::JobState state) { return db::to_string(state); },
      [](const std::string& text) { return db::job_state_from(text); });
  at("progress", job.progress);
  at("created_utc", job.created_utc);
  at("started_utc", job.started_utc);
  at("finished_utc", job.finished_utc);
  at("result", job.result_id);
  at("error", job.error);
}

}  // namespace sixdial::report

namespace sixdial::service {

Json to_json(const Job& job) { return report::write(job); }
Job job_from_json(const Json& json) { return report::read<Job>(json, "job.status"); }

Json to_json(const studies::Progress& progress) { return report::write(progress); }
studies::Progress progress_from_json(const Json& json) {
  return report::read<studies::Progress>(json, "progress");
}

}  // namespace sixdial::service
