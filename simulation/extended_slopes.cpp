#include "simulation/extended_slopes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/rotation.h"

namespace sixdial::simulation {
namespace {

// Steps of central differences: a third derivative of the order of the arm's length makes less
// than a millionth of a millionth, rounding of the readings about 1e-11.
constexpr double kStep_mm = 1e-3;
constexpr double kStep_rad = 1e-5;

double step_of(const ForwardModel& model, Eigen::Index parameter) {
  const auto& info = model.parameters()[static_cast<std::size_t>(parameter)];
  return info.unit == "mm" ? kStep_mm : kStep_rad;
}

/// (value at +step - value at -step) / 2 step. `value` writes into its argument.
template <typename Value>
void central(double& variable, double step, const Value& value, Eigen::VectorXd& into) {
  const double before = variable;
  static thread_local Eigen::VectorXd down;
  variable = before - step;
  value(down);
  variable = before + step;
  value(into);
  variable = before;
  into = (into - down) / (2 * step);
}

/// Whether what bends the joints does so by the robot's parameters: hardly any effect does, and
/// moving them all at once shows it.
template <typename Bent>
bool looks_at_parameters(const Bent& bent, Eigen::VectorXd& v) {
  static thread_local Eigen::VectorXd here, elsewhere;
  const Eigen::VectorXd before = v;
  bent(here);
  v.array() += kStep_mm;
  bent(elsewhere);
  const bool unmoved =
      here.tail(here.size() - v.size()) == elsewhere.tail(here.size() - v.size()) &&
      here.head(v.size()) == before && elsewhere.head(v.size()) == v;
  v = before;
  return !unmoved;
}

/// Channels that a trial has readings of; all, if it has none.
std::vector<Eigen::Index> channels_read(const Trial& trial, Eigen::Index channels) {
  std::vector<Eigen::Index> result;
  for (std::size_t i = 0; i < trial.reading.size(); ++i) {
    if (trial.reading[i]) result.push_back(static_cast<Eigen::Index>(i));
  }
  if (result.empty()) {
    for (Eigen::Index i = 0; i < channels; ++i) result.push_back(i);
  }
  return result;
}

}  // namespace

ExtendedSlopes::ExtendedSlopes(const ExtendedModel& extended, std::vector<EffectNumber> numbers)
    : extended_(extended), numbers_(std::move(numbers)) {
  for (const ActiveEffect& active : extended_.effects()) {
    bends_joints_ = bends_joints_ || static_cast<bool>(active.effect->before_kinematics);
  }
}

Eigen::Index ExtendedSlopes::count() const {
  return extended_.base().parameter_count() + static_cast<Eigen::Index>(numbers_.size());
}

ExtendedSlopes::Reached ExtendedSlopes::differentiate_torque(
    const ModelVector& model, const Trial& trial, const Circumstance& sample) {
  ModelVector moved = model;
  torque_by_model_.resize(trial.q.size(), model.size());
  for (Eigen::Index k = 0; k < model.size(); ++k) {
    const double step = step_of(extended_.base(), k);
    moved[k] = model[k] + step;
    const auto up = extended_.torque_Nmm(moved, trial, sample);
    moved[k] = model[k] - step;
    const auto down = extended_.torque_Nmm(moved, trial, sample);
    moved[k] = model[k];
    if (!up) return tl::unexpected(up.error());
    if (!down) return tl::unexpected(down.error());
    torque_by_model_.col(k) = (*up - *down) / (2 * step);
  }
  return {};
}

ExtendedSlopes::Reached ExtendedSlopes::differentiate_joints(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene) {
  const Eigen::Index of_robot = extended_.base().robot_parameter_count();
  const Eigen::Index joints = trial.q.size();
  v_.setZero(of_robot, count());
  q_.setZero(joints, count());
  v_.leftCols(of_robot).setIdentity();
  bends_parameters_ = false;
  const bool by_torque = extended_.needs_torque();
  if (by_torque) {
    auto torque = extended_.torque_Nmm(model, trial, sample);
    if (!torque) return tl::unexpected(torque.error());
    scene.torque_Nmm = std::move(*torque);
    if (const auto reached = differentiate_torque(model, trial, sample); !reached) {
      return reached;
    }
  }
  Eigen::VectorXd v = model.head(of_robot);
  scene.q = trial.q;
  scene.v = v;
  if (!bends_joints_) return {};
  Eigen::VectorXd torque_Nmm = scene.torque_Nmm;
  const auto bent = [&](Eigen::VectorXd& into) {
    moved_.q = trial.q;
    moved_.v = v;
    moved_.torque_Nmm = torque_Nmm;
    extended_.bend_joints(sample, moved_);
    into.resize(of_robot + joints);
    into << moved_.v, moved_.q;
  };
  Eigen::VectorXd slope;
  const bool by_parameters = looks_at_parameters(bent, v);
  for (Eigen::Index k = 0; by_parameters && k < of_robot; ++k) {
    central(v[k], step_of(extended_.base(), k), bent, slope);
    v_.col(k) = slope.head(of_robot);
    q_.col(k) = slope.tail(joints);
  }
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    ActiveEffect& active = extended_.effects()[numbers_[i].effect];
    if (!active.effect->before_kinematics) continue;
    const Eigen::Index column = model.size() + static_cast<Eigen::Index>(i);
    central(active.x[numbers_[i].parameter], numbers_[i].step, bent, slope);
    v_.col(column) = slope.head(of_robot);
    q_.col(column) = slope.tail(joints);
    bends_parameters_ = bends_parameters_ || !slope.head(of_robot).isZero(0.0);
  }
  bends_parameters_ = bends_parameters_ || by_parameters || by_torque;
  for (Eigen::Index joint = 0; by_torque && joint < joints; ++joint) {
    constexpr double kStep_Nmm = 0.1;
    central(torque_Nmm[joint], kStep_Nmm, bent, slope);
    v_.leftCols(model.size()) += slope.head(of_robot) * torque_by_model_.row(joint);
    q_.leftCols(model.size()) += slope.tail(joints) * torque_by_model_.row(joint);
  }
  extended_.bend_joints(sample, scene);
  return {};
}

ExtendedSlopes::Reached ExtendedSlopes::differentiate_pose(
    const ModelVector& model, const Trial& trial, Scene& scene) {
  const ForwardModel& base = extended_.base();
  if (frames_.X.empty()) {
    frames_ = geometry::Frames(base.robot());
    frames_.tool_only = base.instrument().kind->sees_tool_only;
  }
  if (auto reached = base.robot().forward_derivative(scene.v, scene.q, trial.assembly, frames_);
      !reached) {
    return reached;
  }
  p_.noalias() = frames_.by_q[0].topRows<3>() * q_;
  if (bends_parameters_) {
    p_.noalias() += frames_.by_v[0].topRows<3>() * v_;
  } else {
    p_.leftCols(v_.rows()) += frames_.by_v[0].topRows<3>();
  }
  scene.p_WE = frames_.X[0].p;
  gamma_.setZero(count());
  if (!base.rig().on_cuboid()) {
    scene.X = frames_.X;
    extended_.set_ends(scene);
    return {};
  }
  const std::optional<int> link = base.cuboid_link();
  double link_rad = 0.0;
  if (link) {
    const auto frame = static_cast<std::size_t>(*link);
    const auto& R = frames_.X[frame].R;
    link_rad = std::atan2(R(1, 0), R(0, 0));
    gamma_ =
        frames_.by_v[frame].bottomRows<1>() * v_ + frames_.by_q[frame].bottomRows<1>() * q_;
  }
  scene.gamma_rad = extended_.cuboid_angle(model, trial, link_rad);
  const bool given = base.rig().cuboid.mount == geometry::Mount::kFree;
  const Eigen::Index clamp = extended_.base().robot_parameter_count();
  if (model.size() > clamp && !(given && trial.gamma_rad)) gamma_[clamp] += 1.0;
  return {};
}

void ExtendedSlopes::differentiate_dials(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
    Slopes& slopes) {
  const auto dials = static_cast<Eigen::Index>(extended_.base().rig().dials.size());
  Scene start = scene;  // before `measure`, which moves the tool and the cuboid
  const auto measured = [&](Eigen::VectorXd& into) {
    moved_.q = start.q;
    moved_.v = start.v;
    moved_.p_WE = start.p_WE;
    moved_.gamma_rad = start.gamma_rad;
    extended_.measure(model, trial, sample, moved_);
    into.resize(3 + dials);
    into.head<3>() = moved_.p_WE;
    for (Eigen::Index i = 0; i < dials; ++i) {
      into[3 + i] = moved_.reading[static_cast<std::size_t>(i)];
    }
  };
  Eigen::VectorXd slope;
  slopes.reading.setZero(dials, count());
  slopes.tool.setZero(3, count());
  const auto add = [&](const auto& inner) {
    slopes.tool += slope.head<3>() * inner;
    slopes.reading += slope.tail(dials) * inner;
  };
  for (int axis = 0; axis < 2; ++axis) {
    central(start.p_WE[axis], kStep_mm, measured, slope);
    add(p_.row(axis));
  }
  central(start.gamma_rad, kStep_rad, measured, slope);
  add(gamma_);
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    ActiveEffect& active = extended_.effects()[numbers_[i].effect];
    const auto& effect = *active.effect;
    if (!effect.after_kinematics && !effect.before_contact && !effect.after_reading) continue;
    const Eigen::Index column =
        extended_.base().parameter_count() + static_cast<Eigen::Index>(i);
    central(active.x[numbers_[i].parameter], numbers_[i].step, measured, slope);
    slopes.tool.col(column) += slope.head<3>();
    slopes.reading.col(column) += slope.tail(dials);
  }
  // Hardly any effect looks back at the joints or the parameters from here; one that does is
  // found by moving them all.
  Eigen::VectorXd here, elsewhere;
  measured(here);
  const Eigen::VectorXd q = start.q;
  const Eigen::VectorXd v = start.v;
  start.q.array() += kStep_rad;
  start.v.array() += kStep_mm;
  measured(elsewhere);
  start.q = q;
  start.v = v;
  if (here != elsewhere) {
    for (Eigen::Index k = 0; k < start.q.size(); ++k) {
      central(start.q[k], kStep_rad, measured, slope);
      add(q_.row(k));
    }
    for (Eigen::Index k = 0; k < start.v.size(); ++k) {
      central(start.v[k], step_of(extended_.base(), k), measured, slope);
      add(v_.row(k));
    }
  }
  extended_.measure(model, trial, sample, scene);
}

void ExtendedSlopes::differentiate_ends(
    const Trial& trial, const Scene& scene, Eigen::MatrixXd& end, Eigen::MatrixXd& stands) {
  if (std::exchange(frames_.tool_only, false)) {  // it has a pose: differentiate_pose was here
    static_cast<void>(
        extended_.base().robot().forward_derivative(scene.v, scene.q, trial.assembly, frames_));
  }
  const bool chain = !extended_.base().robot().kind->has_passive_joints;
  const std::size_t last = chain ? frames_.X.size() - 1 : 0;
  end = frames_.by_v[last].topRows<3>() * v_ + frames_.by_q[last].topRows<3>() * q_;
  stands.setZero(3, count());
  for (std::size_t axis = 0; axis < extended_.stands().size(); ++axis) {
    stands.row(static_cast<Eigen::Index>(axis)) = v_.row(extended_.stands()[axis]);
  }
}

Eigen::MatrixXd ExtendedSlopes::differentiate_move(
    const Trial& trial, const Circumstance& sample, Scene& scene) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(6, count());
  const auto moves = [](const ActiveEffect& each) {
    return static_cast<bool>(each.effect->after_kinematics);
  };
  if (std::ranges::none_of(extended_.effects(), moves)) return result;
  Scene start = scene;
  const auto moved = [&](Eigen::VectorXd& into) {
    moved_.q = start.q;
    moved_.v = start.v;
    moved_.p_WE = start.p_WE;
    moved_.stands_mm = start.stands_mm;
    moved_.end_mm = start.end_mm;
    extended_.move_tool(sample, moved_);
    into.resize(6);
    into << moved_.p_WE, moved_.turn_rad;
  };
  Eigen::VectorXd slope;
  for (int axis = 0; axis < 3; ++axis) {
    central(start.p_WE[axis], kStep_mm, moved, slope);
    slope[axis] -= 1.0;  // the frame's own
    result += slope * p_.row(axis);
  }
  // Hardly any effect looks at the arm as a whole; one that does is found by moving its end.
  Eigen::VectorXd here, elsewhere;
  moved(here);
  start.end_mm.array() += kStep_mm;
  moved(elsewhere);
  start.end_mm = scene.end_mm;
  if (here != elsewhere) {
    Eigen::MatrixXd end, stands;
    differentiate_ends(trial, scene, end, stands);
    for (int axis = 0; axis < 3; ++axis) {
      central(start.end_mm[axis], kStep_mm, moved, slope);
      result += slope * end.row(axis);
      central(start.stands_mm[axis], kStep_mm, moved, slope);
      result += slope * stands.row(axis);
    }
  }
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    ActiveEffect& active = extended_.effects()[numbers_[i].effect];
    if (!active.effect->after_kinematics) continue;
    central(active.x[numbers_[i].parameter], numbers_[i].step, moved, slope);
    result.col(extended_.base().parameter_count() + static_cast<Eigen::Index>(i)) += slope;
  }
  return result;
}

void ExtendedSlopes::differentiate_channels(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
    Slopes& slopes) {
  const ForwardModel& base = extended_.base();
  const Eigen::MatrixXd move = differentiate_move(trial, sample, scene);
  extended_.measure(model, trial, sample, scene);  // fills scene.seen, too
  const geometry::Observation& seen = scene.seen;
  slopes.tool = p_ + move.topRows<3>();
  const std::vector<Eigen::Index> read = channels_read(trial, seen.reading.size());
  Eigen::MatrixXd reading = Eigen::MatrixXd::Zero(std::ssize(read), count());
  reading.middleCols(
      base.robot_parameter_count(), base.parameter_count() - base.robot_parameter_count()) =
      seen.by_x(read, Eigen::all);
  for (std::size_t k = 0; k < frames_.X.size(); ++k) {
    const Eigen::Matrix<double, Eigen::Dynamic, 6> by_frame =
        seen.by_frames.middleCols<6>(6 * static_cast<Eigen::Index>(k))(read, Eigen::all);
    if (by_frame.isZero(0.0)) continue;
    reading.noalias() += (by_frame * frames_.by_q[k]).eval() * q_;
    if (bends_parameters_) {
      reading.noalias() += (by_frame * frames_.by_v[k]).eval() * v_;
    } else {
      reading.leftCols(v_.rows()).noalias() += by_frame * frames_.by_v[k];
    }
    if (!move.isZero(0.0)) reading.noalias() += by_frame * move;
    // A turn of all frames about the tool moves the others.
    const Eigen::Vector3d lever = frames_.X[k].p - frames_.X[0].p;
    if (!lever.isZero(0.0)) {
      reading.noalias() -=
          by_frame.leftCols<3>() * geometry::skew<double>(lever) * move.bottomRows<3>();
    }
  }
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    ActiveEffect& active = extended_.effects()[numbers_[i].effect];
    if (!active.effect->after_reading) continue;
    const auto as_read = [&](Eigen::VectorXd& into) {
      moved_ = scene;
      moved_.reading.assign(seen.reading.begin(), seen.reading.end());
      active.effect->after_reading(active.x, active.place, sample, moved_);
      into =
          Eigen::Map<const Eigen::VectorXd>(moved_.reading.data(), std::ssize(moved_.reading));
    };
    Eigen::VectorXd slope;
    central(active.x[numbers_[i].parameter], numbers_[i].step, as_read, slope);
    reading.col(base.parameter_count() + static_cast<Eigen::Index>(i)) += slope(read);
  }
  slopes.reading.resize(seen.reading.size(), count());
  slopes.reading(read, Eigen::all) = reading;
}

ExtendedSlopes::Reached ExtendedSlopes::at(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
    Slopes& slopes) {
  if (auto reached = differentiate_joints(model, trial, sample, scene); !reached)
    return reached;
  if (auto reached = differentiate_pose(model, trial, scene); !reached) return reached;
  if (extended_.base().rig().on_cuboid()) {
    differentiate_dials(model, trial, sample, scene, slopes);
  } else {
    differentiate_channels(model, trial, sample, scene, slopes);
  }
  return {};
}

}  // namespace sixdial::simulation
