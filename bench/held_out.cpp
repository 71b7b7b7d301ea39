// How well a calibrated robot meets poses that it was not fitted to, on a bundle of anybody's:
//
//   held_out BUNDLE|FILE... [--map map.toml] --scheme groups [--seeds 10]   random halves of
//   the poses, both ways
//                   --scheme alternate             rows in turn, both ways
//                   --scheme one                   each row left out in turn
//                   --scheme places                each place (sockets of one name) in turn
//                   --scheme fit                   nothing left out
//   --free radius,angle_b ... : only these are fitted
//   --curves 60: and a curve of each joint's own angle, of up to so many waves
//
// Prints one line of JSON: mean, rms and largest error [mm], of the nominal robot registered
// too.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "calibration/joint_curves.h"
#include "calibration/reading_space.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/base_and_tool.h"
#include "geometry/base_frame.h"
#include "geometry/tool.h"
#include "session/bundle.h"
#include "session/import.h"
#include "session/trials.h"

namespace sixdial::bench {
namespace {

using calibration::ObservationSpace;
using Eigen::VectorXd;
using simulation::Trial;

struct Options {
  std::vector<std::string> files;  // a bundle, or files that `map` reads
  std::string map, scheme = "alternate";
  int seeds = 1;
  int waves = 0;  // of joint curves; 0: none
  std::vector<std::string> free;
};

struct Errors {
  double sum_mm = 0.0, sum_mm2 = 0.0, largest_mm = 0.0;
  int count = 0;
  void add(double error_mm) {
    sum_mm += error_mm;
    sum_mm2 += error_mm * error_mm;
    largest_mm = std::max(largest_mm, error_mm);
    ++count;
  }
  [[nodiscard]] std::string text() const {
    const double n = std::max(count, 1);
    return fmt::format(
        "{{\"mean_mm\": {:.5f}, \"rms_mm\": {:.5f}, \"largest_mm\": {:.4f}, \"rows\": {}}}",
        sum_mm / n, std::sqrt(sum_mm2 / n), largest_mm, count);
  }
};

session::Session read(const Options& options) {
  if (options.files.empty()) throw std::invalid_argument("which bundle?");
  if (options.map.empty()) return session::read_bundle(options.files.front());
  const auto map = session::read_import_map(options.map);
  const auto imported = session::import_files(options.files, map);
  for (const std::string& note : imported.notes) std::cerr << note << '\n';
  return session::parse_session(
      imported.session_csv, "session.csv", imported.rig_toml, "rig.toml");
}

class Study {
 public:
  explicit Study(const Options& options) : options_(options), session_(read(options)) {
    trials_ = session::trials_of(session_, "");
    kind_ = session_.rig.instrument.kind;
    by_position_ = kind_ == "position" || kind_ == "pose";
    if (by_position_) register_nominal();
  }

  void run() {
    std::vector<std::vector<std::vector<std::size_t>>> tests;  // a list of held-out parts each
    if (options_.scheme == "fit") tests.push_back({{}});
    if (options_.scheme == "alternate") tests.push_back(alternate());
    if (options_.scheme == "one") tests.push_back(one_by_one());
    if (options_.scheme == "places") tests.push_back(places());
    if (options_.scheme == "groups") {
      for (int seed = 0; seed < options_.seeds; ++seed) tests.push_back(halves(seed));
    }
    Errors fitted, nominal;
    std::map<std::string, Errors> by_place;
    for (const auto& parts : tests) {
      for (const auto& held_out : parts) score(held_out, fitted, nominal, by_place);
    }
    fmt::print(
        "{{\"scheme\": \"{}\", \"fitted\": {}, \"nominal\": {}", options_.scheme, fitted.text(),
        nominal.text());
    const std::string* worst = nullptr;
    double worst_mm = 0.0;
    for (const auto& [place, errors] : by_place) {
      const double mean = errors.sum_mm / std::max(errors.count, 1);
      if (worst == nullptr || mean > worst_mm) {
        worst = &place;
        worst_mm = mean;
      }
    }
    if (worst != nullptr) {
      fmt::print(", \"worst_place\": \"{}\", \"worst_place_mm\": {:.4f}", *worst, worst_mm);
    }
    fmt::print(", \"held\": {}, \"parameters\": {}}}\n", held_, parameters_);
  }

 private:
  using Rows = std::vector<std::size_t>;

  /// Base and tool from all rows, before anything is fitted: a start, no more.
  void register_nominal() {
    geometry::Rig& rig = session_.rig;
    const geometry::RobotModel& robot = *rig.robot.model;
    std::vector<geometry::Pose<double>> poses;
    Eigen::MatrixXd measured(3, std::ssize(trials_));
    std::vector<geometry::JointPose> joints;
    for (const Trial& trial : trials_) {
      std::vector<geometry::Pose<double>> X(robot.frames.size());
      if (!trial.position_mm || trial.position_mm->size() != 3 ||
          !robot.forward(rig.robot.nominal, trial.q, trial.assembly, X)) {
        continue;
      }
      measured.col(std::ssize(poses)) = *trial.position_mm;
      poses.push_back(X[0]);
      if (poses.size() % 20 == 1) joints.push_back({trial.q, trial.assembly});
    }
    measured.conservativeResize(Eigen::NoChange, std::ssize(poses));
    const auto found = geometry::register_base_and_tool(poses, measured);
    if (!found) return;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = robot.find_parameter(std::string("tool_").append(1, "xyz"[axis]));
      if (at) rig.robot.nominal[*at] += found->tool_mm[axis];
    }
    const auto moved =
        geometry::with_base_moved(geometry::Tool(rig), rig.robot.nominal, found->base, joints);
    if (moved) rig.robot.nominal = *moved;
  }

  [[nodiscard]] std::vector<Rows> alternate() const {
    std::vector<Rows> parts(2);
    for (std::size_t i = 0; i < trials_.size(); ++i) parts[i % 2].push_back(i);
    return parts;
  }
  [[nodiscard]] std::vector<Rows> one_by_one() const {
    std::vector<Rows> parts;
    for (std::size_t i = 0; i < trials_.size(); ++i) parts.push_back({i});
    return parts;
  }
  /// Poses drawn whole into two halves.
  [[nodiscard]] std::vector<Rows> halves(int seed) const {
    std::map<int, std::vector<std::size_t>> of_point;
    for (std::size_t i = 0; i < trials_.size(); ++i) of_point[trials_[i].point].push_back(i);
    std::vector<int> points;
    for (const auto& [point, rows] : of_point) points.push_back(point);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::ranges::shuffle(points, random);
    std::vector<Rows> parts(2);
    for (std::size_t k = 0; k < points.size(); ++k) {
      for (const std::size_t i : of_point[points[k]]) parts[k % 2].push_back(i);
    }
    return parts;
  }
  /// Sockets of one block, whose names differ in their last number only.
  [[nodiscard]] std::string place_of(const Trial& trial) const {
    for (std::size_t k = 0; k < session_.rig.instrument.sockets.size(); ++k) {
      if (3 * k >= trial.reading.size() || !trial.reading[3 * k]) continue;
      const std::string& name = session_.rig.instrument.sockets[k].name;
      return name.substr(0, name.find_last_not_of("0123456789") + 1);
    }
    return "";
  }
  [[nodiscard]] std::vector<Rows> places() const {
    std::map<std::string, Rows> by_name;
    for (std::size_t i = 0; i < trials_.size(); ++i) {
      by_name[place_of(trials_[i])].push_back(i);
    }
    std::vector<Rows> parts;
    for (auto& [name, rows] : by_name) parts.push_back(std::move(rows));
    return parts;
  }

  [[nodiscard]] ObservationSpace space_of(
      const std::vector<Trial>& trials, const geometry::Rig& rig) const {
    return by_position_ ? calibration::position_space(trials, rig)
                        : calibration::reading_space(trials, rig);
  }

  /// Only sockets that are used: the others would be parameters that nothing tells.
  [[nodiscard]] geometry::Rig rig_for(std::vector<Trial>& trials) const {
    geometry::Rig rig = session_.rig;
    if (kind_ != "socket") return rig;
    std::vector<std::size_t> used;
    for (std::size_t k = 0; k < rig.instrument.sockets.size(); ++k) {
      const bool any = std::ranges::any_of(
          trials, [&](const Trial& trial) { return trial.reading[3 * k].has_value(); });
      if (any) used.push_back(k);
    }
    std::vector<geometry::ReferencePoint> sockets;
    for (const std::size_t k : used) sockets.push_back(rig.instrument.sockets[k]);
    for (Trial& trial : trials) {
      std::vector<std::optional<double>> reading;
      for (const std::size_t k : used) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          reading.push_back(trial.reading[3 * k + axis]);
        }
      }
      trial.reading = std::move(reading);
    }
    rig.instrument.sockets = std::move(sockets);
    std::erase_if(rig.instrument.socket_distances, [&](const auto& known) {
      const auto has = [&](const std::string& name) {
        return std::ranges::find(
                   rig.instrument.sockets, name, &geometry::ReferencePoint::name) !=
               rig.instrument.sockets.end();
      };
      return !has(known.first) || !has(known.second);
    });
    return rig;
  }

  /// The robot's parameters, fitted to all rows but these.
  VectorXd fit(const Rows& held_out) {
    std::vector<char> is_out(trials_.size(), 0);
    for (const std::size_t i : held_out) is_out[i] = 1;
    std::vector<Trial> train;
    for (std::size_t i = 0; i < trials_.size(); ++i) {
      if (is_out[i] == 0) train.push_back(trials_[i]);
    }
    const geometry::Rig rig = rig_for(train);
    const ObservationSpace space = space_of(train, rig);
    calibration::SpaceFitSettings settings;
    settings.noise_mm = 0.03;
    if (by_position_) {
      settings.loss = calibration::Loss::kCauchy;
    } else {
      settings.weighting = calibration::Weighting::kBySigma;
    }
    if (!options_.free.empty()) {
      for (const auto& info : space.parameter_info) {
        const bool free = std::ranges::find(options_.free, info.name) != options_.free.end();
        settings.fixed.push_back(free ? 0 : 1);
      }
    }
    const calibration::SpaceFit found = fit_space(space, settings);
    held_ = found.fit.held;
    parameters_ = space.parameters();
    curves_.reset();
    if (options_.waves > 0 && by_position_) {
      const auto curved =
          calibration::fit_joint_curves(train, rig, found.v, {.waves = options_.waves});
      if (curved) {
        curves_ = curved->curves;
        for (Eigen::Index j = 0; j < curved->prior_rad.size(); ++j) {
          std::cerr << fmt::format(
              "joint {}: {:.4f} mrad, {:.0f} numbers told\n", j + 1,
              1e3 * curved->curves.size_rad(j), curved->told[j]);
        }
        std::cerr << fmt::format(
            "noise {:.4f} mm, smoothness {}\n", curved->sigma_mm, curved->smoothness);
        return curved->v;
      }
    }
    return found.v.head(rig.robot.nominal.size());
  }

  void score(
      const Rows& held_out, Errors& fitted, Errors& nominal,
      std::map<std::string, Errors>& by_place) {
    const VectorXd v = fit(held_out);
    Rows rows = held_out;
    if (rows.empty()) {
      for (std::size_t i = 0; i < trials_.size(); ++i) rows.push_back(i);
    }
    if (kind_ == "socket") {
      for (const auto& [i, error_mm] : spread(rows, v)) {
        fitted.add(error_mm);
        by_place[place_of(trials_[i])].add(error_mm);
      }
      for (const auto& [i, error_mm] : spread(rows, session_.rig.robot.nominal)) {
        nominal.add(error_mm);
      }
      return;
    }
    for (const std::size_t i : rows) {
      std::vector<Trial> one{trials_[i]};
      const ObservationSpace space = space_of(one, session_.rig);
      if (space.samples() == 0) continue;
      VectorXd e(space.rows(0));
      VectorXd x = space.nominal;
      if (space.evaluate(0, x, e, nullptr)) nominal.add(e.norm());
      x.head(v.size()) = v;
      if (curves_) one[0].q += curves_->at(one[0].q);
      const ObservationSpace bent = curves_ ? space_of(one, session_.rig) : space;
      if (bent.evaluate(0, x, e, nullptr)) fitted.add(e.norm());
    }
  }

  /// Distance of each row's tool from the mean of its socket.
  [[nodiscard]] std::vector<std::pair<std::size_t, double>> spread(
      const Rows& rows, const VectorXd& v) const {
    const geometry::Tool tool(session_.rig.robot.model, 3);
    std::map<std::size_t, std::vector<std::pair<std::size_t, Eigen::Vector3d>>> of_socket;
    for (const std::size_t i : rows) {
      const auto at = tool.position(v, trials_[i].q, trials_[i].assembly);
      if (!at) continue;
      for (std::size_t k = 0; 3 * k < trials_[i].reading.size(); ++k) {
        if (trials_[i].reading[3 * k]) of_socket[k].emplace_back(i, *at);
      }
    }
    std::vector<std::pair<std::size_t, double>> result;
    for (const auto& [socket, points] : of_socket) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const auto& [i, p] : points) mean += p / static_cast<double>(points.size());
      for (const auto& [i, p] : points) result.emplace_back(i, (p - mean).norm());
    }
    return result;
  }

  Options options_;
  session::Session session_;
  std::vector<Trial> trials_;
  std::string kind_;
  bool by_position_ = false;
  std::optional<calibration::JointCurves> curves_;
  int held_ = 0;
  int parameters_ = 0;
};

Options options_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--scheme" && more) {
      options.scheme = argv[++i];
    } else if (word == "--map" && more) {
      options.map = argv[++i];
    } else if (word == "--curves" && more) {
      options.waves = std::stoi(argv[++i]);
    } else if (word == "--seeds" && more) {
      options.seeds = std::stoi(argv[++i]);
    } else if (word == "--free" && more) {
      std::string name;
      for (const char letter : std::string(argv[++i]) + ',') {
        if (letter != ',') {
          name += letter;
        } else if (!name.empty()) {
          options.free.push_back(std::exchange(name, ""));
        }
      }
    } else {
      options.files.push_back(word);
    }
  }
  return options;
}

}  // namespace
}  // namespace sixdial::bench

int main(int argc, char** argv) {
  try {
    sixdial::bench::Study(sixdial::bench::options_of(argc, argv)).run();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "held_out: " << error.what() << '\n';
    return 1;
  }
}
