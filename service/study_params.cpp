#include "service/study_params.h"

#include <optional>
#include <string>
#include <vector>

namespace sixdial::service {
namespace {

/// Writes what a request asks for; what it leaves open is left out.
class ParamWriter {
 public:
  explicit ParamWriter(Json& params) : params_(params) {}
  template <class T>
  void operator()(const char* key, const T& value) {
    params_[key] = value;
  }
  template <class T>
  void operator()(const char* key, const std::optional<T>& value) {
    if (value) params_[key] = *value;
  }
  void operator()(const char* key, const std::vector<std::string>& value) {
    if (!value.empty()) params_[key] = value;
  }
  void operator()(const char* key, const calibration::Profile& profile) {
    params_[key] = calibration::to_string(profile);
  }

 private:
  Json& params_;
};

class ParamReader {
 public:
  explicit ParamReader(const Json& params) : params_(params) {}
  template <class T>
  void operator()(const char* key, T& value) {
    if (const Json* given = find(key)) value = given->get<T>();
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) {
    if (const Json* given = find(key)) value = given->get<T>();
  }
  void operator()(const char* key, calibration::Profile& profile) {
    if (const Json* given = find(key)) {
      profile = calibration::profile_from(given->get<std::string>()).value_or(profile);
    }
  }

 private:
  [[nodiscard]] const Json* find(const char* key) const {
    const auto found = params_.find(key);
    return found == params_.end() || found->is_null() ? nullptr : &*found;
  }
  const Json& params_;
};

/// What calibration and comparison are asked alike.
template <class At, class Request>
void fit_params(At& at, Request& request) {
  at("seed", request.seed);
  at("threads", request.threads);
  at("particles", request.particles);
  at("qpso1_iterations", request.qpso1_iterations);
  at("qpso2_iterations", request.qpso2_iterations);
  at("anfis_epochs", request.anfis_epochs);
  at("profile", request.profile);
  at("fix", request.fix);
  at("free", request.free);
  at("keep_gross_errors", request.keep_gross_errors);
}

template <class At, class Request>
void calibration_params(At& at, Request& request) {
  at("method", request.method);
  at("tolerance_mm", request.tolerance_mm);
  fit_params(at, request);
}

template <class At, class Request>
void comparison_params(At& at, Request& request) {
  fit_params(at, request);
  at("methods", request.methods);
  at("space", request.space);
  at("loss", request.loss);
  at("bpnn_epochs", request.bpnn_epochs);
}

template <class At, class Request>
void diagnosis_params(At& at, Request& request) {
  at("seed", request.seed);
  at("bootstrap", request.bootstrap);
  at("gain", request.with_gain);
  at("samples", request.most_samples);
  at("threads", request.threads);
}

}  // namespace

Json params_of(const studies::CalibrationRequest& request) {
  Json params = Json::object();
  ParamWriter at(params);
  calibration_params(at, request);
  return params;
}

Json params_of(const studies::CompareRequest& request) {
  Json params = Json::object();
  ParamWriter at(params);
  comparison_params(at, request);
  return params;
}

Json params_of(const studies::DiagnosisRequest& request) {
  Json params = Json::object();
  ParamWriter at(params);
  diagnosis_params(at, request);
  return params;
}

studies::CalibrationRequest calibration_request(const Json& params) {
  studies::CalibrationRequest request;
  ParamReader at(params);
  calibration_params(at, request);
  return request;
}

studies::CompareRequest comparison_request(const Json& params) {
  studies::CompareRequest request;
  ParamReader at(params);
  comparison_params(at, request);
  return request;
}

studies::DiagnosisRequest diagnosis_request(const Json& params) {
  studies::DiagnosisRequest request;
  ParamReader at(params);
  diagnosis_params(at, request);
  return request;
}

}  // namespace sixdial::service
