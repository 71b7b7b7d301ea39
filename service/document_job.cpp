#include "service/document_job.h"

#include <string_view>
#include <utility>

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
      std::move(job), [&service, id, kind, seed, make = std::move(make)](
                          const JobControl& control, const Job& self) {
        const Json document = make(
            service.reader().load_session(id),
            [&](JobProgress progress) { control.report(std::move(progress)); },
            control.stop_token());
        control.check();
        db::NewResult result;
        result.session = id;
        result.kind = kind;
        result.json = document.dump();
        result.settings = document["inputs"]["settings"].dump();
        result.seed = seed;
        constexpr std::size_t kPrefix = std::string_view("sha256:").size();
        result.data_sha256 = document["inputs"]["data_hash"].get<std::string>().substr(kPrefix);
        result.job = db::JobId{self.id};
        return service.store().save_result(result).value;
      });
  return to_json(started);
}

}  // namespace sixdial::service
