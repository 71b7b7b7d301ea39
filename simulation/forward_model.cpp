#include "simulation/forward_model.h"

#include <algorithm>
#include <utility>

namespace sixdial::simulation {

std::vector<geometry::ParameterInfo> parameters_of(const geometry::Rig& rig) {
  return ForwardModel(rig).parameters();
}

ForwardModel::ForwardModel(geometry::Rig rig)
    : rig_(std::move(rig)), instrument_(geometry::instrument_of(rig_)) {
  parameters_ = rig_.robot.model->parameters;
  parameters_.insert(
      parameters_.end(), instrument_->parameters.begin(), instrument_->parameters.end());
  // The simulation with effects needs it of a cuboid; elsewhere there is no link to refer to.
  cuboid_link_ = geometry::cuboid_link(rig_);
  reference_angle_rad_ = geometry::reference_link_angle(rig_).value_or(0.0);
}

std::optional<Eigen::Index> ForwardModel::find(std::string_view parameter) const {
  const auto found = std::ranges::find(parameters_, parameter, &geometry::ParameterInfo::name);
  if (found == parameters_.end()) return std::nullopt;
  return found - parameters_.begin();
}

ModelVector ForwardModel::nominal() const {
  ModelVector model(parameter_count());
  model << rig_.robot.nominal, instrument_->nominal;
  return model;
}

tl::expected<Prediction, geometry::KinematicTrouble> ForwardModel::predict(
    const ModelVector& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
    std::optional<double> free_gamma_rad, bool with_contact) const {
  Prediction result;
  const auto reached = predict(model, q, assembly, free_gamma_rad, with_contact, result);
  if (!reached) return tl::unexpected(reached.error());
  return result;
}

geometry::Reached ForwardModel::predict(
    const ModelVector& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
    std::optional<double> free_gamma_rad, bool with_contact, Prediction& into) const {
  const geometry::RobotModel& robot = *rig_.robot.model;
  const Eigen::Index of_robot = robot_parameter_count();
  const Eigen::Index of_instrument = instrument_->parameter_count();
  if (into.frames.X.size() != robot.frames.size()) into.frames = geometry::Frames(robot);
  const auto reached = robot.forward_derivative(model.head(of_robot), q, assembly, into.frames);
  if (!reached) return reached;

  into.position_J.setZero(3, parameter_count());
  into.position_J.leftCols(of_robot) = into.frames.by_v[0].topRows<3>();

  geometry::Observation& seen = into.observation;
  const std::span<const double> unknowns =
      free_gamma_rad ? std::span(&*free_gamma_rad, 1) : std::span<const double>();
  instrument_->kind->observe(
      *instrument_, std::span(model.data() + of_robot, static_cast<std::size_t>(of_instrument)),
      unknowns, into.frames.X, with_contact, seen);
  into.gamma_rad = seen.gamma_rad;
  into.reading = seen.reading;
  into.in_contact = with_contact ? seen.shows : std::vector<bool>();
  if (seen.by_unknowns.cols() > 0) into.reading_J_gamma = seen.by_unknowns.col(0);

  into.reading_J.setZero(instrument_->channel_count(), parameter_count());
  into.reading_J.rightCols(of_instrument) = seen.by_x;
  for (std::size_t frame = 0; frame < robot.frames.size(); ++frame) {
    const auto by_frame = seen.by_frames.middleCols<6>(6 * static_cast<Eigen::Index>(frame));
    if (by_frame.isZero(0.0)) continue;  // the instrument does not look at it
    into.reading_J.leftCols(of_robot).noalias() +=
        by_frame.lazyProduct(into.frames.by_v[frame]);
  }
  return {};
}

}  // namespace sixdial::simulation
