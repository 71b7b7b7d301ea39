#include "studies/diagnosis_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "diagnosis/gain.h"
#include "geometry/robots/five_bar.h"

namespace sixdial::studies {
namespace {

using diagnosis::JointFit;
using diagnosis::Readings;
using simulation::ActiveEffect;
using simulation::ExtendedModel;
using simulation::Scene;

constexpr double kDeg = 180.0 / std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kGood = 0.5;  // weight from which a reading is not gross

/// What each sample knows, by trial.
struct Known {
  Eigen::VectorXd time_min, temperature_degC;
  Eigen::VectorXd x_mm, y_mm, turn_deg, travel_deg;
};

Known known_of(const DiagnosedReadings& data) {
  const Readings& readings = data.readings;
  const auto n = static_cast<Eigen::Index>(readings.trials().size());
  Known known;
  for (Eigen::VectorXd* each :
       {&known.time_min, &known.temperature_degC, &known.x_mm, &known.y_mm, &known.turn_deg,
        &known.travel_deg}) {
    each->setConstant(n, kNan);
  }
  const ExtendedModel model(readings.model(), data.after.effects);
  Scene scene;
  for (Eigen::Index t = 0; t < n; ++t) {
    const auto& trial = readings.trials()[static_cast<std::size_t>(t)];
    const auto& sample = readings.circumstances()[static_cast<std::size_t>(t)];
    if (trial.time_s) known.time_min[t] = sample.time_h * 60.0;
    if (trial.temperature_c) known.temperature_degC[t] = *trial.temperature_c;
    if (sample.travel.norm() > 0.0) {
      known.travel_deg[t] = std::atan2(sample.travel.y(), sample.travel.x()) * kDeg;
    }
    if (!model.run(data.after.model, trial, sample, scene)) continue;
    known.x_mm[t] = scene.p_WE.x();
    known.y_mm[t] = scene.p_WE.y();
    constexpr double kQuarter_deg = 90.0;
    const double turn = scene.gamma_rad * kDeg;
    known.turn_deg[t] = turn - kQuarter_deg * std::round(turn / kQuarter_deg);
  }
  return known;
}

/// d(readings)/d(angle of a joint) [mm/rad].
Eigen::VectorXd angle_column(const DiagnosedReadings& data, int joint) {
  constexpr double kStep_rad = 1e-5;
  const Readings& readings = data.readings;
  const ExtendedModel model(readings.model(), data.after.effects);
  Eigen::VectorXd plus = Eigen::VectorXd::Zero(readings.count());
  Eigen::VectorXd minus = plus;
  Scene scene;
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    for (const double sign : {1.0, -1.0}) {
      simulation::Trial trial = readings.trials()[t];
      trial.q[joint] += sign * kStep_rad;
      if (model.run(data.after.model, trial, readings.circumstances()[t], scene)) {
        readings.pick(scene, t, sign > 0 ? plus : minus);
      }
    }
  }
  return (plus - minus) / (2 * kStep_rad);
}

/// Least-squares coefficient of a column by trial; NaN where the sample says nothing of it.
Eigen::VectorXd by_trial(
    const Readings& readings, const Eigen::VectorXd& column, const Eigen::VectorXd& weight,
    const Eigen::VectorXd& value) {
  const auto n = static_cast<Eigen::Index>(readings.trials().size());
  Eigen::VectorXd result = Eigen::VectorXd::Constant(n, kNan);
  const double typical =
      column.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, column.size()));
  for (Eigen::Index t = 0; t < n; ++t) {
    const Eigen::Index first = readings.first_row(static_cast<std::size_t>(t));
    const Eigen::Index rows = readings.first_row(static_cast<std::size_t>(t) + 1) - first;
    const auto a = column.segment(first, rows);
    const auto w = weight.segment(first, rows);
    const double normal = w.cwiseProduct(a).dot(a);
    constexpr double kLeast = 1e-2;  // of a typical reading's
    if (!(normal > kLeast * typical)) continue;
    result[t] = w.cwiseProduct(a).dot(value.segment(first, rows)) / normal;
  }
  return result;
}

/// What the fitted cause does to each reading, and what the readings say of it.
struct Part {
  Eigen::VectorXd model, measured;
};
Part part_of(const DiagnosedReadings& data, std::size_t i) {
  const Readings& readings = data.readings;
  std::vector<ActiveEffect> others = data.after.effects;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
  const ExtendedModel all(readings.model(), data.after.effects);
  const ExtendedModel less(readings.model(), others);
  Part part;
  part.model =
      readings.simulate(data.after.model, all) - readings.simulate(data.after.model, less);
  part.measured = data.after.residual_mm + part.model;
  return part;
}

class Curve {
 public:
  Curve(std::string quantity, std::string unit, std::string covariate, std::string its_unit)
      : json_{
            {"quantity", std::move(quantity)},
            {"unit", std::move(unit)},
            {"covariate", std::move(covariate)},
            {"covariate_unit", std::move(its_unit)},
            {"is_function", false},
            {"panels", Json::array()}} {}
  Curve& of_the_covariate_alone() {
    json_["is_function"] = true;
    return *this;
  }
  Curve& panel(std::string title) {
    json_["panels"].push_back({{"title", std::move(title)}, {"groups", Json::array()}});
    return *this;
  }
  Curve& group(
      std::string name, const Eigen::VectorXd& x, const Eigen::VectorXd& measured,
      const Eigen::VectorXd& model, const std::function<bool(Eigen::Index)>& takes = {}) {
    std::vector<Eigen::Index> order;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const bool known =
          std::isfinite(x[k]) && std::isfinite(measured[k]) && std::isfinite(model[k]);
      if (known && (!takes || takes(k))) order.push_back(k);
    }
    std::ranges::stable_sort(
        order, [&](Eigen::Index a, Eigen::Index b) { return x[a] < x[b]; });
    Json group{
        {"name", std::move(name)},
        {"x", Json::array()},
        {"measured", Json::array()},
        {"model", Json::array()}};
    for (const Eigen::Index k : order) {
      group["x"].push_back(x[k]);
      group["measured"].push_back(measured[k]);
      group["model"].push_back(model[k]);
    }
    if (!order.empty()) json_["panels"].back()["groups"].push_back(std::move(group));
    return *this;
  }
  [[nodiscard]] Json json() const {
    for (const Json& panel : json_["panels"]) {
      if (!panel["groups"].empty()) return json_;
    }
    return nullptr;
  }

 private:
  Json json_;
};

Eigen::VectorXd sample_numbers(const Readings& readings) {
  return Eigen::VectorXd::LinSpaced(
      static_cast<Eigen::Index>(readings.trials().size()), 0.0,
      static_cast<double>(readings.trials().size()) - 1.0);
}

/// Time where it is known, else the number of the sample.
struct Course {
  Eigen::VectorXd x;
  std::string name, unit;
};
Course course_of(const DiagnosedReadings& data, const Known& known) {
  if (known.time_min.allFinite()) return {known.time_min, "time", "min"};
  return {sample_numbers(data.readings), "sample", ""};
}

Json joint_signature(
    const DiagnosedReadings& data, const Known& known, const ActiveEffect& effect,
    const Part& part) {
  const int joint = effect.place.joint;
  const Eigen::VectorXd column = angle_column(data, joint);
  const Eigen::VectorXd measured =
      by_trial(data.readings, column, data.after.weight, part.measured) * kDeg;
  const Eigen::VectorXd model =
      by_trial(data.readings, column, data.after.weight, part.model) * kDeg;
  const auto& trials = data.readings.trials();
  Eigen::VectorXd theta(measured.size());
  for (Eigen::Index t = 0; t < theta.size(); ++t) {
    theta[t] = trials[static_cast<std::size_t>(t)].q[joint] * kDeg;
  }
  const std::string name = fmt::format("angle error of joint {}", joint + 1);
  const std::string axis = fmt::format("theta{}", joint + 1);
  if (effect.effect->cause == "joint_backlash") {
    const auto arrives = [&](int sign) {
      return [&trials, joint, sign](Eigen::Index t) {
        return trials[static_cast<std::size_t>(t)].approach_of(
                   static_cast<std::size_t>(joint)) == sign;
      };
    };
    return Curve(name, "deg", axis, "deg")
        .of_the_covariate_alone()
        .panel("")
        .group("arrives turning up", theta, measured, model, arrives(1))
        .group("arrives turning down", theta, measured, model, arrives(-1))
        .json();
  }
  if (effect.effect->cause == "step") {
    const Course course = course_of(data, known);
    return Curve(name, "deg", course.name, course.unit)
        .of_the_covariate_alone()
        .panel("")
        .group("sample", course.x, measured, model)
        .json();
  }
  return Curve(name, "deg", axis, "deg")
      .of_the_covariate_alone()
      .panel("")
      .group("sample", theta, measured, model)
      .json();
}

Json tool_signature(
    const DiagnosedReadings& data, const Known& known, const ActiveEffect& effect,
    const Part& part) {
  const Eigen::Matrix2Xd measured =
      diagnosis::tool_shift(data.readings, data.after, part.measured, data.after.weight);
  const Eigen::Matrix2Xd model =
      diagnosis::tool_shift(data.readings, data.after, part.model, data.after.weight);
  const std::string_view cause = effect.effect->cause;
  const Eigen::Index n = measured.cols();
  std::array<Eigen::VectorXd, 2> at{known.x_mm, known.y_mm};
  std::string covariate;
  std::string unit;
  bool is_function = false;
  if (cause == "base_drift" || cause == "step") {
    const Course course = course_of(data, known);
    at = {course.x, course.x};
    covariate = course.name;
    unit = course.unit;
    is_function = true;
  } else if (cause == "link_thermal_growth") {
    at = {known.temperature_degC, known.temperature_degC};
    covariate = "temperature";
    unit = "degC";
  } else if (cause == "passive_clearance") {
    at = {known.travel_deg, known.travel_deg};
    covariate = "direction of the last move";
    unit = "deg";
    is_function = true;
  } else if (cause == "joint_compliance") {
    for (int axis = 0; axis < 2; ++axis) {
      auto& force = at[static_cast<std::size_t>(axis)];
      for (Eigen::Index t = 0; t < n; ++t) {
        force[t] = data.readings.circumstances()[static_cast<std::size_t>(t)].force_n[axis];
      }
    }
    covariate = "force of the plungers along the same axis";
    unit = "N";
  } else {
    std::swap(at[0], at[1]);
    covariate = "the other coordinate of the tool";
    unit = "mm";
    is_function = true;
  }
  Curve curve("shift of the tool", "mm", covariate, unit);
  if (is_function) curve.of_the_covariate_alone();
  curve.panel("in x").group("sample", at[0], measured.row(0), model.row(0));
  curve.panel("in y").group("sample", at[1], measured.row(1), model.row(1));
  return curve.json();
}

Json dial_signature(
    const DiagnosedReadings& data, const Known& known, const ActiveEffect& effect,
    const Part& part) {
  const Readings& readings = data.readings;
  const auto& rows = readings.rows();
  const auto trial_of = [&](Eigen::Index row) {
    return static_cast<Eigen::Index>(rows[static_cast<std::size_t>(row)].trial);
  };
  const auto spread = [&](const Eigen::VectorXd& by_sample) {
    Eigen::VectorXd result(readings.count());
    for (Eigen::Index row = 0; row < result.size(); ++row) {
      result[row] = by_sample[trial_of(row)];
    }
    return result;
  };
  const std::string_view cause = effect.effect->cause;
  const auto good = [&](Eigen::Index row, int dial) {
    return rows[static_cast<std::size_t>(row)].dial == dial && data.after.weight[row] > kGood;
  };
  Eigen::VectorXd x = spread(known.turn_deg);
  std::string covariate = "rotation of the face";
  std::string unit = "deg";
  bool is_function = false;
  if (cause == "step") {
    const Course course = course_of(data, known);
    x = spread(course.x);
    covariate = course.name;
    unit = course.unit;
    is_function = true;
  } else if (cause == "dial_lean") {
    x = x.cwiseProduct(readings.measured_mm()) / kDeg;
    covariate = "reading times rotation of the face";
    unit = "mm rad";
  } else if (effect.place.dial >= 0) {
    x = readings.measured_mm();
    covariate = "reading";
    unit = "mm";
    is_function = true;
  } else if (cause == "cuboid_size" || cause == "cuboid_offset") {
    is_function = cause == "cuboid_size";
  }
  const auto& dials = readings.model().rig().dials;
  Curve curve("residual", "mm", covariate, unit);
  if (is_function) curve.of_the_covariate_alone();
  for (int d = 0; d < static_cast<int>(dials.size()); ++d) {
    if (effect.place.dial >= 0 && d != effect.place.dial) continue;
    curve.panel("dial " + dials[static_cast<std::size_t>(d)].id);
    if (cause == "dial_hysteresis") {
      const auto goes = [&, d](double sign) {
        return [&, d, sign](Eigen::Index row) {
          const auto& sample =
              readings.circumstances()[static_cast<std::size_t>(trial_of(row))];
          return good(row, d) &&
                 sample.plunger_direction[static_cast<std::size_t>(d)] * sign > 0;
        };
      };
      curve.group("plunger going in", x, part.measured, part.model, goes(1.0))
          .group("plunger coming out", x, part.measured, part.model, goes(-1.0));
      continue;
    }
    curve.group("reading", x, part.measured, part.model, [&, d](Eigen::Index row) {
      return good(row, d);
    });
  }
  return curve.json();
}

/// Sums of squares of the good readings that fall in a class.
struct Class {
  double at = 0.0, before = 0.0, after = 0.0, smooth = 0.0;
  double weight_before = 0.0, weight_after = 0.0;
  int readings = 0;
  void add(const DiagnosedReadings& data, Eigen::Index row) {
    const double w0 = data.before.weight[row];
    const double w1 = data.after.weight[row];
    before += w0 * data.before.residual_mm[row] * data.before.residual_mm[row];
    after += w1 * data.left_mm[row] * data.left_mm[row];
    smooth += w1 * data.after.residual_mm[row] * data.after.residual_mm[row];
    weight_before += w0;
    weight_after += w1;
    ++readings;
  }
};

void put(Json& json, const Class& each, const std::string& label) {
  const auto rms = [](double squares, double weight) {
    return weight > 0.0 ? Json(std::sqrt(squares / weight)) : Json(nullptr);
  };
  json["at"].push_back(each.readings > 0 ? each.at / each.readings : 0.0);
  json["label"].push_back(label);
  json["readings"].push_back(each.readings);
  json["before_mm"].push_back(rms(each.before, each.weight_before));
  json["after_mm"].push_back(rms(each.after, each.weight_after));
  if (json.contains("smooth_mm")) {
    json["smooth_mm"].push_back(rms(each.smooth, each.weight_after));
  }
}

Json empty_covariate(
    const DiagnosedReadings& data, const char* name, const char* unit, const char* kind) {
  Json json{
      {"covariate", name},
      {"unit", unit},
      {"kind", kind},
      {"at", Json::array()},
      {"label", Json::array()},
      {"readings", Json::array()},
      {"before_mm", Json::array()},
      {"after_mm", Json::array()}};
  if (data.has_unknown) json["smooth_mm"] = Json::array();
  return json;
}

/// Ten classes of equally many readings; null where the covariate does not vary.
Json by_number(
    const DiagnosedReadings& data, const char* name, const char* unit,
    const Eigen::VectorXd& value) {
  constexpr std::size_t kClasses = 10;
  std::vector<Eigen::Index> order;
  for (Eigen::Index row = 0; row < value.size(); ++row) {
    if (std::isfinite(value[row])) order.push_back(row);
  }
  std::ranges::stable_sort(
      order, [&](Eigen::Index a, Eigen::Index b) { return value[a] < value[b]; });
  if (order.size() < kClasses || !(value[order.back()] > value[order.front()])) return nullptr;
  Json json = empty_covariate(data, name, unit, "number");
  for (std::size_t k = 0; k < kClasses; ++k) {
    const std::size_t begin = k * order.size() / kClasses;
    const std::size_t end = (k + 1) * order.size() / kClasses;
    Class each;
    for (std::size_t i = begin; i < end; ++i) {
      each.add(data, order[i]);
      each.at += value[order[i]];
    }
    put(json, each,
        fmt::format("{:.3g} to {:.3g}", value[order[begin]], value[order[end - 1]]));
  }
  return json;
}

}  // namespace

Json signature_of(const DiagnosedReadings& data, std::size_t i) {
  const ActiveEffect& effect = data.after.effects.at(i);
  const Known known = known_of(data);
  const Part part = part_of(data, i);
  if (effect.place.joint >= 0) return joint_signature(data, known, effect, part);
  const bool at_the_tool = effect.effect->after_kinematics || effect.effect->before_kinematics;
  const bool of_the_tool =
      effect.effect->cause == "step" ? effect.place.name == "base" : at_the_tool;
  if (of_the_tool) return tool_signature(data, known, effect, part);
  return data.readings.has_dials() ? dial_signature(data, known, effect, part) : Json(nullptr);
}

Json signature_of_swap(const DiagnosedReadings& data, const diagnosis::Hypothesis& swap) {
  const Readings& readings = data.readings;
  const std::array pair{swap.place.dial, swap.place.other_dial};
  const auto& dials = readings.model().rig().dials;
  Curve curve("reading", "mm", "what the simulation says", "mm");
  for (std::size_t k = 0; k < 2; ++k) {
    const int own = pair[k];
    const int other = pair[1 - k];
    std::vector<double> x;
    std::vector<double> as_it_came;
    std::vector<double> set_right;
    for (std::size_t t = 0; t < readings.trials().size(); ++t) {
      // The readings are set right already: what came under this name is under the other.
      const auto& came = readings.trials()[t].reading[static_cast<std::size_t>(other)];
      for (Eigen::Index row = readings.first_row(t); row < readings.first_row(t + 1); ++row) {
        if (readings.rows()[static_cast<std::size_t>(row)].dial != own) continue;
        const double measured = readings.measured_mm()[row];
        x.push_back(measured - data.after.residual_mm[row]);
        as_it_came.push_back(came.value_or(kNan));
        set_right.push_back(measured);
      }
    }
    const auto vector = [](const std::vector<double>& v) {
      return Eigen::VectorXd(
          Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
    };
    curve.panel("dial " + dials[static_cast<std::size_t>(own)].id)
        .group("reading", vector(x), vector(as_it_came), vector(set_right));
  }
  return curve.json();
}

Json left_by_covariate(const DiagnosedReadings& data) {
  const Readings& readings = data.readings;
  const Known known = known_of(data);
  const auto trial_of = [&](Eigen::Index row) {
    return static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].trial);
  };
  const auto spread = [&](const std::function<double(std::size_t)>& of) {
    Eigen::VectorXd result(readings.count());
    for (Eigen::Index row = 0; row < result.size(); ++row) result[row] = of(trial_of(row));
    return result;
  };
  const auto column = [&](const Eigen::VectorXd& by_sample) {
    return spread([&](std::size_t t) { return by_sample[static_cast<Eigen::Index>(t)]; });
  };
  Json all = Json::array();
  const auto add = [&](Json json) {
    if (json.is_object()) all.push_back(std::move(json));
  };
  for (const Eigen::Index joint : {0, 1}) {
    add(by_number(data, joint == 0 ? "theta1" : "theta2", "deg", spread([&](std::size_t t) {
                    return readings.trials()[t].q[joint] * kDeg;
                  })));
  }
  add(by_number(data, "x", "mm", column(known.x_mm)));
  add(by_number(data, "y", "mm", column(known.y_mm)));
  add(by_number(data, "time", "min", column(known.time_min)));
  add(by_number(data, "temperature", "degC", column(known.temperature_degC)));
  if (readings.has_dials()) {
    add(by_number(data, "reading of the dial", "mm", readings.measured_mm()));
  }
  const auto by_class = [&](const char* name,
                            const std::function<std::string(Eigen::Index)>& label_of) {
    std::map<std::string, Class> classes;
    for (Eigen::Index row = 0; row < readings.count(); ++row) {
      const std::string label = label_of(row);
      if (!label.empty()) classes[label].add(data, row);
    }
    if (classes.empty()) return;
    Json json = empty_covariate(data, name, "", "class");
    double at = 0.0;
    for (auto& [label, each] : classes) {
      each.at = at * each.readings;
      at += 1.0;
      put(json, each, label);
    }
    add(std::move(json));
  };
  by_class("arrival of the joints", [&](Eigen::Index row) -> std::string {
    const simulation::Trial& trial = readings.trials()[trial_of(row)];
    const std::array approach{trial.approach_of(0), trial.approach_of(1)};
    if (approach[0] == 0 && approach[1] == 0) return "";
    const auto word = [](int sign) { return sign > 0 ? "up" : sign < 0 ? "down" : "unknown"; };
    return fmt::format("joint 1 {}, joint 2 {}", word(approach[0]), word(approach[1]));
  });
  if (!readings.has_dials()) return all;
  by_class("travel of the plunger", [&](Eigen::Index row) -> std::string {
    const auto dial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].dial);
    const double way = readings.circumstances()[trial_of(row)].plunger_direction[dial];
    return way > 0 ? "going in" : way < 0 ? "coming out" : "";
  });
  by_class("dial", [&](Eigen::Index row) {
    const auto dial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].dial);
    return readings.model().rig().dials[dial].id;
  });
  return all;
}

Json tool_shifts(const DiagnosedReadings& data) {
  const Known known = known_of(data);
  // One model for both: the difference is in the residuals.
  const Eigen::Matrix2Xd before = diagnosis::tool_shift(
      data.readings, data.after, data.before.residual_mm, data.before.weight);
  const Eigen::Matrix2Xd after =
      diagnosis::tool_shift(data.readings, data.after, data.left_mm, data.after.weight);
  Json json{
      {"sample", Json::array()},
      {"x_mm", Json::array()},
      {"y_mm", Json::array()},
      {"before_mm", Json::array()},
      {"after_mm", Json::array()}};
  for (Eigen::Index t = 0; t < before.cols(); ++t) {
    if (!std::isfinite(known.x_mm[t]) || !before.col(t).allFinite() ||
        !after.col(t).allFinite()) {
      continue;
    }
    json["sample"].push_back(data.readings.trials()[static_cast<std::size_t>(t)].sample);
    json["x_mm"].push_back(known.x_mm[t]);
    json["y_mm"].push_back(known.y_mm[t]);
    json["before_mm"].push_back({before(0, t), before(1, t)});
    json["after_mm"].push_back({after(0, t), after(1, t)});
  }
  return json;
}

}  // namespace sixdial::studies
