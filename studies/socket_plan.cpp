#include "studies/socket_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "calibration/identifiability.h"
#include "calibration/reading_space.h"
#include "calibration/registered_workspace.h"
#include "calibration/space_fit.h"
#include "calibration/uncertainty.h"
#include "geometry/long_work.h"
#include "geometry/tool.h"
#include "studies/own_frame.h"
#include "studies/socket_request.h"

namespace sixdial::studies {
namespace {

using calibration::DesignRows;
using calibration::ObservationSpace;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kFewestCandidates = 240;  // of each socket
constexpr int kWorkspacePoses = 200;
/// Before any pose a parameter is known to so many plausible changes: the poses decide.
constexpr double kNotKnown = 10.0;

/// A pose in the socket of this number.
struct SeatedPose {
  std::size_t socket = 0;
  session::PlanPose pose;
};

std::string place_words(const Vector3d& at_mm) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", at_mm.x(), at_mm.y(), at_mm.z());
}

/// What calibration would fit, were these poses measured on the nominal arm.
ObservationSpace space_at(const geometry::Rig& rig, const std::vector<SeatedPose>& poses) {
  std::vector<simulation::Trial> trials;
  for (const SeatedPose& each : poses) {
    simulation::Trial trial;
    trial.sample = trial.point = static_cast<int>(trials.size());
    trial.q = each.pose.q;
    trial.assembly = rig.robot.assembly;
    trial.reading.resize(3 * rig.instrument.sockets.size());
    for (std::size_t axis = 0; axis < 3; ++axis) trial.reading[3 * each.socket + axis] = 0.0;
    trials.push_back(std::move(trial));
  }
  return calibration::reading_space(trials, rig, rig.instrument.sd_mm);
}

/// What calibration would say of them.
calibration::LeastSquaresFit assessed(const ObservationSpace& space, const geometry::Rig& rig) {
  calibration::SpaceFitSettings settings;
  settings.weighting = calibration::Weighting::kBySigma;
  settings.noise_mm = rig.instrument.sd_mm;
  settings.fixed.assign(static_cast<std::size_t>(space.parameters()), 0);
  hold_where_it_stands(rig, settings.fixed);
  return calibration::assess_space(space, space.nominal, settings).fit;
}

std::vector<calibration::WorkspacePose> workspace_of(const geometry::Rig& rig) {
  session::Uniform random(1, "workspace");
  const auto drawn = session::drawn_in_space(
      rig, rig.robot.working_mode, std::nullopt, kWorkspacePoses, random);
  std::vector<calibration::WorkspacePose> poses;
  for (std::size_t i = 0; drawn && i < drawn->poses.size(); ++i) {
    const session::PlanPose& pose = drawn->poses[i];
    poses.push_back({pose.target_mm, pose.q, rig.robot.assembly, rig.robot.working_mode});
  }
  if (poses.empty()) {
    refuse_arm(
        "none of the poses that were drawn from the joints' ranges can be taken",
        "Look at low_deg and high_deg of [[joint]].");
  }
  return poses;
}

/// The choice of poses, and what they tell.
class Choice {
 public:
  Choice(const geometry::Rig& rig, const SocketPlanRequest& request)
      : rig_(rig),
        workspace_(geometry::Tool(rig.robot.model, 3), rig.robot.nominal, workspace_of(rig)) {
    draw(request);
    choose(request);
  }

  /// Poses of each socket, best first; the first `count` of them are the plan.
  [[nodiscard]] std::vector<SeatedPose> first(std::size_t count) const {
    std::vector<SeatedPose> poses;
    for (const Socket& socket : sockets_) {
      const std::size_t n = std::min(count, socket.chosen.size());
      for (std::size_t i = 0; i < n; ++i) {
        poses.push_back(socket.candidates[socket.chosen[i]]);
      }
    }
    return poses;
  }
  [[nodiscard]] const std::vector<SeatedPose>& to_judge() const { return to_judge_; }
  [[nodiscard]] std::size_t most() const { return most_; }  // poses chosen of each socket

  [[nodiscard]] SocketStage stage(std::size_t count) const {
    const ObservationSpace space = space_at(rig_, first(count));
    const calibration::LeastSquaresFit fit = assessed(space, rig_);
    SocketStage stage{.poses = static_cast<int>(count)};
    const MatrixXd held = calibration::held_covariance(fit, space.parameter_info);
    const auto known = uncertainty_of(covariance(space, fit) + held);
    stage.position = {.mean_mm = known.mean_mm, .max_mm = known.max_mm};
    if (fit.held == 0) return stage;
    stage.open_mm = uncertainty_of(held).mean_mm;
    for (const auto& each :
         calibration::identifiability(
             fit, space.parameter_names(), space.samples(), space.named_directions)
             .held) {
      stage.open.push_back(each.words);
    }
    return stage;
  }

  [[nodiscard]] std::vector<PlannedParameter> parameters(std::size_t count) const {
    const ObservationSpace space = space_at(rig_, first(count));
    const calibration::LeastSquaresFit fit = assessed(space, rig_);
    const MatrixXd held = calibration::held_covariance(fit, space.parameter_info);
    const auto estimates = calibration::parameter_estimates(
        fit, space.nominal, covariance(space, fit) + held, space.parameter_names());
    std::vector<PlannedParameter> result;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rig_.robot.nominal.size()); ++i) {
      if (estimates[i].fixed) continue;
      result.push_back(
          {.name = estimates[i].name,
           .unit = space.parameter_info[i].unit,
           .sd = estimates[i].sd,
           .open = estimates[i].partly_held});
    }
    return result;
  }

  /// Whether one known distance would leave fewer directions open.
  [[nodiscard]] bool scale_is_open(std::size_t count) const {
    const geometry::Instrument& is = rig_.instrument;
    const bool known = std::ranges::any_of(
        is.sockets, [](const auto& socket) { return socket.at_mm.has_value(); });
    if (!is.socket_distances.empty() || known) return false;
    geometry::Rig with_distance = rig_;
    with_distance.instrument.socket_distances.push_back(
        {is.sockets[0].name, is.sockets[1].name, (sockets_[0].at_mm - sockets_[1].at_mm).norm(),
         is.sd_mm});
    const std::vector<SeatedPose> poses = first(count);
    return assessed(space_at(with_distance, poses), with_distance).held <
           assessed(space_at(rig_, poses), rig_).held;
  }

 private:
  struct Socket {
    Vector3d at_mm{0, 0, 0};
    std::vector<SeatedPose> candidates;
    std::vector<DesignRows> rows;  // by candidate
    std::vector<std::size_t> chosen;
  };

  [[nodiscard]] static MatrixXd covariance(
      const ObservationSpace& space, const calibration::LeastSquaresFit& fit) {
    return space.mean_sigma() * space.mean_sigma() * fit.unit_covariance();
  }
  [[nodiscard]] calibration::WorkspaceUncertainty uncertainty_of(const MatrixXd& of_all) const {
    const Index n = rig_.robot.nominal.size();
    return workspace_.uncertainty(of_all.topLeftCorner(n, n));
  }

  /// Candidates of one socket, or poses to judge by.
  [[nodiscard]] std::vector<SeatedPose> drawn(
      std::size_t socket, int wanted, int least, const SocketPlanRequest& request,
      std::string_view purpose) const {
    const Vector3d& at_mm = request.at_mm[socket];
    const std::string& name = rig_.instrument.sockets[socket].name;
    session::Uniform random(request.seed, fmt::format("{} {}", purpose, name));
    const auto found = session::drawn_at_socket(rig_, at_mm, request.seat, wanted, random);
    const std::string where = fmt::format("socket {} at {}: ", name, place_words(at_mm));
    if (!found) refuse_arm(where + found.error().reason, found.error().advice);
    if (std::ssize(found->poses) < least) {
      refuse_arm(
          fmt::format(
              "{}only {} poses were found in {} draws, {} are needed", where,
              found->poses.size(), found->draws, least),
          "Ask for fewer, move the socket towards the middle of the arm's reach, or give a "
          "wider cone.");
    }
    std::vector<SeatedPose> poses;
    for (const session::PlanPose& pose : found->poses) poses.push_back({socket, pose});
    return poses;
  }

  void draw(const SocketPlanRequest& request) {
    const int wanted = std::max(kFewestCandidates, 6 * request.count);
    most_ = 2 * static_cast<std::size_t>(request.count);
    for (std::size_t k = 0; k < request.at_mm.size(); ++k) {
      Socket& socket = sockets_.emplace_back();
      socket.at_mm = request.at_mm[k];
      socket.candidates = drawn(k, wanted, request.count, request, "candidates of");
      most_ = std::min(most_, socket.candidates.size());
      if (request.to_judge == 0) continue;
      const auto more =
          drawn(k, request.to_judge, request.to_judge, request, "to judge by, in");
      to_judge_.insert(to_judge_.end(), more.begin(), more.end());
    }
  }

  /// One more pose of each socket in turn: that which tells most beyond those before it.
  void choose(const SocketPlanRequest& request) {
    std::vector<SeatedPose> all;
    for (const Socket& socket : sockets_) {
      all.insert(all.end(), socket.candidates.begin(), socket.candidates.end());
    }
    const ObservationSpace space = space_at(rig_, all);
    std::vector<Index> free;
    std::vector<char> fixed(static_cast<std::size_t>(space.parameters()), 0);
    hold_where_it_stands(rig_, fixed);
    for (std::size_t i = 0; i < fixed.size(); ++i) {
      if (fixed[i] == 0) free.push_back(static_cast<Index>(i));
    }
    const VectorXd scale = kNotKnown * space.scale()(free);
    const auto rows_of = [&](int sample) {
      VectorXd e(space.rows(sample));
      MatrixXd J = MatrixXd::Zero(space.rows(sample), space.parameters());
      if (!space.evaluate(sample, space.nominal, e, &J)) J.setZero();
      const VectorXd sigma = space.sigma_mm.segment(
          space.first_row[static_cast<std::size_t>(sample)], space.rows(sample));
      return DesignRows{
          J(Eigen::all, free) * scale.asDiagonal(), MatrixXd(sigma.cwiseAbs2().asDiagonal())};
    };
    int sample = 0;
    for (Socket& socket : sockets_) {
      for (std::size_t i = 0; i < socket.candidates.size(); ++i) {
        socket.rows.push_back(rows_of(sample++));
      }
    }
    const auto n = static_cast<Index>(free.size());
    MatrixXd JJ = MatrixXd::Zero(space.parameters(), space.parameters());
    const Index robot = rig_.robot.nominal.size();
    JJ.topLeftCorner(robot, robot) = workspace_.mean_sensitivity();
    const MatrixXd scaled = scale.asDiagonal() * JJ(free, free) * scale.asDiagonal();
    calibration::DesignKnowledge known(MatrixXd::Identity(n, n), scaled, request.criterion);
    while (sample < space.samples()) known.add(rows_of(sample++));  // known distances
    for (std::size_t round = 0; round < most_; ++round) {
      for (Socket& socket : sockets_) add_best(socket, known);
    }
  }

  static void add_best(Socket& socket, calibration::DesignKnowledge& known) {
    geometry::check_end();
    std::size_t best = socket.candidates.size();
    double most = 0.0;
    for (std::size_t i = 0; i < socket.candidates.size(); ++i) {
      if (std::ranges::find(socket.chosen, i) != socket.chosen.end()) continue;
      const double gain = known.gain(socket.rows[i]);
      if (best < socket.candidates.size() && !(gain > most)) continue;
      best = i;
      most = gain;
    }
    if (best == socket.candidates.size()) return;
    socket.chosen.push_back(best);
    known.add(socket.rows[best]);
  }

  const geometry::Rig& rig_;
  calibration::RegisteredWorkspace workspace_;
  std::vector<Socket> sockets_;
  std::vector<SeatedPose> to_judge_;
  std::size_t most_ = 0;
};

/// Socket by socket, each pose the nearest to the one before, from the middle of the joints'
/// ranges on; numbered within its set.
session::Plan in_order(
    const geometry::Rig& rig, const std::vector<SeatedPose>& to_fit,
    const std::vector<SeatedPose>& to_judge) {
  const auto& joints = rig.robot.model->joints;
  VectorXd at(std::ssize(joints));
  VectorXd range(std::ssize(joints));
  for (std::size_t k = 0; k < joints.size(); ++k) {
    at[static_cast<Index>(k)] = (joints[k].low + joints[k].high) / 2;
    range[static_cast<Index>(k)] = std::max(1e-9, joints[k].high - joints[k].low);
  }
  session::Plan plan;
  int fitted = 0;
  int judged = 0;
  for (std::size_t socket = 0; socket < rig.instrument.sockets.size(); ++socket) {
    std::vector<std::pair<const SeatedPose*, bool>> left;  // and whether it is of G1
    for (const SeatedPose& each : to_fit) {
      if (each.socket == socket) left.emplace_back(&each, true);
    }
    for (const SeatedPose& each : to_judge) {
      if (each.socket == socket) left.emplace_back(&each, false);
    }
    while (!left.empty()) {
      const auto nearest = std::ranges::min_element(left, {}, [&](const auto& each) {
        return (each.first->pose.q - at).cwiseQuotient(range).squaredNorm();
      });
      const auto [pose, of_g1] = *nearest;
      left.erase(nearest);
      at = pose->pose.q;
      session::PlanPoint& point = plan.points.emplace_back();
      point.set = of_g1 ? "G1" : "G2";
      point.point = of_g1 ? fitted++ : judged++;
      point.target_mm = pose->pose.target_mm;
      point.q = pose->pose.q;
      point.socket = rig.instrument.sockets[socket].name;
    }
  }
  return plan;
}

std::vector<PlannedSocket> sockets_of(
    const geometry::Rig& rig, const session::Plan& plan, const SocketPlanRequest& request) {
  std::vector<PlannedSocket> result;
  std::vector<geometry::Pose<double>> X(rig.robot.model->frames.size());
  for (std::size_t k = 0; k < request.at_mm.size(); ++k) {
    PlannedSocket socket{
        .name = rig.instrument.sockets[k].name,
        .at_mm = request.at_mm[k],
        .least_lean_rad = std::numbers::pi};
    for (const session::PlanPoint& point : plan.points) {
      if (point.socket != socket.name) continue;
      if (point.set == "G1") ++socket.poses;
      if (!rig.robot.model->forward(rig.robot.nominal, point.q, rig.robot.assembly, X)) {
        continue;
      }
      const double lean_rad = session::lean_of(request.seat, X[0].R);
      socket.least_lean_rad = std::min(socket.least_lean_rad, lean_rad);
      socket.most_lean_rad = std::max(socket.most_lean_rad, lean_rad);
    }
    result.push_back(std::move(socket));
  }
  return result;
}

std::vector<PlannedDistance> distances_of(
    const geometry::Rig& rig, const SocketPlanRequest& request) {
  std::vector<PlannedDistance> result;
  const auto place = [&](const std::string& name) {
    const auto at =
        std::ranges::find(rig.instrument.sockets, name, &geometry::ReferencePoint::name);
    return request.at_mm[static_cast<std::size_t>(at - rig.instrument.sockets.begin())];
  };
  for (const geometry::SocketDistance& each : rig.instrument.socket_distances) {
    result.push_back(
        {.first = each.first,
         .second = each.second,
         .mm = each.mm,
         .sd_mm = each.sd_mm,
         .places_mm = (place(each.first) - place(each.second)).norm()});
  }
  return result;
}

}  // namespace

SocketPlan socket_plan(const geometry::Rig& arm, const SocketPlanRequest& request) {
  SocketPlan made{.plan = {}, .rig = with_sockets(arm, request), .figures = {}};
  const Choice choice(made.rig, request);
  const auto count = static_cast<std::size_t>(request.count);
  made.plan = in_order(made.rig, choice.first(count), choice.to_judge());
  SocketPlanFigures& figures = made.figures;
  figures.points = static_cast<int>(made.plan.points.size());
  figures.sockets = sockets_of(made.rig, made.plan, request);
  figures.distances = distances_of(made.rig, request);
  figures.seat_sd_mm = made.rig.instrument.sd_mm;
  figures.seat_sd_assumed =
      !request.seat_sd_mm && !(arm.instrument.kind == "socket" && arm.instrument.sd_mm > 0.0);
  figures.cone_rad = request.seat.cone_rad;
  figures.criterion = request.criterion;
  figures.scale_is_open = choice.scale_is_open(count);
  for (const std::size_t length : {(count + 1) / 2, count, 2 * count}) {
    const bool again =
        !figures.stages.empty() && figures.stages.back().poses == static_cast<int>(length);
    if (length <= choice.most() && !again) figures.stages.push_back(choice.stage(length));
  }
  figures.parameters = choice.parameters(count);
  return made;
}

}  // namespace sixdial::studies
