// Which numbers of an arm are its parameters: those that say the same twice are left out, each
// with the names of those that say it.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "geometry/robots/parameter_row.h"
#include "geometry/robots/serial_chain.h"

namespace sixdial::geometry::serial_chain {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNearlyParallel = 0.1;  // sine: there d cannot be told, and beta is needed
constexpr int kPoses = 60;
constexpr double kSame = 1e-7;      // of its own effect is left when the others have said it
constexpr double kNamedPart = 0.1;  // of the largest part; smaller ones are not named
constexpr std::size_t kMostNames = 3;
constexpr double kShortest_mm = 20.0;

/// The first of these is kept before the last one.
enum class Rank { kBase, kTool, kZero, kLength, kTurn, kNotTold };

struct Candidate {
  std::size_t block = 0, slot = 0;
  Rank rank = Rank::kLength;
  ParameterInfo info;
};

/// Half of what the arm reaches: a turn of one over this moves the tool about a millimetre.
double lever_mm(const SerialRobot& arm) {
  double reach_mm = arm.tool_mm.norm();
  for (std::size_t i = 0; i < arm.rows.size(); ++i) {
    const SerialRow& row = arm.rows[i];
    const bool dh = row.form != RowForm::kOrigin;
    // The first origin is where the arm stands.
    reach_mm += dh ? std::hypot(row.a_mm, row.d_mm) : i == 0 ? 0.0 : row.origin_mm.norm();
    if (row.kind == JointKind::kPrismatic) reach_mm += row.high.value_or(100.0);
  }
  return std::max(reach_mm / 2.0, kShortest_mm);
}

void add_frame(
    std::vector<Candidate>& all, std::size_t block, const std::string& what, bool turns,
    double lever, const std::string& words) {
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  const Rank rank = block == 0 ? Rank::kBase : Rank::kTool;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = what + '_' + kAxes[i];
    all.push_back(
        {block, kX + i, rank,
         parameter_row(name, false, lever, words + ", along " + kAxes[i], name + "_mm")});
  }
  for (std::size_t i = 0; i < 3 && turns; ++i) {
    const std::string name = what + "_r" + kAxes[i];
    all.push_back(
        {block, kRx + i, rank,
         parameter_row(
             name, true, lever, words + ", turned about " + kAxes[i], name + "_deg")});
  }
}

/// Whether the axes that alpha leads from and to are nearly parallel, and both are joints.
bool nearly_parallel(const SerialRobot& arm, std::size_t i) {
  const bool inner = arm.rows[i].form == RowForm::kDh ? i + 1 < arm.rows.size() : i > 0;
  return inner && std::abs(std::sin(arm.rows[i].alpha_rad)) < kNearlyParallel;
}

void add_dh(std::vector<Candidate>& all, const SerialRobot& arm, std::size_t i, double lever) {
  const SerialRow& row = arm.rows[i];
  const std::string number = std::to_string(i + 1);
  const bool slides = row.kind == JointKind::kPrismatic;
  const bool parallel = nearly_parallel(arm, i);
  const auto add = [&](std::size_t slot, Rank rank, const char* name, bool angle,
                       const std::string& words) {
    all.push_back({i + 1, slot, rank, parameter_row(name + number, angle, lever, words)});
  };
  const std::string of = " of row " + number + " (" + row.name + ")";
  add(kTheta, slides ? Rank::kTurn : Rank::kZero, "theta", true,
      slides ? "angle about the axis" + of : "zero of the encoder" + of);
  add(kD, slides ? Rank::kZero : (parallel ? Rank::kNotTold : Rank::kLength), "d", false,
      slides ? "zero of the encoder" + of : "length along the axis" + of);
  add(kA, Rank::kLength, "a", false, "length across the axes" + of);
  add(kAlpha, Rank::kTurn, "alpha", true, "angle between the axes" + of);
  if (parallel || row.beta_rad != 0.0) {
    add(kBeta, Rank::kTurn, "beta", true, "second angle between nearly parallel axes" + of);
  }
}

void add_origin(std::vector<Candidate>& all, const Link& link, std::size_t i, double lever) {
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  const std::string front = "j" + std::to_string(i + 1) + '_';
  const std::string of = "origin of " + link.row.name;
  const bool slides = link.row.kind == JointKind::kPrismatic;
  // The coordinate that lies most along the joint's axis holds its zero.
  Index along = 0;
  (slides ? Vector3d(link.turn * link.row.axis) : link.row.axis).cwiseAbs().maxCoeff(&along);
  for (std::size_t k = 0; k < 3; ++k) {
    const bool zero = slides && static_cast<Index>(k) == along;
    all.push_back(
        {i + 1, kX + k, zero ? Rank::kZero : Rank::kLength,
         parameter_row(front + kAxes[k], false, lever, of + ", along " + kAxes[k])});
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const bool zero = !slides && static_cast<Index>(k) == along;
    all.push_back(
        {i + 1, kRx + k, zero ? Rank::kZero : Rank::kTurn,
         parameter_row(
             front + 'r' + kAxes[k], true, lever,
             zero ? "zero of the encoder of " + link.row.name
                  : of + ", turned about its " + kAxes[k])});
  }
}

std::vector<Candidate> candidates(const Details& is) {
  const SerialRobot& arm = is.robot;
  const double lever = lever_mm(arm);
  std::vector<Candidate> all;
  add_frame(all, 0, "base", true, lever, "where the arm stands");
  for (std::size_t i = 0; i < arm.rows.size(); ++i) {
    if (arm.rows[i].form == RowForm::kOrigin) {
      add_origin(all, is.links[i], i, lever);
    } else {
      add_dh(all, arm, i, lever);
    }
  }
  add_frame(
      all, is.blocks.size() - 1, "tool", arm.tool_is_frame, lever, "tool on the last link");
  return all;
}

/// Makes these the parameters of the model, in this order.
void use(const std::vector<Candidate>& chosen, RobotModel& robot, Details& is) {
  robot.parameters.clear();
  robot.nominal.resize(std::ssize(chosen));
  for (Block& block : is.blocks) block.parameter.fill(-1);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Candidate& each = chosen[k];
    Block& block = is.blocks[each.block];
    block.parameter[each.slot] = static_cast<int>(k);
    robot.nominal[static_cast<Index>(k)] = block.constant[each.slot];
    robot.parameters.push_back(each.info);
    robot.parameters.back().stands = each.block == 0;
    robot.parameters.back().grows =
        each.info.unit == "mm" && (each.rank == Rank::kLength || each.rank == Rank::kNotTold);
  }
}

/// The nominal robot with its tool out of all symmetry: a tool that a rig file puts on the last
/// axis, or leaves at zero, may well be elsewhere.
VectorXd with_any_tool(const RobotModel& robot, const Details& is, double lever) {
  VectorXd v = robot.nominal;
  constexpr std::array<double, 3> kSomewhere{0.31, -0.23, 0.41};
  for (std::size_t i = 0; i < 3; ++i) {
    const int at = is.blocks.back().parameter[kX + i];
    if (at >= 0) v[at] += kSomewhere[i] * lever;
  }
  return v;
}

/// How the tool moves by each parameter, scaled, over poses drawn within the joints' ranges.
MatrixXd effects(const RobotModel& robot, const Details& is) {
  const bool turns = is.robot.tool_is_frame;
  const double lever = lever_mm(is.robot);
  const Index rows = turns ? 6 : 3;
  MatrixXd A(rows * kPoses, robot.parameter_count());
  RobotModel with = robot;
  with.details = std::shared_ptr<const void>(&is, [](const void*) {});
  const VectorXd v = with_any_tool(with, is, lever);
  Frames at(with);
  VectorXd q(with.joint_count());
  std::uint64_t state = 1;
  for (Index pose = 0; pose < kPoses; ++pose) {
    for (Index k = 0; k < q.size(); ++k) {
      state = state * 6364136223846793005U + 1442695040888963407U;  // Knuth's generator
      const double part = static_cast<double>(state >> 11U) * 0x1p-53;
      const JointInfo& joint = with.joints[static_cast<std::size_t>(k)];
      q[k] = joint.low + part * (joint.high - joint.low);
    }
    static_cast<void>(with.forward_derivative(v, q, Assembly::kLeft, at));
    Twists J = at.by_v[0];
    J.bottomRows<3>() *= lever;
    for (Index k = 0; k < J.cols(); ++k) {
      J.col(k) *= with.parameters[static_cast<std::size_t>(k)].change;
    }
    A.middleRows(rows * pose, rows) = J.topRows(rows);
  }
  return A;
}

/// "base_z", "base_x and base_y", or "what the tool cannot show".
std::string said_by(const VectorXd& parts, const std::vector<std::string>& names) {
  if (parts.size() == 0 || parts.cwiseAbs().maxCoeff() < kSame) return "";
  std::vector<Index> order;
  const double least = kNamedPart * parts.cwiseAbs().maxCoeff();
  for (Index i = 0; i < parts.size(); ++i) {
    if (std::abs(parts[i]) >= least) order.push_back(i);
  }
  std::ranges::sort(
      order, [&](Index a, Index b) { return std::abs(parts[a]) > std::abs(parts[b]); });
  if (order.size() > kMostNames) order.resize(kMostNames);
  std::string text;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0) text += i + 1 == order.size() ? " and " : ", ";
    text += names[static_cast<std::size_t>(order[i])];
  }
  return text;
}

/// Goes through the candidates in the order of their ranks and keeps those that move the tool
/// in a way that the kept ones cannot.
std::vector<char> kept_of(
    const std::vector<Candidate>& all, const MatrixXd& A, std::vector<SaidTwice>& said) {
  std::vector<std::size_t> order(all.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return all[i].rank; });
  std::vector<char> kept(all.size(), 0);
  MatrixXd Q(A.rows(), 0);  // orthonormal, of the kept columns
  MatrixXd columns(A.rows(), 0);
  std::vector<std::string> names;
  std::map<std::size_t, std::string> left_out;
  for (const std::size_t i : order) {
    const VectorXd a = A.col(static_cast<Index>(i));
    VectorXd rest = a;
    for (int twice = 0; twice < 2; ++twice) rest -= Q * (Q.transpose() * rest);
    if (rest.norm() > kSame * std::max(a.norm(), std::sqrt(static_cast<double>(kPoses)))) {
      kept[i] = 1;
      Q.conservativeResize(Eigen::NoChange, Q.cols() + 1);
      Q.rightCols<1>() = rest.normalized();
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols<1>() = a;
      names.push_back(all[i].info.name);
      continue;
    }
    left_out[i] = said_by(columns.colPivHouseholderQr().solve(a), names);
  }
  for (auto& [i, by] : left_out) said.push_back({all[i].info.name, std::move(by)});
  return kept;
}

}  // namespace

void choose_parameters(RobotModel& robot, Details& details) {
  std::vector<Candidate> all = candidates(details);
  use(all, robot, details);
  if (details.robot.all_parameters) return;
  const std::vector<char> kept = kept_of(all, effects(robot, details), robot.said_twice);
  std::vector<Candidate> chosen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kept[i] != 0) chosen.push_back(std::move(all[i]));
  }
  use(chosen, robot, details);
}

}  // namespace sixdial::geometry::serial_chain
