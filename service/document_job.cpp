#include "service/document_job.h"

#include <utility>

#include "studies/inputs.h"

namespace sixdial::service {

Json start_document_job(
    const Call& call, const std::string& kind, std::uint64_t seed, DocumentMaker make) {
  Service& service = call.service;
  const db::SessionId id =
      service.reader().find_session(call.params.at("session").get<std::string>());
  Job job;
  job.kind = kind;
  job.session = service.reader().session_info(id).name;
  job.caller = call.caller;
  job.params = call.params;
  const Job started = service.jobs().start(
      std::move(job),
      [&service, id, seed, make = std::move(make)](const JobControl& control, const Job& self) {
        const Json document = make(
            service.reader().load_session(id),
            [&](studies::Progress progress) { control.report(std::move(progress)); },
            control.stop_token());
        control.check();
        const Json& inputs = document.at("inputs");  // every document of a session has them
        return save_document(
            service, self, id, document, inputs.at("settings"),
            inputs.at("data_hash").get<std::string>(), seed);
      });
  return to_json(started);
}

std::int64_t save_document(
    Service& service, const Job& job, db::SessionId session, const Json& document,
    const Json& settings, const std::string& data_hash, std::uint64_t seed) {
  db::NewResult result;
  result.session = session;
  result.kind = job.kind;
  result.json = document.dump();
  result.settings = settings.dump();
  result.seed = seed;
  result.data_sha256 = data_hash.substr(studies::kHashPrefix.size());
  result.job = db::JobId{job.id};
  return service.store().save_result(result).value;
}

}  // namespace sixdial::service
