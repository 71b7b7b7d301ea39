#include "session/trials.h"

#include <cmath>
#include <optional>

#include "geometry/tool.h"
#include "session/sample_layout.h"

namespace sixdial::session {
namespace {

using geometry::Assembly;
using geometry::CuboidPose;

struct NominalPose {
  CuboidPose cuboid;
  Assembly assembly = Assembly::kLeft;
};

/// Where the nominal robot holds the cuboid, clamp angle 0.
std::optional<NominalPose> nominal_pose(
    const geometry::Rig& rig, const Eigen::VectorXd& q, Assembly assembly) {
  const auto pose = geometry::planar_pose(
      *rig.robot.model, rig.robot.nominal, q, assembly, geometry::cuboid_link(rig));
  const auto reference = geometry::reference_link_angle(rig);
  if (!pose || !reference) return std::nullopt;
  return NominalPose{
      {pose->p_WE, geometry::cuboid_angle(rig, *reference, pose->link_rad, 0.0)}, assembly};
}

std::vector<geometry::DialReading> readings_of(const geometry::Rig& rig, const Sample& sample) {
  std::vector<geometry::DialReading> readings;
  if (!rig.on_cuboid()) return readings;  // channels of another instrument
  for (std::size_t i = 0; i < rig.dials.size() && i < sample.channels.size(); ++i) {
    const ChannelValue& dial = sample.channels[i];
    if (!dial.value || dial.quality == Quality::kBad) continue;
    if (!in_contact(rig.dials[i], *dial.value)) continue;
    readings.push_back({static_cast<int>(i), *dial.value, reading_sigma_mm(rig.dials[i])});
  }
  return readings;
}

/// Mean square difference [mm^2] between readings and what the pose predicts.
double misfit(
    const geometry::Rig& rig, const std::vector<geometry::DialReading>& readings,
    const CuboidPose& pose) {
  double sum = 0.0;
  for (const geometry::DialReading& reading : readings) {
    const auto& dial = rig.dials[static_cast<std::size_t>(reading.dial)].geometry;
    const int face = geometry::face_towards(dial, pose.gamma_rad);
    const auto contact = geometry::contact_on_face(dial, pose, rig.cuboid.side_mm, face);
    const double difference = reading.displacement_mm - contact.displacement_mm;
    sum += difference * difference;
  }
  return sum / static_cast<double>(readings.size());
}

/// The assembly whose readings are nearest to the sample's; empty: it has none in contact, or
/// an assembly has no pose.
std::optional<Assembly> assembly_by_readings(const geometry::Rig& rig, const Sample& sample) {
  const auto readings = readings_of(rig, sample);
  if (readings.empty()) return std::nullopt;
  std::optional<Assembly> nearest;
  double least = 0.0;
  for (const geometry::BranchInfo& each : rig.robot.model->assemblies) {
    const auto assembly = static_cast<Assembly>(each.number);
    const auto pose = nominal_pose(rig, sample.q, assembly);
    if (!pose) return std::nullopt;
    const double miss = misfit(rig, readings, pose->cuboid);
    if (nearest && miss >= least) continue;
    nearest = assembly;
    least = miss;
  }
  return nearest;
}

/// Of each coordinate: the row's own deviation, else the rig's. 0 x 0: nobody says one.
Eigen::MatrixXd covariance_of(
    const geometry::Rig& rig, const Sample& sample, Eigen::Index axes) {
  Eigen::VectorXd sd_mm = Eigen::VectorXd::Constant(axes, rig.instrument.sd_mm);
  if (std::ssize(sample.position_sd_mm) == axes) {
    for (std::size_t i = 0; i < sample.position_sd_mm.size(); ++i) {
      double& each = sd_mm[static_cast<Eigen::Index>(i)];
      each = sample.position_sd_mm[i].value_or(each);
    }
  }
  if (!(sd_mm.minCoeff() > 0.0)) return {};
  return sd_mm.cwiseAbs2().asDiagonal();
}

/// By channel of an instrument that shows more than dials and coordinates.
std::vector<std::optional<double>> all_channels(
    const geometry::Rig& rig, const Sample& sample) {
  std::vector<std::optional<double>> reading;
  if (layout_of(rig).gives_position) {
    reading.resize(static_cast<std::size_t>(rig.instrument.dimensions));
    for (std::size_t i = 0; i < reading.size(); ++i) {
      if (rig.dials.size() + i >= sample.channels.size()) break;
      const ChannelValue& channel = sample.channels[rig.dials.size() + i];
      if (channel.quality != Quality::kBad) reading[i] = channel.value;
    }
  }
  reading.insert(reading.end(), sample.others.begin(), sample.others.end());
  return reading;
}

}  // namespace

bool in_contact(const geometry::Dial& dial, double displacement_mm) {
  const double band_mm = 3 * dial.accuracy_mm + 3 * dial.repeatability_mm;
  return displacement_mm > band_mm && displacement_mm < dial.geometry.travel_mm - band_mm;
}

double reading_sigma_mm(const geometry::Dial& dial) {
  return std::max(dial.repeatability_mm, dial.resolution_mm / std::sqrt(12.0));
}

Assembly assembly_of(const geometry::Rig& rig, const Sample& sample) {
  const geometry::Tool tool(rig);
  for (const auto& point : {sample.target_mm, position_of(sample, rig.dials.size())}) {
    if (!point) continue;
    const auto assembly = tool.assembly_at(rig.robot.nominal, sample.q, *point);
    if (assembly) return *assembly;
  }
  return assembly_by_readings(rig, sample).value_or(rig.robot.assembly);
}

simulation::Trial trial_of(
    const geometry::Rig& rig, const Sample& sample, int index, std::optional<TimePoint> start) {
  simulation::Trial trial;
  trial.sample = index;
  trial.point = sample.point;
  trial.repeat = sample.repeat;
  trial.q = sample.q;
  trial.assembly = assembly_of(rig, sample);
  if (sample.target_mm) trial.target_mm = *sample.target_mm;
  if (sample.time_utc && start) {
    trial.time_s = std::chrono::duration<double>(*sample.time_utc - *start).count();
  }
  trial.temperature_c = sample.temperature_c;
  for (const std::optional<int>& side : sample.approach) {
    trial.approach.push_back(side.value_or(0));
  }
  trial.reading.resize(rig.dials.size());
  const auto readings = readings_of(rig, sample);
  for (const geometry::DialReading& reading : readings) {
    trial.reading[static_cast<std::size_t>(reading.dial)] = reading.displacement_mm;
  }
  const auto nominal =
      readings.empty() ? std::nullopt : nominal_pose(rig, sample.q, trial.assembly);
  if (nominal) {
    const auto dials = rig.dial_geometries();
    const auto estimate = geometry::best_active_three(
        dials, readings, rig.cuboid.side_mm, nominal->cuboid.gamma_rad);
    if (estimate) {
      trial.position_mm = estimate->pose.p_WE;
      trial.position_covariance = estimate->covariance.topLeftCorner<2, 2>();
      trial.gamma_rad = estimate->pose.gamma_rad;
      trial.position_channels = estimate->dials;
    }
  }
  // An instrument's position goes before the dials'.
  if (const auto position_mm = position_of(sample, rig.dials.size())) {
    trial.position_mm = *position_mm;
    trial.position_covariance = covariance_of(rig, sample, position_mm->size());
    trial.position_channels.clear();
  }
  if (!sample.others.empty()) trial.reading = all_channels(rig, sample);
  return trial;
}

std::vector<simulation::Trial> trials_of(const Session& session, std::string_view set_name) {
  std::optional<TimePoint> start;
  for (const Sample& sample : session.samples) {
    if (sample.time_utc && (!start || *sample.time_utc < *start)) start = sample.time_utc;
  }
  std::vector<simulation::Trial> trials;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const Sample& sample = session.samples[i];
    if (sample.left_out || (!set_name.empty() && sample.set != set_name)) continue;
    trials.push_back(trial_of(session.rig, sample, static_cast<int>(i), start));
  }
  return trials;
}

}  // namespace sixdial::session
