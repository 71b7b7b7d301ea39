#include "session/live_channels.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/instrument_kind.h"
#include "session/trials.h"

namespace sixdial::session {
namespace {

/// What a reading of 1 mm is on the channel.
struct LiveKind {
  std::string_view kind;     // of the instrument
  std::string_view channel;  // what stands before a place's name
  double per_reading = 1.0;
};
constexpr const char* kNoColumn = "no column in the file";
constexpr int kSteps = 6;  // from the linear solution, quadratic
constexpr std::array kKinds{
    LiveKind{"distance", "distance_", 1.0}, LiveKind{"probe", "probe_", -1.0}};

const LiveKind* live_kind(const geometry::Rig& rig) {
  if (rig.dials.empty()) return nullptr;
  const auto* const found = std::ranges::find(kKinds, rig.instrument.kind, &LiveKind::kind);
  return found == kKinds.end() ? nullptr : found;
}

/// Where wires of these lengths from these places meet, by least squares, and how well it is
/// known for lengths of deviation 1 (3 x 3). Empty: fewer than four, or all places in a plane.
struct Meeting {
  Eigen::Vector3d p_mm;
  Eigen::Matrix3d covariance;
};
std::optional<Meeting> meeting(
    const std::vector<Eigen::Vector3d>& from_mm, const std::vector<double>& length_mm) {
  const auto n = std::ssize(from_mm);
  if (from_mm.size() < kLeastWires) return std::nullopt;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& a : from_mm) middle += a / static_cast<double>(n);
  // |p|^2 - 2 a.p + |a|^2 = d^2 is linear in p and |p|^2.
  Eigen::MatrixXd A(n, 4);
  Eigen::VectorXd b(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Vector3d a = from_mm[static_cast<std::size_t>(k)] - middle;
    const double d = length_mm[static_cast<std::size_t>(k)];
    A.row(k) << -2 * a.x(), -2 * a.y(), -2 * a.z(), 1.0;
    b[k] = d * d - a.squaredNorm();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(A);
  solver.setThreshold(1e-6);
  if (solver.rank() < 4) return std::nullopt;
  Eigen::Vector3d p = solver.solve(b).head<3>() + middle;
  Eigen::MatrixXd J(n, 3);
  Eigen::VectorXd e(n);
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Vector3d along = p - from_mm[static_cast<std::size_t>(k)];
      if (!(along.norm() > 0.0)) return std::nullopt;
      J.row(k) = along.normalized();
      e[k] = length_mm[static_cast<std::size_t>(k)] - along.norm();
    }
    p += J.colPivHouseholderQr().solve(e);
  }
  if (!p.allFinite()) return std::nullopt;
  return Meeting{p, (J.transpose() * J).inverse()};
}

/// The anchor that a wire's dial reads.
const geometry::ReferencePoint* anchor_of(
    const geometry::Rig& rig, const geometry::Dial& dial) {
  const auto& anchors = rig.instrument.anchors;
  const auto found = std::ranges::find(anchors, dial.id, &geometry::ReferencePoint::name);
  return found == anchors.end() ? nullptr : &*found;
}

/// x, y, z with their deviations in place of the wires' readings.
Sample with_position(const geometry::Rig& rig, Sample sample) {
  if (sample.channels.size() > rig.dials.size()) {  // positions came with it
    set_position(sample, 0, position_of(sample, rig.dials.size()));
    return sample;
  }
  std::vector<Eigen::Vector3d> from_mm;
  std::vector<double> length_mm;
  double sd_mm = 0.0;
  for (std::size_t i = 0; i < rig.dials.size() && i < sample.channels.size(); ++i) {
    const ChannelValue& reading = sample.channels[i];
    const geometry::ReferencePoint* anchor = anchor_of(rig, rig.dials[i]);
    if (anchor == nullptr || !anchor->at_mm || !reading.value ||
        reading.quality == Quality::kBad) {
      continue;
    }
    from_mm.push_back(*anchor->at_mm);
    length_mm.push_back(*reading.value);
    sd_mm = std::max(sd_mm, reading_sigma_mm(rig.dials[i]));
  }
  sample.channels.clear();
  sample.position_sd_mm.clear();
  const auto found = meeting(from_mm, length_mm);
  if (!found) return sample;
  set_position(sample, 0, Position(found->p_mm));
  for (int axis = 0; axis < 3; ++axis) {
    sample.position_sd_mm.emplace_back(sd_mm * std::sqrt(found->covariance(axis, axis)));
  }
  return sample;
}

std::optional<std::string> wires_fault(const geometry::Rig& rig) {
  for (const geometry::Dial& dial : rig.dials) {
    const geometry::ReferencePoint* anchor = anchor_of(rig, dial);
    if (anchor == nullptr) {
      return fmt::format(
          "dial '{}' is the name of no [[anchor]]: each dial reads the wire of its name",
          dial.id);
    }
    if (!anchor->at_mm) {
      return fmt::format("anchor '{}' has no at_mm: positions need its place", dial.id);
    }
  }
  if (rig.dials.size() >= kLeastWires) return std::nullopt;
  return fmt::format("positions need {} wires or more", kLeastWires);
}

/// The channel of each dial among the instrument's; -1: it has none of that name.
std::vector<int> channels_of(const geometry::Rig& rig, const LiveKind& kind) {
  const auto instrument = geometry::instrument_of(rig);
  std::vector<int> channels;
  for (const geometry::Dial& dial : rig.dials) {
    channels.push_back(
        instrument->find_channel(fmt::format("{}{}", kind.channel, dial.id)).value_or(-1));
  }
  return channels;
}

}  // namespace

bool has_live_positions(const geometry::Rig& rig) {
  return rig.instrument.kind == "position" && !rig.dials.empty() &&
         !rig.instrument.anchors.empty();
}

bool has_live_channels(const geometry::Rig& rig) {
  return live_kind(rig) != nullptr || has_live_positions(rig);
}

std::optional<std::string> live_channel_fault(const geometry::Rig& rig) {
  if (has_live_positions(rig)) return wires_fault(rig);
  const LiveKind* kind = live_kind(rig);
  if (kind == nullptr) return std::nullopt;
  const std::vector<int> channels = channels_of(rig, *kind);
  const char* const place = kind->kind == "probe" ? "surface" : "anchor";
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i] >= 0) continue;
    return fmt::format(
        "dial '{}' is the name of no [[{}]]: each dial reads the place of its name",
        rig.dials[i].id, place);
  }
  const auto instrument = geometry::instrument_of(rig);
  for (int c = 0; c < static_cast<int>(instrument->channels.size()); ++c) {
    if (std::ranges::find(channels, c) != channels.end()) continue;
    const std::string& name = instrument->channels[static_cast<std::size_t>(c)].name;
    return fmt::format("no [[dial]] reads {} '{}'", place, name.substr(kind->channel.size()));
  }
  return std::nullopt;
}

geometry::Rig as_instrument(geometry::Rig rig) {
  if (has_live_channels(rig)) rig.dials.clear();
  return rig;
}

Sample as_instrument(const geometry::Rig& rig, Sample sample) {
  if (has_live_positions(rig)) return with_position(rig, std::move(sample));
  const LiveKind* kind = live_kind(rig);
  if (kind == nullptr) return sample;
  const std::vector<int> channels = channels_of(rig, *kind);
  sample.others.assign(geometry::instrument_of(rig)->channels.size(), std::nullopt);
  for (std::size_t i = 0; i < channels.size() && i < sample.channels.size(); ++i) {
    const ChannelValue& reading = sample.channels[i];
    if (channels[i] < 0 || !reading.value || reading.quality == Quality::kBad) continue;
    sample.others[static_cast<std::size_t>(channels[i])] = kind->per_reading * *reading.value;
  }
  sample.channels.clear();
  return sample;
}

Sample as_dials(const geometry::Rig& rig, Sample sample) {
  if (has_live_positions(rig)) {  // from where it was measured nobody knows the wires' lengths
    sample.channels.insert(
        sample.channels.begin(), rig.dials.size(),
        {.quality = Quality::kBad, .reason = kNoColumn});
    return sample;
  }
  const LiveKind* kind = live_kind(rig);
  if (kind == nullptr || sample.others.empty()) return sample;
  const std::vector<int> channels = channels_of(rig, *kind);
  sample.channels.assign(channels.size(), {.quality = Quality::kBad, .reason = kNoColumn});
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i] < 0 || static_cast<std::size_t>(channels[i]) >= sample.others.size())
      continue;
    const auto& shown = sample.others[static_cast<std::size_t>(channels[i])];
    if (shown) sample.channels[i] = {.value = *shown / kind->per_reading};
  }
  return sample;
}

Session as_instrument(Session session) {
  if (!has_live_channels(session.rig)) return session;
  for (Sample& sample : session.samples) {
    sample = as_instrument(session.rig, std::move(sample));
  }
  session.rig = as_instrument(std::move(session.rig));
  return session;
}

}  // namespace sixdial::session
